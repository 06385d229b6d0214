/// Objects in reduced coordinates during one step: boxes of nodes from p alone, and vertices where they are
/// needed.
#pragma once

#include "check/narrow_phase.h"
#include "reduced/shape.h"

namespace foldproof {

/// Both ends of a node's box during a step, in mesh units.
struct ReducedBox {
  Vec3 low[2], high[2];
};

/// One object during one step. Scratch, made once.
class ReducedObject {
 public:
  explicit ReducedObject(std::shared_ptr<const ReducedShape> shape);

  /// Error: as ReducedChecker::check; `object`, for messages.
  Result<void> begin_step(Index object, const ReducedPose& begin, const ReducedPose& end);

  /// Holds the node's vertices. Found on first use in a step: from p alone, rounding included, or around the
  /// vertices where these have been needed by then.
  const ReducedBox& box(Index node);
  /// Whether balls can speak for this step: features farther apart than the shape's clearance are then
  /// farther apart than `distance`.
  bool balls_hold(double distance) const;
  const ReducedShape& shape() const { return *shape_; }
  const ReducedPose& pose(int end) const { return poses_[end]; }

  /// Computes the vertices of a leaf, also in `tree`, and its box from these, unless that has been done in
  /// this step.
  void need_leaf(const Frame& frame, Index leaf, KineticTree& tree);
  /// The boxes of the features of a leaf that has been needed, in `tree`, unless that has been done.
  void need_features(Index leaf, KineticTree& tree);
  /// All vertices. Boxes that are asked for from here on fit them.
  void need_all();
  /// By the user's ids; valid where a leaf, or all, has been needed in this step.
  std::span<const double> positions(int end) const { return x_[end]; }

 private:
  Result<void> check_pose(Index object, const ReducedPose& pose, double& reach) const;
  void reach_from_p(Index node, ReducedBox& box) const;
  void fit_leaf(Index leaf, ReducedBox& box) const;

  std::shared_ptr<const ReducedShape> shape_;
  std::array<ReducedPose, 2> poses_;
  std::array<std::vector<double>, 2> x_;  // by the user's ids; valid where the vertex is of this step
  std::array<double, 2> rounding_{};      // of a placed coordinate
  std::array<Index, 2> nearest_{};        // centre
  std::array<double, 2> distance_{};      // from it
  std::uint32_t step_ = 0, all_step_ = 0;
  ReducedPose all_pose_;       // of which x_[1] holds all vertices; its p is all_p_
  std::vector<double> all_p_;  // empty: of none
  std::vector<std::uint32_t> box_step_, vertex_step_, leaf_step_, features_step_;
  std::vector<ReducedBox> boxes_;
};

/// Theorem 1: some axis and side separates both boxes at both ends by more than `distance`.
bool boxes_apart(const ReducedBox& a, const ReducedBox& b, double distance);

}  // namespace foldproof
