(* Theorem 1: boxes that one side of one axis separates at both ends stay farther apart than g. *)
(* B3: so do sets that a plane of any direction separates at both ends. *)
(* N2: one plane keeps the corners beyond D. *)
(* code src/bvh/traverse.cpp
 *   const auto above = hn::Min(hn::Add(load(b, 0, 0), load(a, 0, 1)), hn::Add(load(b, 1, 0), load(a, 1, 1)));
 *   separated |= !hn::AllFalse(d, hn::Or(hn::Gt(above, m), hn::Gt(below, m)));
 * code src/certificate/separating_plane.cpp
 *   return s.squared_length > 1e-30f && s.distance[s.nearer_end] > gap * std::sqrt(s.squared_length);
 * code src/ccd/conservative_advancement.cpp
 *   MarkSeparated(hn::And(now, end));
 *)
Require Import Reals Lra Psatz.
Open Scope R_scope.

Record vec := V { x : R; y : R; z : R }.
Definition add u v := V (x u + x v) (y u + y v) (z u + z v).
Definition sub u v := V (x u - x v) (y u - y v) (z u - z v).
Definition mul s u := V (s * x u) (s * y u) (s * z u).
Definition dot u v := x u * x v + y u * y v + z u * z v.
Definition norm u := sqrt (dot u u).
Definition mix s u v := add (mul (1 - s) u) (mul s v).

(* The convex hull of a set of points: an edge or triangle is that of its vertices. *)
Inductive hull (P : vec -> Prop) : vec -> Prop :=
| hull_point p : P p -> hull P p
| hull_mix s p q : 0 <= s <= 1 -> hull P p -> hull P q -> hull P (mix s p q).

(* A set of moving vertices: each has its place at both ends of the step. *)
Definition moving := vec -> vec -> Prop.
Definition at_time (S : moving) t p := exists a e, S a e /\ p = mix t a e.

Lemma dot_mix n s p q : dot n (mix s p q) = (1 - s) * dot n p + s * dot n q.
Proof. unfold dot, mix, add, mul; simpl; ring. Qed.

Lemma hull_above (P : vec -> Prop) n c : (forall p, P p -> dot n p > c) -> forall p, hull P p -> dot n p > c.
Proof.
  intros above p H. induction H as [p Hp | s p q Hs _ IHp _ IHq]; [auto|].
  rewrite dot_mix. destruct (Rle_lt_dec s (1 / 2)); nra.
Qed.

Lemma hull_below (P : vec -> Prop) n c : (forall p, P p -> dot n p <= c) -> forall p, hull P p -> dot n p <= c.
Proof.
  intros below p H. induction H as [p Hp | s p q Hs _ IHp _ IHq]; [auto|].
  rewrite dot_mix. nra.
Qed.

Lemma norm_nonneg u : 0 <= norm u.
Proof. apply sqrt_pos. Qed.

Lemma norm_square u : norm u * norm u = dot u u.
Proof. apply sqrt_sqrt. unfold dot. nra. Qed.

Lemma cauchy_schwarz u v : dot u v <= norm u * norm v.
Proof.
  destruct (Rle_or_lt (dot u v) 0) as [H | H].
  - pose proof (norm_nonneg u). pose proof (norm_nonneg v). nra.
  - apply Rsqr_incr_0_var; [|pose proof (norm_nonneg u); pose proof (norm_nonneg v); nra].
    unfold Rsqr.
    replace (norm u * norm v * (norm u * norm v)) with ((norm u * norm u) * (norm v * norm v)) by ring.
    rewrite !norm_square. unfold dot.
    assert (0 <= (x u * y v - y u * x v) ^ 2 + (y u * z v - z u * y v) ^ 2 + (z u * x v - x u * z v) ^ 2)
      by (repeat apply Rplus_le_le_0_compat; apply pow2_ge_0).
    nra.
Qed.

Definition beyond (S : moving) n c0 c1 := forall a e, S a e -> dot n a >= c0 /\ dot n e >= c1.
Definition before (S : moving) n c0 c1 := forall a e, S a e -> dot n a <= c0 /\ dot n e <= c1.

(* low and high are bounds of the projections of B and A, at both ends. *)
Theorem B3 A B n g low0 low1 high0 high1 :
  beyond B n low0 low1 -> before A n high0 high1 -> 0 < norm n ->
  low0 - high0 > g * norm n -> low1 - high1 > g * norm n ->
  forall t p q, 0 <= t <= 1 -> hull (at_time A t) p -> hull (at_time B t) q -> norm (sub q p) > g.
Proof.
  intros HB HA Hn Hs He t p q Ht Hp Hq.
  assert (P : dot n p <= (1 - t) * high0 + t * high1).
  { revert p Hp. apply hull_below. intros p (a & e & S & ->). rewrite dot_mix. destruct (HA a e S). nra. }
  assert (Q : forall eps, 0 < eps -> dot n q > (1 - t) * low0 + t * low1 - eps).
  { intros eps Heps. revert q Hq. apply hull_above. intros q (a & e & S & ->).
    rewrite dot_mix. destruct (HB a e S). nra. }
  pose proof (cauchy_schwarz n (sub q p)) as C.
  replace (dot n (sub q p)) with (dot n q - dot n p) in C by (unfold dot, sub; simpl; ring).
  set (slack := (1 - t) * (low0 - high0 - g * norm n) + t * (low1 - high1 - g * norm n)).
  assert (0 < slack) by (unfold slack; destruct (Rle_lt_dec t (1 / 2)); nra).
  specialize (Q slack ltac:(assumption)).
  assert (g * norm n < norm n * norm (sub q p)) by (unfold slack in Q; nra).
  nra.
Qed.

Theorem Theorem_1 A B n g low0 low1 high0 high1 :
  n = V 1 0 0 \/ n = V 0 1 0 \/ n = V 0 0 1 ->
  beyond B n low0 low1 -> before A n high0 high1 -> low0 - high0 > g -> low1 - high1 > g ->
  forall t p q, 0 <= t <= 1 -> hull (at_time A t) p -> hull (at_time B t) q -> norm (sub q p) > g.
Proof.
  intros Hn HB HA Hs He.
  assert (N : norm n = 1).
  { unfold norm, dot. destruct Hn as [-> | [-> | ->]]; simpl;
      match goal with |- sqrt ?e = 1 => replace e with 1 by ring end; apply sqrt_1. }
  apply (B3 A B n g low0 low1 high0 high1); trivial; rewrite N; lra.
Qed.

(* The origin is one set, the corners are the other one. *)
Theorem N2 (corners : moving) n D :
  0 < norm n -> (forall a e, corners a e -> dot n a > D * norm n /\ dot n e > D * norm n) ->
  forall t p, 0 <= t <= 1 -> hull (at_time corners t) p -> norm p > D.
Proof.
  intros Hn H t p Ht Hp.
  assert (dot n p > D * norm n).
  { revert p Hp. apply hull_above. intros p (a & e & S & ->). rewrite dot_mix.
    destruct (H a e S). destruct (Rle_lt_dec t (1 / 2)); nra. }
  pose proof (cauchy_schwarz n p). nra.
Qed.

Print Assumptions B3.
Print Assumptions Theorem_1.
Print Assumptions N2.
