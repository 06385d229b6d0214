(* N3: a volume whose Bernstein coefficients have one strict sign is never zero. *)
(* N5: a plane that turns keeps the corners beyond D. *)
(* code src/ccd/lanes.h
 *   b[0] = Dot(a.d[0], aa);
 *   b[1] = hn::Div(hn::Add(Dot(e.d[0], aa), Dot(a.d[0], ae)), three);
 *   b[2] = hn::Div(hn::Add(Dot(e.d[0], ae), Dot(a.d[0], ee)), three);
 *   b[3] = Dot(e.d[0], ee);
 * code src/ccd/conservative_advancement.cpp
 *   const V middle = hn::Mul(hn::Add(Dot(normal, then.d[k]), Dot(other, now_.d[k])), Number(0.5));
 *)
Require Import Reals Lra Psatz.
Open Scope R_scope.

Record vec := V { x : R; y : R; z : R }.
Definition add u v := V (x u + x v) (y u + y v) (z u + z v).
Definition mul s u := V (s * x u) (s * y u) (s * z u).
Definition dot u v := x u * x v + y u * y v + z u * z v.
Definition cross u v := V (y u * z v - z u * y v) (z u * x v - x u * z v) (x u * y v - y u * x v).
Definition norm u := sqrt (dot u u).
Definition mix t u v := add (mul (1 - t) u) (mul t v).

Definition volume d0 d1 d2 := dot d0 (cross d1 d2).

Section Volume.
Variables a0 a1 a2 e0 e1 e2 : vec.
Let aa := cross a1 a2.
Let ee := cross e1 e2.
Let ae := add (cross a1 e2) (cross e1 a2).
Let b0 := dot a0 aa.
Let b1 := (dot e0 aa + dot a0 ae) / 3.
Let b2 := (dot e0 ae + dot a0 ee) / 3.
Let b3 := dot e0 ee.

Lemma bernstein t :
  volume (mix t a0 e0) (mix t a1 e1) (mix t a2 e2) =
  b0 * (1 - t) ^ 3 + 3 * b1 * (t * (1 - t) ^ 2) + 3 * b2 * (t ^ 2 * (1 - t)) + b3 * t ^ 3.
Proof. unfold volume, b0, b1, b2, b3, aa, ee, ae, mix, add, mul, dot, cross; simpl; field. Qed.

Lemma basis c0 c1 c2 c3 t : 0 <= t <= 1 -> c0 > 0 -> c1 > 0 -> c2 > 0 -> c3 > 0 ->
  c0 * (1 - t) ^ 3 + 3 * c1 * (t * (1 - t) ^ 2) + 3 * c2 * (t ^ 2 * (1 - t)) + c3 * t ^ 3 > 0.
Proof.
  intros Ht H0 H1 H2 H3.
  assert (0 <= (1 - t) ^ 3 /\ 0 <= t * (1 - t) ^ 2 /\ 0 <= t ^ 2 * (1 - t) /\ 0 <= t ^ 3) as (p0 & p1 & p2 & p3).
  { repeat split; simpl; repeat apply Rmult_le_pos; lra. }
  assert ((1 - t) ^ 3 + 3 * (t * (1 - t) ^ 2) + 3 * (t ^ 2 * (1 - t)) + t ^ 3 = 1) by ring.
  set (u0 := (1 - t) ^ 3) in *. set (u1 := t * (1 - t) ^ 2) in *.
  set (u2 := t ^ 2 * (1 - t)) in *. set (u3 := t ^ 3) in *.
  set (c := Rmin (Rmin c0 c1) (Rmin c2 c3)).
  assert (0 < c) by (unfold c; repeat apply Rmin_pos; lra).
  assert (c <= c0 /\ c <= c1 /\ c <= c2 /\ c <= c3) as (? & ? & ? & ?).
  { unfold c. pose proof (Rmin_l c0 c1). pose proof (Rmin_r c0 c1). pose proof (Rmin_l c2 c3).
    pose proof (Rmin_r c2 c3). pose proof (Rmin_l (Rmin c0 c1) (Rmin c2 c3)).
    pose proof (Rmin_r (Rmin c0 c1) (Rmin c2 c3)). lra. }
  nra.
Qed.

(* The origin is in one plane with three corners where their volume is zero. *)
Theorem N3 :
  (b0 > 0 /\ b1 > 0 /\ b2 > 0 /\ b3 > 0) \/ (b0 < 0 /\ b1 < 0 /\ b2 < 0 /\ b3 < 0) ->
  forall t, 0 <= t <= 1 -> volume (mix t a0 e0) (mix t a1 e1) (mix t a2 e2) <> 0.
Proof.
  intros H t Ht. rewrite bernstein. destruct H as [H | H].
  - pose proof (basis b0 b1 b2 b3 t). lra.
  - pose proof (basis (- b0) (- b1) (- b2) (- b3) t). lra.
Qed.
End Volume.

