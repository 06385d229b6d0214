/// How far reduced coordinates may go before a chart no longer proves its patch free of contact.
#pragma once

#include "foldproof/certificate.h"
#include "reduced/pose.h"

namespace foldproof {

/// Scratch: one per thread.
class ChartBall {
 public:
  /// A radius around the pose's centre within which, at every p, the chart proves that features of the patch
  /// without a common vertex are farther apart than `gap` (docs/soundness.md, R1). 0: none. `drawing`: valid,
  /// drawn along `facing`.
  double radius(const ReducedMotion& motion, const CentrePose& pose, const Patch& patch,
                const Drawing& drawing, const Eigen::Vector3f& facing, double gap);

 private:
  struct Corners;
  bool pull_back(const CentrePose& pose, const Patch& patch, const Eigen::Vector3f& facing);
  void draw(const ReducedMotion& motion, const CentrePose& pose, const Patch& patch, const Drawing& drawing);
  void draw_corners(const Drawing& drawing);
  double least_altitude(const Patch& patch, const Drawing& drawing) const;
  double radius_of(const Corners& corners, double slack, double error, double best);

  Index modes_ = 0;
  Eigen::Matrix<double, 2, 3> w_;                // W^T
  double w_norm_ = 0, w_sum_ = 0;                // Frobenius norm; largest sum of a row's magnitudes
  std::vector<Eigen::Vector2d> places_, drawn_;  // per vertex and corner of the square
  std::vector<double> moved_;                    // [vertex][x or y][mode]: drawn, per deviation
  double still_error_ = 0, moving_error_ = 0;    // of entries of drawn_ and moved_
  Eigen::ArrayXd h_, u1_, u2_;
};

}  // namespace foldproof
