/// The pose that balls are centred at.
#pragma once

#include "foldproof/reduced.h"

namespace foldproof {

struct CentrePose {
  CentrePose(const ReducedMotion& motion, std::vector<double> centre);

  Vec3 at(Index place) const { return Eigen::Map<const Vec3>(&x[3 * std::size_t{place}]); }

  std::vector<double> p;
  std::vector<double> x;  ///< Of the vertices in leaf order.
  double largest = 0;     ///< Coordinate of x, magnitude.
  double rounding = 0;    ///< Of any coordinate of x.
};

/// Roundings of what is summed up from numbers below one, in double: far above what any sum here carries.
inline constexpr double kSumError = 0x1p-40;
/// What a computed radius is taken smaller by, as a share (R5).
inline constexpr double kRadiusMargin = 0x1p-20;

/// Not above the number, in single precision.
float round_down(double radius);
/// Not below it.
float round_up(double value);

}  // namespace foldproof
