/// How far reduced coordinates may go before a plane no longer keeps two sets of vertices apart.
#pragma once

#include "reduced/pose.h"

namespace foldproof {

/// Scratch: one per thread.
class PlaneBall {
 public:
  /// A radius around the pose's centre within which, at every p, the convex hulls of two sets of vertices
  /// (places in leaf order, not empty) are farther apart than `gap`: by a plane that moves with them, turning
  /// or not (docs/soundness.md, R3). 0: none. Cost: O((a + b) * modes).
  double radius(const ReducedMotion& motion, const CentrePose& pose, std::span<const Index> a,
                std::span<const Index> b, double gap);

 private:
  bool find_plane(const CentrePose& pose, std::span<const Index> a, std::span<const Index> b);
  void fit_rotation(const ReducedMotion& motion, const CentrePose& pose, std::span<const Index> a,
                    std::span<const Index> b);

  Vec3 normal_, origin_;            // of unit length; in the middle of the gap
  std::vector<Vec3> turn_, shift_;  // per mode and deviation: of the normal and of the origin
};

}  // namespace foldproof
