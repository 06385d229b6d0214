(* R4: the ball of a pair of nodes, the larger of its own and the smallest below it, is one in which it is free. *)
(* code src/reduced/shape.cpp
 *   radius[i] = std::max(radius[i], *std::min_element(children, children + node.count));
 *)
Require Import Reals Lra Psatz List.
Import ListNotations.
Open Scope R_scope.

(* A pair of nodes: the radius of its own ball, its pairs of features, and the pairs below. *)
Inductive tree := Pair (own : R) (features : list nat) (below : list tree).

Fixpoint least (radii : list R) : option R :=
  match radii with
  | [] => None
  | r :: rest => match least rest with None => Some r | Some s => Some (Rmin r s) end
  end.
Fixpoint ball (t : tree) : R :=
  let 'Pair own _ below := t in
  match least (map ball below) with None => own | Some r => Rmax own r end.

(* All features of a pair that has pairs below are among theirs, and its own ball is right. *)
Inductive valid (free : nat -> R -> Prop) : tree -> Prop :=
| valid_pair own features below :
    (forall f r, In f features -> r < own -> free f r) ->
    (below <> [] -> forall f, In f features -> exists t, In t below /\ In f (let 'Pair _ fs _ := t in fs)) ->
    (forall t, In t below -> valid free t) -> valid free (Pair own features below).

Lemma least_le radii r : least radii = Some r -> forall s, In s radii -> r <= s.
Proof.
  revert r. induction radii as [|a rest IH]; simpl; [discriminate|].
  intros r H s Hs. destruct (least rest) as [m|] eqn:E; injection H as <-.
  - destruct Hs as [<- | Hs]; [apply Rmin_l|].
    eapply Rle_trans; [apply Rmin_r|]. apply (IH m); trivial.
  - destruct Hs as [<- | Hs]; [lra|]. destruct rest; [contradiction|].
    simpl in E. destruct (least rest); discriminate.
Qed.

(* free f r: the pair of features f does not touch at the distance r from the center. *)
Theorem R4 free t : valid free t ->
  forall f r, In f (let 'Pair _ fs _ := t in fs) -> r < ball t -> free f r.
Proof.
  intros H. induction H as [own features below Own Cover Below IH]. intros f r Hf Hr.
  simpl in Hr. destruct (least (map ball below)) as [m|] eqn:E.
  - destruct (Rlt_le_dec r own) as [Ho | Ho]; [apply Own; trivial|].
    assert (r < m).
    { unfold Rmax in Hr. destruct (Rle_dec own m); lra. }
    destruct below as [|b rest]; [discriminate|].
    destruct (Cover ltac:(discriminate) f Hf) as (t & Ht & Hft).
    apply (IH t Ht f r Hft).
    apply (Rlt_le_trans _ m); trivial. apply (least_le _ _ E). apply in_map; trivial.
  - apply Own; trivial.
Qed.

(* The test at run time, Eq. 8. f t is the norm |p(t) - c|_M along a step; norms are convex. *)
Theorem R4_step (f : R -> R) radius :
  (forall t, 0 <= t <= 1 -> f t <= (1 - t) * f 0 + t * f 1) -> f 0 < radius -> f 1 < radius ->
  forall t, 0 <= t <= 1 -> f t < radius.
Proof. intros Convex H0 H1 t Ht. specialize (Convex t Ht). destruct (Rle_lt_dec t (1 / 2)); nra. Qed.

Print Assumptions R4.
Print Assumptions R4_step.
