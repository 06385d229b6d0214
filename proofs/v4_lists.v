(* V4: the separation of two boxes falls by at most their closing distance. *)
(* code src/solver/candidate_lists.cpp
 *   change = std::min(change, a[0][axis] + b[1][axis]);
 *   change = std::min(change, b[0][axis] + a[1][axis]);
 *)
Require Import Reals Lra List.
Open Scope R_scope.

(* Boxes by two opposite sides, low and high; vertices move by d, within [m, M]. *)
Theorem V4_separation low_b high_a low_b' high_a' m_b M_a :
  low_b' >= low_b + m_b -> high_a' <= high_a + M_a -> low_b' - high_a' >= (low_b - high_a) - (M_a - m_b).
Proof. lra. Qed.

(* The corner of a box grows by no less than the smallest and by no more than the largest displacement. *)
Theorem V4_corner (x d : nat -> R) (S : list nat) low low' high high' m M :
  (forall i, In i S -> low <= x i <= high /\ m <= d i <= M) ->
  (exists i, In i S /\ low' = x i + d i) -> (exists i, In i S /\ high' = x i + d i) ->
  low' >= low + m /\ high' <= high + M.
Proof.
  intros H (i & Hi & ->) (j & Hj & ->). destruct (H i Hi) as [? ?]. destruct (H j Hj) as [? ?]. lra.
Qed.

Print Assumptions V4_separation.
Print Assumptions V4_corner.
