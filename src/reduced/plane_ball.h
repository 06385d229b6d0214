/// How far reduced coordinates may go before a plane no longer keeps two sets of vertices apart.
#pragma once

#include "reduced/pose.h"

namespace foldproof {

/// Two sets of vertices, places in leaf order, not empty.
struct TwoSets {
  std::span<const Index> a, b;
  Vec3 apart = Vec3::Zero();  ///< Where the search for a plane begins, from b to a. 0: anywhere.
};

/// Scratch: one per thread.
class PlaneBall {
 public:
  /// A radius around the pose's centre within which, at every p, the convex hulls of two sets of vertices are
  /// farther apart than `gap`: by a plane that moves with them, turning or not (docs/soundness.md, R3). 0:
  /// none. `enough`: more need not be looked for. Cost: O((a + b) * modes).
  double radius(const ReducedMotion& motion, const CentrePose& pose, const TwoSets& sets, double gap,
                double enough);

 private:
  bool find_plane(const CentrePose& pose, const TwoSets& sets);
  void mean_motion(const ReducedMotion& motion, const TwoSets& sets);
  void fit_rotation(const ReducedMotion& motion, const CentrePose& pose, const TwoSets& sets);
  void fit_sides(const ReducedMotion& motion, const CentrePose& pose, const TwoSets& sets, double at);
  double radius_of(const ReducedMotion& motion, const CentrePose& pose, const TwoSets& sets, double gap,
                   double at_least);

  Vec3 normal_, origin_;            // of unit length; in the middle of the gap
  std::vector<Vec3> mean_;          // per mode and deviation: how both sets move
  std::vector<Vec3> turn_, shift_;  // per mode and deviation: of the normal and of the origin
  std::vector<Eigen::Vector4d> sides_;
};

}  // namespace foldproof
