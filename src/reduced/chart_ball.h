/// Balls of charts: within them a chart proves its patch free of contact.
#pragma once

#include "certificate/library.h"
#include "reduced/pose.h"

namespace foldproof::inline internal {

/// Scratch: one per thread.
class ChartBall {
 public:
  /// A radius around the pose's center within which, at every p, the chart proves that features of the patch
  /// without a common vertex are farther apart than `gap` (docs/soundness.md, R1). 0: none. `uv_map`: valid,
  /// built along `facing` in the same pose.
  double radius(const ReducedMotion& motion, const CenterPose& pose, const Patch& patch, const UvMap& uv_map,
                const Eigen::Vector3f& facing, double gap);

 private:
  bool pull_back(const CenterPose& pose, const Patch& patch, const Eigen::Vector3f& facing);
  void map_vertices(const ReducedMotion& motion, const CenterPose& pose, const Patch& patch,
                    const UvMap& uv_map);
  void map_corners(const UvMap& uv_map);
  double min_altitude(const Patch& patch, const UvMap& uv_map) const;
  double triangle_radius(const std::array<std::uint16_t, 3>& triangle, double lambda, double error,
                         double best);

  Index modes_ = 0;
  Eigen::Matrix<double, 2, 3> w_;              // W^T
  double w_norm_ = 0, w_sum_ = 0;              // Frobenius norm; largest sum of a row's magnitudes
  std::vector<Eigen::Vector2d> uvs_, mapped_;  // per vertex, then per corner of the square; mapped: W^T x
  std::vector<double> moved_;                  // [vertex][x or y][mode]: how mapped_ moves, per deviation
  double mapped_error_ = 0, moved_error_ = 0;  // of their entries, by rounding
  Eigen::ArrayXd h_, u1_, u2_;
};

}  // namespace foldproof::internal
