(* B4: the cell of a coordinate is a monotone function of it, rounding included. *)
(* code src/bvh/grid.h
 *   const auto steps = hn::Mul(hn::Sub(x, hn::Load(d, grid.origin + lane)), hn::Load(d, grid.scale + lane));
 *   const auto clamped = hn::Min(hn::Max(steps, hn::Zero(d)), hn::Set(d, 255.0f));
 *   return hn::DemoteTo(d8, hn::ConvertTo(di, clamped));
 *)
Require Import Reals ZArith Lra Lia.
From Flocq Require Import Core.
Open Scope R_scope.

(* Single precision, denormal numbers included, to nearest and even. *)
Definition rounded := round radix2 (FLT_exp (-149) 24) ZnearestE.
Definition clamped r := Rmin (Rmax r 0) 255.
Definition cell origin scale x := Ztrunc (clamped (rounded (rounded (x - origin) * scale))).

Lemma rounded_le r s : r <= s -> rounded r <= rounded s.
Proof. intros H. apply round_le; [apply FLT_exp_valid; reflexivity | apply valid_rnd_N | exact H]. Qed.

Lemma clamped_le r s : r <= s -> clamped r <= clamped s.
Proof. intros H. unfold clamped. apply Rle_min_compat_r, Rle_max_compat_r, H. Qed.

Theorem B4 origin scale x y :
  0 < scale -> (cell origin scale x > cell origin scale y)%Z -> x > y.
Proof.
  intros Hs H. destruct (Rle_or_lt x y) as [Hle | Hlt]; [exfalso | trivial].
  assert (cell origin scale x <= cell origin scale y)%Z; [|lia].
  unfold cell. apply Ztrunc_le, clamped_le, rounded_le, Rmult_le_compat_r; [lra|]. apply rounded_le. lra.
Qed.

(* Bytes suffice. *)
Theorem B4_range origin scale x : (0 <= cell origin scale x <= 255)%Z.
Proof.
  unfold cell, clamped. set (r := rounded _).
  assert (0 <= Rmin (Rmax r 0) 255 <= 255) as [H0 H1].
  { split; [apply Rmin_glb; [apply Rmax_r | lra] | apply Rmin_r]. }
  apply Ztrunc_le in H0, H1. rewrite (Ztrunc_IZR 0) in H0. rewrite (Ztrunc_IZR 255) in H1. lia.
Qed.

Print Assumptions B4.
Print Assumptions B4_range.
