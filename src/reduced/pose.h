/// The pose at a center of balls.
#pragma once

#include "foldproof/reduced.h"

namespace foldproof::inline internal {

struct CenterPose {
  CenterPose(const ReducedMotion& motion, std::vector<double> center);

  Vec3 at(Index v) const { return Vec3::load(&x[3 * std::size_t{v}]); }

  std::vector<double> p;
  std::vector<double> x;      ///< The vertices in leaf order.
  double max_coordinate = 0;  ///< The largest magnitude of a coordinate of x.
  double rounding = 0;        ///< The rounding error of a coordinate of x, at most.
};

/// Relative rounding error of sums in double, far above that of any sum here.
inline constexpr double kSumError = 0x1p-40;
/// Computed radii are made smaller by this share (R5).
inline constexpr double kRadiusMargin = 0x1p-20;

/// The largest float that is not above the number.
float round_down(double value);
/// The smallest float that is not below the number.
float round_up(double value);

}  // namespace foldproof::internal
