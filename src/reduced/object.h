/// Objects in reduced coordinates during one step: boxes of nodes from p alone, and vertices on demand.
#pragma once

#include "check/narrow_phase.h"
#include "reduced/shape.h"

namespace foldproof::inline internal {

/// A node's box at both ends of a step, mesh units.
struct ReducedBox {
  Vec3 low[2], high[2];
};

/// One object during one step. Reused from step to step.
class ReducedObject {
 public:
  explicit ReducedObject(std::shared_ptr<const ReducedShape> shape);

  /// Error: as ReducedChecker::check. `object`: for messages.
  Result<void> start_step(Index object, const ReducedPose& start, const ReducedPose& end);

  /// A box that holds the node's vertices. Computed on first use in a step: from p alone, rounding included,
  /// or around the vertices if these have been computed by then.
  const ReducedBox& box(Index node);
  /// Whether balls apply to this step: their clearance then implies that the object's features are farther
  /// apart than `distance`.
  bool balls_apply(double distance) const;
  const ReducedShape& shape() const { return *shape_; }
  const ReducedPose& pose(int end) const { return poses_[end]; }

  /// Computes the vertices of a leaf, here and in `bvh`, and its box from them; once per step.
  void compute_leaf(const Frame& frame, LeafIndex leaf, KineticBvh& bvh);
  /// Computes the boxes of a leaf's features in `bvh`, once per step. Precondition: compute_leaf.
  void compute_features(LeafIndex leaf, KineticBvh& bvh);
  /// Computes all vertices, once per step. From then on boxes are those around the vertices.
  void compute_all();
  /// By the user's ids; valid for vertices that were computed in this step.
  std::span<const double> positions(int end) const { return x_[end]; }

 private:
  /// ReducedMotion::max_coordinate, or what is wrong with the pose.
  Result<double> check_pose(Index object, const ReducedPose& pose) const;
  void bound_by_p(Index node, ReducedBox& box) const;
  void fit_leaf(Index leaf, ReducedBox& box) const;

  std::shared_ptr<const ReducedShape> shape_;
  std::array<ReducedPose, 2> poses_;
  std::array<std::vector<double>, 2> x_;  // by the user's ids; valid where vertex_step_ or all_step_ is step_
  std::array<double, 2> rounding_{};      // of a vertex's coordinate
  std::array<Index, 2> nearest_{};        // center
  std::array<double, 2> distance_{};      // from it
  // The steps in which each of these was computed last.
  std::uint32_t step_ = 0, all_step_ = 0;
  std::vector<std::uint32_t> box_step_, vertex_step_, leaf_step_, features_step_;
  // x_[1] holds all vertices of this pose with these coordinates; of none when they are empty.
  ReducedPose all_pose_;
  std::vector<double> all_p_;
  std::vector<ReducedBox> boxes_;
};

/// Theorem 1: some axis and side separates the boxes by more than `distance` at both ends.
bool boxes_separated(const ReducedBox& a, const ReducedBox& b, double distance);

}  // namespace foldproof::internal
