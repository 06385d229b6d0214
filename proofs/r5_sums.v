(* R5: a coordinate of x(p), a sum of rounded products in order, is off by at most 2 (modes + 2) u times the sum of the
   absolute values of its terms. *)
(* code include/foldproof/reduced.h
 *   for (int axis = 0; axis < 3; ++axis) x[axis] += double{row[3 * k + axis]} * p[k];
 * code src/reduced/motion.cpp
 *   return max_coordinate * (modes_ + 2) * 0x1p-52;
 *)
Require Import Reals Lra Psatz List Lia.
Import ListNotations.
Open Scope R_scope.

(* Each product and each sum has a relative error of at most u. The first term is the mean; underflow is left out. *)
Inductive computed (u : R) : list R -> R -> Prop :=
| computed_first p e : Rabs e <= u -> computed u [p] (p * (1 + e))
| computed_next p terms s e d : computed u terms s -> Rabs e <= u -> Rabs d <= u ->
    computed u (p :: terms) ((s + p * (1 + e)) * (1 + d)).

Definition total (terms : list R) := fold_right Rplus 0 terms.
Definition size (terms : list R) := fold_right Rplus 0 (map Rabs terms).

Lemma size_nonneg terms : 0 <= size terms.
Proof. induction terms as [|p terms IH]; unfold size in *; simpl; [lra|]. pose proof (Rabs_pos p). lra. Qed.

Lemma total_size terms : Rabs (total terms) <= size terms.
Proof.
  induction terms as [|p terms IH]; unfold total, size in *; simpl; [rewrite Rabs_R0; lra|].
  eapply Rle_trans; [apply Rabs_triang | lra].
Qed.

Lemma power_ge_1 u n : 0 <= u -> 1 <= (1 + u) ^ n.
Proof. intros. apply pow_R1_Rle. lra. Qed.

(* The error grows with the number of operations that a term passes through. *)
Lemma computed_error u terms s : 0 <= u -> computed u terms s ->
  Rabs (s - total terms) <= ((1 + u) ^ (S (length terms)) - 1) * size terms.
Proof.
  intros Hu H. induction H as [p e He | p terms s e d H IH He Hd].
  - unfold total, size; simpl. replace (p * (1 + e) - (p + 0)) with (p * e) by ring.
    rewrite Rabs_mult. pose proof (Rabs_pos p). nra.
  - set (G := (1 + u) ^ S (length terms)) in *.
    assert (HG : 1 <= G) by (apply power_ge_1; trivial).
    assert (HG1 : 1 + u <= G).
    { unfold G. simpl. pose proof (power_ge_1 u (length terms) Hu). nra. }
    replace ((1 + u) ^ S (length (p :: terms))) with ((1 + u) * G) by reflexivity.
    unfold total, size in *; simpl. fold (total terms) in *. fold (size terms) in *.
    pose proof (size_nonneg terms) as Hs. pose proof (total_size terms) as Ht. pose proof (Rabs_pos p) as Hp.
    replace ((s + p * (1 + e)) * (1 + d) - (p + total terms)) with
      ((s - total terms) * (1 + d) + p * (e * (1 + d)) + (p + total terms) * d) by ring.
    assert (D : Rabs (1 + d) <= 1 + u).
    { eapply Rle_trans; [apply Rabs_triang|]. rewrite Rabs_R1. lra. }
    assert (A : Rabs ((s - total terms) * (1 + d)) <= (G - 1) * size terms * (1 + u)).
    { rewrite Rabs_mult. apply Rmult_le_compat; trivial; apply Rabs_pos. }
    assert (B : Rabs (p * (e * (1 + d))) <= Rabs p * (u * (1 + u))).
    { rewrite !Rabs_mult. apply Rmult_le_compat_l; trivial. apply Rmult_le_compat; trivial; apply Rabs_pos. }
    assert (C : Rabs ((p + total terms) * d) <= (Rabs p + size terms) * u).
    { rewrite Rabs_mult. apply Rmult_le_compat; trivial; try apply Rabs_pos.
      eapply Rle_trans; [apply Rabs_triang | lra]. }
    eapply Rle_trans; [apply Rabs_triang|].
    eapply Rle_trans; [apply Rplus_le_compat_r, Rabs_triang|].
    assert (Rabs p * (u * (1 + u)) + Rabs p * u <= ((1 + u) * G - 1) * Rabs p).
    { assert (u * (1 + u) + u <= (1 + u) * G - 1) by nra. nra. }
    nra.
Qed.

(* (1 + u)^n - 1 <= 2 n u while 2 n u <= 1. *)
Lemma growth u n : 0 <= u -> 2 * INR n * u <= 1 -> (1 + u) ^ n - 1 <= 2 * INR n * u.
Proof.
  intros Hu. induction n as [|n IH]; intros H; [simpl; lra|].
  rewrite S_INR in *. simpl. assert (0 <= INR n) by apply pos_INR.
  assert (I : (1 + u) ^ n - 1 <= 2 * INR n * u) by (apply IH; nra). nra.
Qed.

Theorem R5 terms s : computed (/ 2 ^ 53) terms s -> (length terms <= 1025)%nat ->
  Rabs (s - total terms) <= 2 * (INR (length terms) + 1) * / 2 ^ 53 * size terms.
Proof.
  intros H Hn. set (u := / 2 ^ 53) in *.
  assert (Hu : 0 < u) by (apply Rinv_0_lt_compat, pow_lt; lra).
  assert (u <= / 10000).
  { apply Rinv_le_contravar; [lra|]. apply Rle_trans with (2 ^ 14); [simpl; lra|]. apply Rle_pow; [lra | lia]. }
  assert (INR (length terms) <= 1025) by (replace 1025 with (INR 1025) by (simpl; lra); apply le_INR; lia).
  assert (0 <= INR (length terms)) by apply pos_INR.
  eapply Rle_trans; [apply (computed_error u); trivial; lra|].
  apply Rmult_le_compat_r; [apply size_nonneg|].
  rewrite <- S_INR. apply growth; [lra|]. rewrite S_INR. nra.
Qed.

Print Assumptions R5.
