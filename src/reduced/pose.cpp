#include "reduced/pose.h"

#include <cmath>

namespace foldproof {

CentrePose::CentrePose(const ReducedMotion& motion, std::vector<double> centre)
    : p(std::move(centre)), rounding(motion.rounding(p)) {
  const auto count = static_cast<Index>(motion.hierarchy()->vertex_ids().size());
  x.resize(3 * std::size_t{count});
  for (Index place = 0; place < count; ++place) {
    double point[3];
    motion.vertex(place, p, point);
    for (int axis = 0; axis < 3; ++axis) {
      x[3 * std::size_t{place} + axis] = point[axis];
      largest = std::max(largest, std::abs(point[axis]));
    }
  }
}

// Tests of both: tests/arithmetic, Conversions.
float round_down(double radius) {
  const auto nearest = static_cast<float>(radius);
  return double{nearest} <= radius ? nearest
                                   : std::nextafter(nearest, -std::numeric_limits<float>::infinity());
}

float round_up(double value) {
  const auto nearest = static_cast<float>(value);
  return double{nearest} >= value ? nearest : std::nextafter(nearest, std::numeric_limits<float>::infinity());
}

}  // namespace foldproof
