#include "oracle/integer_points.h"

#include <algorithm>
#include <climits>
#include <cmath>

namespace foldproof::oracle {
namespace {

struct Scaled {
  std::int64_t mantissa = 0;
  int exponent = INT_MAX;  // Zero fits on any grid.
};

Scaled split(double value) {
  if (value == 0) return {};
  int exponent = 0;
  const double fraction = std::frexp(value, &exponent);
  return {static_cast<std::int64_t>(std::ldexp(fraction, 53)), exponent - 53};
}

}  // namespace

Grid to_grid(std::span<const Vec3> points) {
  Grid grid;
  int lowest = INT_MAX;
  for (const Vec3& p : points) {
    for (int k = 0; k < 3; ++k) lowest = std::min(lowest, split(p[k]).exponent);
  }
  grid.exponent = lowest == INT_MAX ? 0 : lowest;
  for (const Vec3& p : points) {
    IntPoint q;
    for (int k = 0; k < 3; ++k) {
      const Scaled s = split(p[k]);
      if (s.mantissa != 0) q[k] = Int(s.mantissa) << static_cast<unsigned>(s.exponent - grid.exponent);
    }
    grid.points.push_back(q);
  }
  return grid;
}

bool segment_holds_origin(const IntPoint& p, const IntPoint& q) {
  // On one line with the origin, and not on the same side of it.
  return is_zero(cross(p, q)) && dot(p, q).sign() <= 0;
}

bool triangle_holds_origin(const IntPoint& p, const IntPoint& q, const IntPoint& r) {
  const IntPoint pq = cross(p, q), qr = cross(q, r), rp = cross(r, p);
  const IntPoint normal = pq + qr + rp;
  if (is_zero(normal)) {
    return segment_holds_origin(p, q) || segment_holds_origin(q, r) || segment_holds_origin(r, p);
  }
  if (!dot(normal, p).is_zero()) return false;
  return dot(pq, normal).sign() >= 0 && dot(qr, normal).sign() >= 0 && dot(rp, normal).sign() >= 0;
}

}  // namespace foldproof::oracle
