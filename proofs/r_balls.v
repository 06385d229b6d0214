(* R1: on a ball a linear function is at least its value at the center less rho times the length of its scaled gradient. *)
(* R2: how far a vertex can be from its node's point, and two points from each other. *)
(* R3: how near a vertex can come to a plane that moves along. *)
Require Import Reals Lra Psatz.
Open Scope R_scope.

Lemma abs_le r bound : Rabs r <= bound -> - bound <= r <= bound.
Proof. unfold Rabs. destruct (Rcase_abs r); lra. Qed.

(* Vectors of n numbers, one per mode. *)
Fixpoint sum n (f : nat -> R) := match n with O => 0 | S k => sum k f + f k end.
Definition dot n (a b : nat -> R) := sum n (fun k => a k * b k).
Definition norm n a := sqrt (dot n a a).

Lemma dot_self_nonneg n a : 0 <= dot n a a.
Proof. induction n as [|n IH]; unfold dot in *; simpl; [lra | nra]. Qed.

Lemma dot_square n a b : dot n a b * dot n a b <= dot n a a * dot n b b.
Proof.
  induction n as [|n IH]; [unfold dot; simpl; lra|].
  change (dot (S n) a b) with (dot n a b + a n * b n).
  change (dot (S n) a a) with (dot n a a + a n * a n).
  change (dot (S n) b b) with (dot n b b + b n * b n).
  pose proof (dot_self_nonneg n a) as HA. pose proof (dot_self_nonneg n b) as HB.
  set (s := dot n a b) in *. set (A := dot n a a) in *. set (B := dot n b b) in *.
  set (x := a n). set (y := b n).
  assert (H : 0 <= A * (y * y) + B * (x * x) - 2 * s * x * y); [|nra].
  destruct (Req_dec A 0) as [Z | Z].
  - assert (s = 0) by (rewrite Z in IH; nra). subst. rewrite H. rewrite Z. pose proof (Rle_0_sqr x). unfold Rsqr in *. nra.
  - apply (Rmult_le_reg_l A); [lra|]. rewrite Rmult_0_r.
    assert (0 <= (A * y - s * x) * (A * y - s * x)) by apply Rle_0_sqr.
    assert (s * s * (x * x) <= A * B * (x * x)) by (apply Rmult_le_compat_r; [apply Rle_0_sqr | trivial]). nra.
Qed.

Lemma dot_bound n a b : Rabs (dot n a b) <= norm n a * norm n b.
Proof.
  unfold norm. rewrite <- sqrt_mult by apply dot_self_nonneg. rewrite <- sqrt_Rsqr_abs.
  apply sqrt_le_1_alt. apply dot_square.
Qed.

(* sigma are the modes' deviations. c = Sigma^-1 q, so q lies in the ball of radius rho where |c| <= rho. *)
Definition scaled (sigma g : nat -> R) k := sigma k * g k.

Lemma dot_scaled n sigma g c : dot n g (scaled sigma c) = dot n (scaled sigma g) c.
Proof. unfold dot, scaled. induction n as [|n IH]; simpl; [trivial | rewrite IH; ring]. Qed.

Lemma linear_bound n sigma g c rho : norm n c <= rho ->
  Rabs (dot n g (scaled sigma c)) <= rho * norm n (scaled sigma g).
Proof.
  intros H. rewrite dot_scaled. eapply Rle_trans; [apply dot_bound|].
  rewrite Rmult_comm. apply Rmult_le_compat_r; [apply sqrt_pos | trivial].
Qed.

Theorem R1 n sigma f g c rho : norm n c <= rho ->
  f + dot n g (scaled sigma c) >= f - rho * norm n (scaled sigma g).
Proof. intros H. pose proof (linear_bound n sigma g c rho H) as B. apply abs_le in B. lra. Qed.

(* [[h + u1, u2], [u2, h - u1]] exceeds lambda I where h - |u| > lambda. *)
Theorem R1_matrix h u1 u2 lambda : h - sqrt (u1 * u1 + u2 * u2) > lambda ->
  forall a b, 0 < a * a + b * b ->
  (h + u1) * (a * a) + 2 * u2 * (a * b) + (h - u1) * (b * b) > lambda * (a * a + b * b).
Proof.
  intros H a b Hab. set (r := sqrt (u1 * u1 + u2 * u2)) in *.
  assert (Hr : 0 <= r) by apply sqrt_pos.
  assert (R : r * r = u1 * u1 + u2 * u2) by (apply sqrt_sqrt; nra).
  (* |u . (a^2 - b^2, 2 a b)| <= |u| (a^2 + b^2) *)
  set (s := a * a + b * b) in *. set (t := u1 * (a * a - b * b) + u2 * (2 * (a * b))).
  assert (T : t * t <= (r * s) * (r * s)).
  { replace ((r * s) * (r * s)) with ((r * r) * (s * s)) by ring. rewrite R. unfold t, s.
    assert (0 <= (u1 * (2 * (a * b)) - u2 * (a * a - b * b)) * (u1 * (2 * (a * b)) - u2 * (a * a - b * b)))
      by apply Rle_0_sqr. nra. }
  assert (P : 0 <= r * s) by (apply Rmult_le_pos; lra).
  assert (t >= - (r * s)) by nra.
  replace ((h + u1) * (a * a) + 2 * u2 * (a * b) + (h - u1) * (b * b)) with (h * s + t) by (unfold s, t; ring).
  nra.
Qed.

(* A point that moves by D q, with three rows of D, from d at the center. *)
Section Point.
Variable n : nat.
Variable sigma : nat -> R.
Variables D0 D1 D2 : nat -> R.
Variables d0 d1 d2 rho : R.
Variable c : nat -> R.
Hypothesis Ball : norm n c <= rho.
Let q := scaled sigma c.
Let moved D := dot n D q.
Let square := (d0 + moved D0) * (d0 + moved D0) + (d1 + moved D1) * (d1 + moved D1) + (d2 + moved D2) * (d2 + moved D2).
Let at_center := d0 * d0 + d1 * d1 + d2 * d2.
Let along k := d0 * D0 k + d1 * D1 k + d2 * D2 k.  (* D^T d *)
Let frobenius := dot n (scaled sigma D0) (scaled sigma D0) + dot n (scaled sigma D1) (scaled sigma D1)
  + dot n (scaled sigma D2) (scaled sigma D2).

Lemma dot_along : dot n along q = d0 * moved D0 + d1 * moved D1 + d2 * moved D2.
Proof. unfold moved, along, dot. clear. induction n as [|k IH]; simpl; [ring | rewrite IH; ring]. Qed.

Lemma moved_square D : moved D * moved D <= rho * rho * dot n (scaled sigma D) (scaled sigma D).
Proof.
  assert (Hr : 0 <= rho) by (eapply Rle_trans; [apply sqrt_pos | exact Ball]).
  unfold moved, q. rewrite dot_scaled. eapply Rle_trans; [apply dot_square|].
  rewrite Rmult_comm. apply Rmult_le_compat_r; [apply dot_self_nonneg|].
  replace (dot n c c) with (norm n c * norm n c) by (apply sqrt_sqrt, dot_self_nonneg).
  apply Rmult_le_compat; trivial; apply sqrt_pos.
Qed.

Theorem R2 : square <= at_center + 2 * rho * norm n (scaled sigma along) + rho * rho * frobenius.
Proof.
  pose proof (moved_square D0). pose proof (moved_square D1). pose proof (moved_square D2).
  pose proof (linear_bound n sigma along c rho Ball) as L. fold q in L. rewrite dot_along in L.
  apply abs_le in L. unfold square, at_center, frobenius. nra.
Qed.

Theorem R2_apart : square >= at_center - 2 * rho * norm n (scaled sigma along).
Proof.
  pose proof (linear_bound n sigma along c rho Ball) as L. fold q in L. rewrite dot_along in L.
  apply abs_le in L. unfold square, at_center.
  pose proof (Rle_0_sqr (moved D0)). pose proof (Rle_0_sqr (moved D1)). pose proof (Rle_0_sqr (moved D2)).
  unfold Rsqr in *. nra.
Qed.

(* N q . D q, with |N q| <= rho N' and |D q| <= rho D' as above. *)
Theorem R3_second_order n0 n1 n2 N' D' : 0 <= N' -> 0 <= D' ->
  n0 * n0 + n1 * n1 + n2 * n2 <= (rho * N') * (rho * N') -> frobenius <= D' * D' ->
  n0 * moved D0 + n1 * moved D1 + n2 * moved D2 >= - (rho * rho * N' * D').
Proof.
  intros HN HD Hn Hf.
  assert (Hr : 0 <= rho) by (eapply Rle_trans; [apply sqrt_pos | exact Ball]).
  pose proof (moved_square D0). pose proof (moved_square D1). pose proof (moved_square D2).
  set (m0 := moved D0) in *. set (m1 := moved D1) in *. set (m2 := moved D2) in *.
  assert (M : m0 * m0 + m1 * m1 + m2 * m2 <= (rho * D') * (rho * D')).
  { assert (rho * rho * frobenius <= rho * rho * (D' * D')) by (apply Rmult_le_compat_l; [nra | trivial]).
    unfold frobenius in *. nra. }
  set (t := n0 * m0 + n1 * m1 + n2 * m2).
  assert (T : t * t <= (n0 * n0 + n1 * n1 + n2 * n2) * (m0 * m0 + m1 * m1 + m2 * m2)).
  { unfold t. pose proof (Rle_0_sqr (n0 * m1 - n1 * m0)). pose proof (Rle_0_sqr (n1 * m2 - n2 * m1)).
    pose proof (Rle_0_sqr (n0 * m2 - n2 * m0)). unfold Rsqr in *. nra. }
  assert (T' : t * t <= ((rho * N') * (rho * N')) * ((rho * D') * (rho * D'))).
  { eapply Rle_trans; [exact T|]. apply Rmult_le_compat; trivial; nra. }
  assert (0 <= rho * rho * N' * D') by (repeat apply Rmult_le_pos; trivial).
  assert (t * t <= (rho * rho * N' * D') * (rho * rho * N' * D')) by lra.
  nra.
Qed.
End Point.

Print Assumptions R1.
Print Assumptions R1_matrix.
Print Assumptions R2.
Print Assumptions R2_apart.
Print Assumptions R3_second_order.
