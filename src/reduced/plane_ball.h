/// Balls of separating planes: within them a plane separates two sets of vertices.
#pragma once

#include <Eigen/Core>

#include "reduced/pose.h"

namespace foldproof::inline internal {

/// Two sets of vertices, indices in leaf order, not empty.
struct TwoSets {
  std::span<const Index> a, b;
  Vec3 direction = Vec3::Zero();  ///< From b to a; the search for a normal starts here. 0: between the means.
};

/// Scratch: one per thread.
class PlaneBall {
 public:
  /// A radius around the pose's center within which, at every p, the convex hulls of two sets of vertices are
  /// farther apart than `gap`: by a plane that moves with them, turning or not (docs/soundness.md, R3). 0:
  /// none. The search stops at `max_radius`. Cost: O((a + b) * modes).
  double radius(const ReducedMotion& motion, const CenterPose& pose, const TwoSets& sets, double gap,
                double max_radius);

 private:
  bool find_plane(const CenterPose& pose, const TwoSets& sets);
  void mean_motion(const ReducedMotion& motion, const TwoSets& sets);
  void fit_rotation(const ReducedMotion& motion, const CenterPose& pose, const TwoSets& sets);
  void fit_distances(const ReducedMotion& motion, const CenterPose& pose, const TwoSets& sets, double rho);
  double radius_of(const ReducedMotion& motion, const CenterPose& pose, const TwoSets& sets, double gap,
                   double known);

  Vec3 normal_, origin_;  // of unit length; in the middle of the gap
  // Per mode and deviation: the mean motion of both sets, the motion of the normal, that of the origin.
  std::vector<Vec3> mean_, turn_, shift_;
  std::vector<Eigen::Vector4d> right_sides_;
};

}  // namespace foldproof::internal
