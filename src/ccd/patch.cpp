#include "ccd/patch.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace foldproof {
namespace {

// Nearest point of the border, as the segment it lies on.
struct BorderPoint {
  Vec3 point;
  double distance2 = std::numeric_limits<double>::infinity();
  const Vec3 *p = nullptr, *q = nullptr;
  bool at_corner = false;

  void consider(const Vec3& from, const Vec3& to) {
    const Vec3 side = to - from;
    const double length2 = side.squaredNorm();
    const double s = length2 > 0 ? std::clamp(-from.dot(side) / length2, 0.0, 1.0) : 0;
    const Vec3 candidate = s < 1 ? Vec3(from + s * side) : to;
    const double candidate2 = candidate.squaredNorm();
    if (candidate2 < distance2) *this = {candidate, candidate2, &from, &to, s == 0 || s == 1};
  }

  // Inside a side, the difference of nearly equal vectors would leave `point` with a wild direction; made
  // from the side itself, the direction is across it to the last digits.
  Vec3 direction() const {
    const Vec3 side = (*q - *p).normalized();
    const Vec3 along = at_corner ? point : Vec3(side.cross(p->cross(side)));
    const double length = along.norm();
    return length > 0 ? Vec3(along / length) : Vec3::UnitX();
  }
};

BorderPoint nearest_on_border(const PatchCorners& d, int corners) {
  BorderPoint best;
  best.consider(d[0], d[1]);
  best.consider(d[0], d[2]);
  best.consider(d[1], d[corners == 4 ? 3 : 2]);
  if (corners == 4) best.consider(d[2], d[3]);
  return best;
}

double smallest_projection(const Vec3& n, const PatchCorners& d, int corners) {
  double least = n.dot(d[0]);
  for (int k = 1; k < corners; ++k) least = std::min(least, n.dot(d[k]));
  return least;
}

}  // namespace

PatchClosest closest_to_origin(const PatchCorners& d, int corners) {
  const Vec3 e1 = d[1] - d[0], e2 = d[2] - d[0];
  const Vec3 across = e1.cross(e2);
  const double across2 = across.squaredNorm();
  const double beta = e2.cross(d[0]).dot(across), gamma = d[0].cross(e1).dot(across);
  const bool inside = beta >= 0 && gamma >= 0 &&
                      (corners == 4 ? beta <= across2 && gamma <= across2 : beta + gamma <= across2);
  // Nearly flat patches: the inside coordinates are noise, so the border is looked at as well.
  const bool slender = !(across2 > 1e-12 * e1.squaredNorm() * e2.squaredNorm());

  PatchClosest best;
  if (inside && across2 > 0) {
    best.difference = d[0] + (beta / across2) * e1 + (gamma / across2) * e2;
    best.distance = best.difference.norm();
    const double length = std::sqrt(across2);
    best.normal = across * ((across.dot(d[0]) < 0 ? -1 : 1) / length);
    if (!slender) return best;
  }
  const BorderPoint border = nearest_on_border(d, corners);
  const double border_distance = std::sqrt(border.distance2);
  const Vec3 border_normal = border.direction();
  if (!(inside && across2 > 0) || border_distance <= best.distance) {
    best = {border_distance, border.point, border_normal};
  } else if (smallest_projection(border_normal, d, corners) > smallest_projection(best.normal, d, corners)) {
    best.normal = border_normal;
  }
  return best;
}

}  // namespace foldproof
