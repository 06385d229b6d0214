#include "reduced/pose.h"

#include <cmath>

namespace foldproof::internal {

CenterPose::CenterPose(const ReducedMotion& motion, std::vector<double> center)
    : p(std::move(center)), rounding(motion.rounding(p)) {
  const auto count = static_cast<Index>(motion.hierarchy()->vertex_ids().size());
  x.resize(3 * std::size_t{count});
  for (Index v = 0; v < count; ++v) {
    double point[3];
    motion.vertex(v, p, point);
    for (int axis = 0; axis < 3; ++axis) {
      x[3 * std::size_t{v} + axis] = point[axis];
      max_coordinate = std::max(max_coordinate, std::abs(point[axis]));
    }
  }
}

// Both are tested in tests/arithmetic, Conversions.
float round_down(double value) {
  const auto nearest = static_cast<float>(value);
  return double{nearest} <= value ? nearest
                                  : std::nextafter(nearest, -std::numeric_limits<float>::infinity());
}

float round_up(double value) {
  const auto nearest = static_cast<float>(value);
  return double{nearest} >= value ? nearest : std::nextafter(nearest, std::numeric_limits<float>::infinity());
}

}  // namespace foldproof::internal
