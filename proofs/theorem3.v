(* Theorem 3: a free first frame and free steps make free frames. *)
(* F1: what stays apart in a motion stays apart in steps whose vertices lie near it. *)
(* N4: the search keeps a time before which nothing touches. *)
(* code src/ccd/conservative_advancement.cpp
 *   t_ = hn::IfThenElse(free, t, t_);
 *   separated_ = hn::Or(separated_, free);
 * code src/check/look_ahead.cpp
 *   const double search_distance = distance_ + 2 * slack;
 *)
Require Import Reals Lra Psatz List.
Import ListNotations.
Open Scope R_scope.

(* Theorem 3. f is the distance of two closed sets that move continuously in [0,1]. pairs are the distances of their
   features without a common vertex. Hypothesis, by hand (V2): while the sets do not meet, f is that of one such pair. *)
Definition continuous_at (f : R -> R) t :=
  forall eps, 0 < eps -> exists delta, 0 < delta /\ forall s, Rabs (s - t) < delta -> Rabs (f s - f t) < eps.

Lemma all_positive_near (pairs : list (R -> R)) t :
  (forall d, In d pairs -> continuous_at d t) -> (forall d, In d pairs -> 0 < d t) ->
  exists eps delta, 0 < eps /\ 0 < delta /\ forall d s, In d pairs -> Rabs (s - t) < delta -> eps <= d s.
