(* Theorem 2: a chart whose triangles have a positive definite map keeps points apart. The triangles of the square cut the
   segment from q to p into pieces. That those of a valid chart do so is the one hypothesis, which
   tests/proofs/triangulations_test.cpp checks on all small cases. *)
(* S1: the test of a triangle by its sides. *)
(* code src/certificate/chart_holds.cpp
 *   if (!(k11 > 0 && k22 > 0 && k11 * k22 * kNearlyFour > k12 * k12)) return false;
 *)
Require Import Reals Lra Psatz List.
Import ListNotations.
Open Scope R_scope.

Record uv := P { u1 : R; u2 : R }.
Record vec := V { x : R; y : R; z : R }.
Definition add a b := V (x a + x b) (y a + y b) (z a + z b).
Definition sub a b := V (x a - x b) (y a - y b) (z a - z b).
Definition mul s a := V (s * x a) (s * y a) (s * z a).
Definition dot a b := x a * x b + y a * y b + z a * z b.
Definition norm a := sqrt (dot a a).
Definition square u := u1 u * u1 u + u2 u * u2 u.

(* A 3x2 matrix by its columns. *)
Record matrix := M { c1 : vec; c2 : vec }.
Definition apply m u := add (mul (u1 u) (c1 m)) (mul (u2 u) (c2 m)).
Definition mix t (a e : matrix) :=
  M (add (mul (1 - t) (c1 a)) (mul t (c1 e))) (add (mul (1 - t) (c2 a)) (mul t (c2 e))).

(* The symmetric part of W^T G - lambda I is positive definite. *)
Definition definite W lambda G := forall u, 0 < square u -> dot (apply W u) (apply G u) > lambda * square u.

Lemma definite_between W lambda a e t :
  0 <= t <= 1 -> definite W lambda a -> definite W lambda e -> definite W lambda (mix t a e).
Proof.
  intros Ht Ha He u Hu. specialize (Ha u Hu). specialize (He u Hu).
  replace (dot (apply W u) (apply (mix t a e) u)) with
    ((1 - t) * dot (apply W u) (apply a u) + t * dot (apply W u) (apply e u))
    by (unfold dot, apply, mix, add, mul; simpl; ring).
  destruct (Rle_lt_dec t (1 / 2)); nra.
Qed.

