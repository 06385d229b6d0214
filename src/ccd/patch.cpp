#include "ccd/patch.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace foldproof {
namespace {

// Point of the segment p-q nearest to the origin; a segment of no length is its end.
Vec3 nearest_on_segment(const Vec3& p, const Vec3& q) {
  const Vec3 side = q - p;
  const double length2 = side.squaredNorm();
  if (length2 == 0) return p;
  return p + std::clamp(-p.dot(side) / length2, 0.0, 1.0) * side;
}

Vec3 nearest_on_border(const PatchCorners& d, int corners) {
  const int far = corners == 4 ? 3 : 2;
  Vec3 best = nearest_on_segment(d[0], d[1]);
  double best2 = best.squaredNorm();
  const auto consider = [&](const Vec3& p, const Vec3& q) {
    const Vec3 point = nearest_on_segment(p, q);
    const double length2 = point.squaredNorm();
    if (length2 < best2) {
      best = point;
      best2 = length2;
    }
  };
  consider(d[0], d[2]);
  consider(d[1], d[far]);
  if (corners == 4) consider(d[2], d[3]);
  return best;
}

double smallest_projection(const Vec3& n, const PatchCorners& d, int corners) {
  double least = n.dot(d[0]);
  for (int k = 1; k < corners; ++k) least = std::min(least, n.dot(d[k]));
  return least;
}

Vec3 direction_of(const Vec3& v, double length) { return length > 0 ? Vec3(v / length) : Vec3::UnitX(); }

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
  const Vec3 border = nearest_on_border(d, corners);
  const double border_distance = border.norm();
  const Vec3 border_normal = direction_of(border, border_distance);
  if (!(inside && across2 > 0) || border_distance <= best.distance) {
    best = {border_distance, border, border_normal};
  } else if (smallest_projection(border_normal, d, corners) > smallest_projection(best.normal, d, corners)) {
    best.normal = border_normal;
  }
  return best;
}

}  // namespace foldproof