Proof.
  induction pairs as [|d rest IH]; intros C Pos.
  - exists 1, 1. repeat split; try lra. intros d s [].
  - destruct IH as (eps & delta & He & Hd & H); [intros; apply C | intros; apply Pos |]; try (right; trivial).
    assert (Pd : 0 < d t) by (apply Pos; left; trivial).
    destruct (C d (or_introl eq_refl) (d t / 2) ltac:(lra)) as (delta' & Hd' & H').
    exists (Rmin eps (d t / 2)), (Rmin delta delta').
    repeat split; try (apply Rmin_pos; lra).
    pose proof (Rmin_l eps (d t / 2)). pose proof (Rmin_r eps (d t / 2)).
    pose proof (Rmin_l delta delta'). pose proof (Rmin_r delta delta').
    intros d' s [<- | Hin] Hs.
    + assert (A : Rabs (d s - d t) < d t / 2) by (apply H'; lra). apply Rabs_def2 in A. lra.
    + assert (eps <= d' s) by (apply (H d' s); trivial; lra). lra.
Qed.

(* The first time at which f is zero. *)
Lemma first_zero f t : 0 <= t -> (forall s, continuous_at f s) -> (forall s, 0 <= f s) -> 0 < f 0 -> f t = 0 ->
  exists s, 0 < s <= t /\ f s = 0 /\ forall r, 0 <= r < s -> 0 < f r.
Proof.
  intros Ht C N H0 Hz.
  set (E := fun s => 0 <= s <= t /\ forall r, 0 <= r <= s -> 0 < f r).
  assert (E0 : E 0).
  { split; [lra|]. intros r Hr. replace r with 0 by lra. trivial. }
  destruct (completeness E) as (m & Hup & Hleast).
  { exists t. intros s (Hs & _). lra. }
  { exists 0. trivial. }
  assert (Hm0 : 0 <= m) by (apply Hup; trivial).
  assert (Hmt : m <= t) by (apply Hleast; intros s (Hs & _); lra).
  assert (Before : forall r, 0 <= r < m -> 0 < f r).
  { intros r Hr. destruct (Rle_lt_dec (f r) 0) as [Hf | Hf]; [exfalso | trivial].
    assert (m <= r); [|lra]. apply Hleast. intros s (Hs & Hpos).
    destruct (Rle_lt_dec s r); [trivial | exfalso]. specialize (Hpos r ltac:(lra)). lra. }
  assert (Zero : f m = 0).
  { destruct (Req_dec (f m) 0) as [Z | Z]; [trivial | exfalso].
    assert (Pm : 0 < f m) by (specialize (N m); lra).
    destruct (C m (f m) Pm) as (delta & Hd & H).
    assert (m < t) by (destruct (Req_dec m t); [subst; lra | lra]).
    set (s := Rmin (m + delta / 2) t).
    assert (m < s /\ s <= m + delta / 2 /\ s <= t) as (S1 & S2 & S3).
    { unfold s. pose proof (Rmin_l (m + delta / 2) t). pose proof (Rmin_r (m + delta / 2) t).
      split; [apply Rmin_glb_lt; lra | lra]. }
    assert (s <= m); [|lra]. apply Hup. split; [lra|]. intros r Hr.
    destruct (Rlt_le_dec r m) as [Hrm | Hrm]; [apply Before; lra|].
    assert (A : Rabs (f r - f m) < f m) by (apply H; rewrite Rabs_right; lra).
    apply Rabs_def2 in A. lra. }
  exists m. repeat split; trivial. destruct (Req_dec m 0) as [-> | ?]; lra.
Qed.

Theorem Theorem_3_step f (pairs : list (R -> R)) t :
  0 <= t -> (forall s, continuous_at f s) -> (forall d s, In d pairs -> continuous_at d s) ->
  (forall s, 0 <= f s) -> (forall d s, In d pairs -> 0 <= d s) ->
  (forall s, 0 < f s -> exists d, In d pairs /\ d s = f s) ->
  0 < f 0 -> f t = 0 -> exists d s, In d pairs /\ 0 <= s <= t /\ d s = 0.
Proof.
  intros Ht Cf Cd Nf Nd V2 H0 Hz.
  destruct (first_zero f t) as (m & Hm & Zm & Before); trivial.
  destruct (Exists_dec (fun d => d m = 0) pairs (fun d => Req_EM_T (d m) 0)) as [Ex | Nx].
  - apply Exists_exists in Ex. destruct Ex as (d & Hd & Hdm). exists d, m. repeat split; trivial; lra.
  - exfalso.
    destruct (all_positive_near pairs m) as (eps & delta & He & Hd & H).
    { intros d Hin. apply Cd; trivial. }
    { intros d Hin. specialize (Nd d m Hin). destruct (Req_dec (d m) 0) as [Z | Z]; [exfalso | lra].
      apply Nx. apply Exists_exists. exists d. split; trivial. }
    destruct (Cf m eps He) as (delta' & Hd' & H').
    set (k := Rmin (Rmin delta delta') m).
    assert (0 < k /\ k <= delta /\ k <= delta' /\ k <= m) as (K0 & K1 & K2 & K3).
    { unfold k. pose proof (Rmin_l (Rmin delta delta') m). pose proof (Rmin_r (Rmin delta delta') m).
      pose proof (Rmin_l delta delta'). pose proof (Rmin_r delta delta').
      split; [repeat apply Rmin_pos; lra | lra]. }
    set (s := m - k / 2). assert (Hs : Rabs (s - m) = k / 2) by (unfold s; rewrite Rabs_left; lra).
    assert (Ps : 0 < f s) by (apply Before; unfold s; lra).
    destruct (V2 s Ps) as (d & Hin & Hds).
    assert (eps <= d s) by (apply H; trivial; lra).
    assert (A : Rabs (f s - f m) < eps) by (apply H'; lra). apply Rabs_def2 in A. lra.
Qed.

(* Frame by frame: `crosses i t` at the share t of step i; the end of a step is the start of the next one. *)
Theorem Theorem_3 (crosses : nat -> R -> Prop) (reported : nat -> Prop) :
  (forall i, crosses (S i) 0 <-> crosses i 1) ->
  (forall i t, 0 <= t <= 1 -> ~ crosses i 0 -> crosses i t -> reported i) ->
  ~ crosses 0%nat 0 -> (forall i, ~ reported i) -> forall i t, 0 <= t <= 1 -> ~ crosses i t.
Proof.
  intros Next Step First None i. induction i as [|i IH]; intros t Ht C.
  - apply (None 0%nat). apply (Step 0%nat t); trivial.
  - apply (None (S i)). apply (Step (S i) t); trivial. rewrite Next. apply IH. lra.
Qed.

(* N4. A search: what it advances over has been proven free. *)
Inductive search (free : R -> Prop) : R -> Prop :=
| search_start : search free 0
| search_advance t t' : search free t -> (forall s, t <= s <= t' -> free s) -> search free t'.

Theorem N4 (free : R -> Prop) t : search free t -> forall s, 0 <= s < t -> free s.
Proof.
  intros H. induction H as [|t t' H IH Free]; intros s Hs; [lra|].
  destruct (Rlt_le_dec s t); [apply IH | apply Free]; lra.
Qed.

(* F1, along one axis and then in space by any distance that obeys the triangle inequality. y(s) is where a vertex is in
   the motion, x where it is in the step; both go straight, so what lies within r at both ends does so between. *)
Theorem F1_vertex y0 y1 x0 x1 r t : 0 <= t <= 1 -> Rabs (x0 - y0) <= r -> Rabs (x1 - y1) <= r ->
  Rabs (((1 - t) * x0 + t * x1) - ((1 - t) * y0 + t * y1)) <= r.
Proof.
  intros Ht H0 H1.
  replace (((1 - t) * x0 + t * x1) - ((1 - t) * y0 + t * y1)) with ((1 - t) * (x0 - y0) + t * (x1 - y1)) by ring.
  eapply Rle_trans; [apply Rabs_triang|]. rewrite !Rabs_mult.
  rewrite (Rabs_right (1 - t)) by lra. rewrite (Rabs_right t) by lra.
  pose proof (Rabs_pos (x0 - y0)). nra.
Qed.

Theorem F1 (point : Type) (distance : point -> point -> R) :
  (forall p q r, distance p r <= distance p q + distance q r) ->
  (forall p q, distance p q = distance q p) ->
  forall p q p' q' g r, distance p' q' > g + 2 * r -> distance p p' <= r -> distance q q' <= r -> distance p q > g.
Proof.
  intros Triangle Symmetry p q p' q' g r H Hp Hq.
  pose proof (Triangle p' p q'). pose proof (Triangle p q q'). rewrite (Symmetry p' p) in *. lra.
Qed.

Print Assumptions Theorem_3_step.
Print Assumptions Theorem_3.
Print Assumptions N4.
Print Assumptions F1_vertex.
Print Assumptions F1.