(* A piece of the segment: which share of it lies in a triangle, and the triangle's maps at both ends of the step. *)
Record piece := Piece { share : R; at_start : matrix; at_end : matrix }.

(* How x changes along these pieces of a segment with direction u. *)
Fixpoint change t u (pieces : list piece) :=
  match pieces with
  | [] => V 0 0 0
  | p :: rest => add (mul (share p) (apply (mix t (at_start p) (at_end p)) u)) (change t u rest)
  end.
Fixpoint shares (pieces : list piece) :=
  match pieces with [] => 0 | p :: rest => share p + shares rest end.

Theorem Theorem_2 W lambda u pieces t :
  0 <= t <= 1 -> shares pieces = 1 ->
  (forall p, In p pieces ->
     0 <= share p /\ definite W lambda (at_start p) /\ definite W lambda (at_end p)) ->
  dot (apply W u) (change t u pieces) >= lambda * square u.
Proof.
  intros Ht H1 H.
  assert (S : dot (apply W u) (change t u pieces) >= shares pieces * (lambda * square u)).
  { clear H1. induction pieces as [|p rest IH]; simpl.
    - unfold dot; simpl; lra.
    - destruct (H p (or_introl eq_refl)) as (Hs & Ha & He).
      assert (R : dot (apply W u) (change t u rest) >= shares rest * (lambda * square u))
        by (apply IH; intros; apply H; right; trivial).
      replace (dot (apply W u) (add (mul (share p) (apply (mix t (at_start p) (at_end p)) u)) (change t u rest))) with
        (share p * dot (apply W u) (apply (mix t (at_start p) (at_end p)) u) + dot (apply W u) (change t u rest))
        by (unfold dot, add, mul; simpl; ring).
      assert (D : dot (apply W u) (apply (mix t (at_start p) (at_end p)) u) >= lambda * square u).
      { destruct (Req_dec (square u) 0) as [Z | Z].
        - assert (u1 u = 0 /\ u2 u = 0) as [Z1 Z2] by (unfold square in Z; split; nra).
          rewrite Z. unfold dot, apply. simpl. rewrite Z1, Z2. lra.
        - left. apply definite_between; trivial. assert (0 <= square u) by (unfold square; nra). lra. }
      nra. }
  rewrite H1 in S. lra.
Qed.

(* The claim for a chart. x t p is where the point with uv coordinates p is at the time t; triangles are the maps of all
   triangles of R at both ends. *)
Section Chart.
Variable x : R -> uv -> vec.
Variable triangles : list (matrix * matrix).
Hypothesis valid_chart_triangulates_the_square : forall p q : uv, exists pieces,
  shares pieces = 1 /\
  (forall c, In c pieces -> 0 <= share c /\ In (at_start c, at_end c) triangles) /\
  (forall t, sub (x t p) (x t q) = change t (P (u1 p - u1 q) (u2 p - u2 q)) pieces).

Theorem Theorem_2_chart W lambda p q t :
  0 <= t <= 1 ->
  (forall a e, In (a, e) triangles -> definite W lambda a /\ definite W lambda e) ->
  let u := P (u1 p - u1 q) (u2 p - u2 q) in dot (apply W u) (sub (x t p) (x t q)) >= lambda * square u.
Proof.
  intros Ht H u. destruct (valid_chart_triangulates_the_square p q) as (pieces & H1 & Hin & ->).
  apply Theorem_2; trivial. intros c Hc. destruct (Hin c Hc) as [Hs Ht']. split; trivial. apply H; trivial.
Qed.
End Chart.

Lemma norm_square a : norm a * norm a = dot a a.
Proof. apply sqrt_sqrt. unfold dot. nra. Qed.

Lemma cauchy_schwarz a b : dot a b <= norm a * norm b.
Proof.
  assert (0 <= norm a /\ 0 <= norm b) as [Pa Pb] by (split; apply sqrt_pos).
  destruct (Rle_or_lt (dot a b) 0) as [H | H]; [nra|].
  apply Rsqr_incr_0_var; [|nra]. unfold Rsqr.
  replace (norm a * norm b * (norm a * norm b)) with ((norm a * norm a) * (norm b * norm b)) by ring.
  rewrite !norm_square. unfold dot.
  assert (0 <= (x a * y b - y a * x b) ^ 2 + (y a * z b - z a * y b) ^ 2 + (z a * x b - x a * z b) ^ 2)
    by (repeat apply Rplus_le_le_0_compat; apply pow2_ge_0).
  nra.
Qed.

(* Consequences 1 and 2: w bounds |W u| / |u|. Points u apart in the plane are lambda |u| / w apart; so with
   lambda >= g w / h those at least h apart are not nearer than g. *)
Theorem Theorem_2_distance W lambda w u change :
  0 < w -> 0 < lambda -> norm (apply W u) <= w * sqrt (square u) ->
  dot (apply W u) change >= lambda * square u -> norm change >= lambda * sqrt (square u) / w.
Proof.
  intros Hw Hl HW H.
  assert (Hs : sqrt (square u) * sqrt (square u) = square u) by (apply sqrt_sqrt; unfold square; nra).
  pose proof (sqrt_pos (square u)) as Hp. set (s := sqrt (square u)) in *.
  assert (0 <= norm change) by apply sqrt_pos.
  pose proof (cauchy_schwarz (apply W u) change) as C.
  apply Rle_ge. apply (Rmult_le_reg_r w); trivial.
  replace (lambda * s / w * w) with (lambda * s) by (field; lra).
  destruct (Req_dec s 0) as [-> | Hn]; [nra|].
  apply (Rmult_le_reg_r s); [lra|]. nra.
Qed.

Theorem Theorem_2_gap lambda g w h s distance :
  0 < w -> 0 < h -> 0 <= g -> lambda >= g * w / h -> s >= h -> distance >= lambda * s / w -> distance >= g.
Proof.
  intros Hw Hh Hg Hl Hs Hd.
  assert (lambda * s / w >= g); [|lra].
  apply Rle_ge. apply (Rmult_le_reg_r w); trivial. replace (lambda * s / w * w) with (lambda * s) by (field; lra).
  assert (g * w = g * w / h * h) as -> by (field; lra).
  assert (0 <= g * w / h) by (apply Rle_mult_inv_pos; nra).
  apply Rge_le in Hl, Hs. apply Rmult_le_compat; lra.
Qed.

(* S1: K = E^T eta is positive definite exactly when its entries say so. *)
Theorem S1 K11 K12 K21 K22 :
  (forall a b, 0 < a * a + b * b -> K11 * (a * a) + (K12 + K21) * (a * b) + K22 * (b * b) > 0) <->
  K11 > 0 /\ K22 > 0 /\ 4 * K11 * K22 > (K12 + K21) * (K12 + K21).
Proof.
  set (B := K12 + K21). split.
  - intros H.
    assert (H1 := H 1 0 ltac:(lra)). assert (H2 := H 0 1 ltac:(lra)).
    assert (K1 : K11 > 0) by lra. assert (K2 : K22 > 0) by lra. repeat split; trivial.
    assert (H3 := H (- B) (2 * K11) ltac:(nra)). nra.
  - intros (H1 & H2 & H3) a b H.
    apply (Rmult_lt_reg_l (4 * K11)); [lra|]. rewrite Rmult_0_r.
    replace (4 * K11 * (K11 * (a * a) + B * (a * b) + K22 * (b * b))) with
      ((2 * K11 * a + B * b) * (2 * K11 * a + B * b) + (4 * K11 * K22 - B * B) * (b * b)) by ring.
    destruct (Req_dec b 0) as [-> | Hb].
    + assert (0 < K11 * K11 * (a * a)) by (apply Rmult_lt_0_compat; [apply Rmult_lt_0_compat|]; lra). lra.
    + assert (0 < (4 * K11 * K22 - B * B) * (b * b)) by (apply Rmult_lt_0_compat; [lra | nra]).
      pose proof (Rle_0_sqr (2 * K11 * a + B * b)). unfold Rsqr in *. lra.
Qed.

Print Assumptions Theorem_2.
Print Assumptions Theorem_2_chart.
Print Assumptions Theorem_2_distance.
Print Assumptions Theorem_2_gap.
Print Assumptions S1.