(* Where the origin is a combination of three corners with weights that are not all zero, the volume is zero. The
   weights of a point of a triangle are such, and for edge-edge those of a parallelogram's point in three corners. *)
Theorem N3_contact d0 d1 d2 w0 w1 w2 :
  add (add (mul w0 d0) (mul w1 d1)) (mul w2 d2) = V 0 0 0 -> w0 <> 0 \/ w1 <> 0 \/ w2 <> 0 -> volume d0 d1 d2 = 0.
Proof.
  destruct d0 as [x0 y0 z0], d1 as [x1 y1 z1], d2 as [x2 y2 z2].
  unfold add, mul, volume, dot, cross; simpl. intros E W. injection E as Ex Ey Ez.
  set (v := x0 * (y1 * z2 - z1 * y2) + y0 * (z1 * x2 - x1 * z2) + z0 * (x1 * y2 - y1 * x2)).
  assert (w0 * v = 0 /\ w1 * v = 0 /\ w2 * v = 0) as (H0 & H1 & H2).
  { repeat split; unfold v.
    - transitivity ((w0 * x0 + w1 * x1 + w2 * x2) * (y1 * z2 - z1 * y2) + (w0 * y0 + w1 * y1 + w2 * y2) * (z1 * x2 - x1 * z2)
        + (w0 * z0 + w1 * z1 + w2 * z2) * (x1 * y2 - y1 * x2)); [ring | rewrite Ex, Ey, Ez; ring].
    - transitivity ((w0 * x0 + w1 * x1 + w2 * x2) * (z0 * y2 - y0 * z2) + (w0 * y0 + w1 * y1 + w2 * y2) * (x0 * z2 - z0 * x2)
        + (w0 * z0 + w1 * z1 + w2 * z2) * (y0 * x2 - x0 * y2)); [ring | rewrite Ex, Ey, Ez; ring].
    - transitivity ((w0 * x0 + w1 * x1 + w2 * x2) * (y0 * z1 - z0 * y1) + (w0 * y0 + w1 * y1 + w2 * y2) * (z0 * x1 - x0 * z1)
        + (w0 * z0 + w1 * z1 + w2 * z2) * (x0 * y1 - y0 * x1)); [ring | rewrite Ex, Ey, Ez; ring]. }
  destruct W as [W | [W | W]]; [apply (Rmult_eq_reg_l w0) | apply (Rmult_eq_reg_l w1) | apply (Rmult_eq_reg_l w2)];
    trivial; rewrite Rmult_0_r; trivial.
Qed.

Lemma quadratic c0 c1 c2 A t : 0 <= t <= 1 -> c0 > A -> c1 > A -> c2 > A ->
  c0 * (1 - t) ^ 2 + 2 * c1 * (t * (1 - t)) + c2 * t ^ 2 > A.
Proof.
  intros Ht H0 H1 H2.
  set (m := Rmin c0 (Rmin c1 c2)).
  assert (m > A) by (unfold m; repeat apply Rmin_glb_lt; lra).
  assert (m <= c0 /\ m <= c1 /\ m <= c2) as (? & ? & ?).
  { unfold m. pose proof (Rmin_l c0 (Rmin c1 c2)). pose proof (Rmin_r c0 (Rmin c1 c2)).
    pose proof (Rmin_l c1 c2). pose proof (Rmin_r c1 c2). lra. }
  assert (0 <= t * (1 - t)) by nra. pose proof (pow2_ge_0 t). pose proof (pow2_ge_0 (1 - t)).
  assert ((1 - t) ^ 2 + 2 * (t * (1 - t)) + t ^ 2 = 1) by ring. nra.
Qed.

(* The projection of each corner on the direction between n_a and n_b exceeds what all three coefficients exceed. *)
Theorem N5 n_a n_b d d' A t : 0 <= t <= 1 ->
  dot n_a d > A -> (dot n_a d' + dot n_b d) / 2 > A -> dot n_b d' > A ->
  dot (mix t n_a n_b) (mix t d d') > A.
Proof.
  intros Ht H0 H1 H2. pose proof (quadratic _ _ _ A t Ht H0 H1 H2).
  replace (dot (mix t n_a n_b) (mix t d d')) with
    (dot n_a d * (1 - t) ^ 2 + 2 * ((dot n_a d' + dot n_b d) / 2) * (t * (1 - t)) + dot n_b d' * t ^ 2)
    by (unfold mix, add, mul, dot; simpl; field).
  trivial.
Qed.

(* That direction is no longer than both ends allow. *)
Theorem N5_length n_a n_b l t : 0 <= t <= 1 -> 0 <= l -> dot n_a n_a <= l * l -> dot n_b n_b <= l * l ->
  dot (mix t n_a n_b) (mix t n_a n_b) <= l * l.
Proof.
  intros Ht Hl Ha Hb.
  assert (dot n_a n_b <= l * l).
  { assert (0 <= (x n_a - x n_b) ^ 2 + (y n_a - y n_b) ^ 2 + (z n_a - z n_b) ^ 2)
      by (repeat apply Rplus_le_le_0_compat; apply pow2_ge_0).
    unfold dot in *. nra. }
  replace (dot (mix t n_a n_b) (mix t n_a n_b)) with
    ((1 - t) ^ 2 * dot n_a n_a + 2 * (t * (1 - t)) * dot n_a n_b + t ^ 2 * dot n_b n_b)
    by (unfold mix, add, mul, dot; simpl; ring).
  assert (0 <= t * (1 - t)) by nra. pose proof (pow2_ge_0 t). pose proof (pow2_ge_0 (1 - t)).
  assert ((1 - t) ^ 2 + 2 * (t * (1 - t)) + t ^ 2 = 1) by ring. nra.
Qed.

Print Assumptions N3.
Print Assumptions N3_contact.
Print Assumptions N5.
Print Assumptions N5_length.
