#include "page/contact.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

namespace foldproof {
namespace {

/// Positions of vertices at a time within a step.
struct PositionsAt {
  Positions x0, x1;
  double t;
  Vec3 operator()(Index object, Index vertex) const {
    Vec3 x;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::size_t k = 3 * std::size_t{vertex} + axis;
      x[axis] = std::lerp(x0[object][k], x1[object][k], t);
    }
    return x;
  }
};

/// The parameter in [0,1] of the point on segment ab that is nearest to `x`.
double nearest(const Vec3& x, const Vec3& a, const Vec3& b) {
  const double square = (b - a).squaredNorm();
  return square > 0 ? std::clamp((x - a).dot(b - a) / square, 0.0, 1.0) : 0;
}

/// Adds the points where edges of `a` cross `b`.
void add_crossings(const std::array<Vec3, 3>& a, const std::array<Vec3, 3>& b, std::vector<Vec3>& out) {
  const Vec3 normal = (b[1] - b[0]).cross(b[2] - b[0]);
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3 &from = a[k], &to = a[(k + 1) % 3];
    const double above = normal.dot(from - b[0]), below = normal.dot(to - b[0]);
    if (above == below || std::signbit(above) == std::signbit(below)) continue;
    const Vec3 x = from + above / (above - below) * (to - from);
    bool inside = true;
    for (std::size_t e = 0; e < 3; ++e) inside &= normal.dot((b[(e + 1) % 3] - b[e]).cross(x - b[e])) >= 0;
    if (inside) out.push_back(x);
  }
}

}  // namespace

// The ends of the common segment of two triangles are on edges of one or the other.
Vec3 crossing_point(const std::array<Vec3, 3>& a, const std::array<Vec3, 3>& b) {
  std::vector<Vec3> ends;
  add_crossings(a, b, ends);
  add_crossings(b, a, ends);
  if (ends.empty()) {  // coplanar
    ends.assign(a.begin(), a.end());
    ends.insert(ends.end(), b.begin(), b.end());
  }
  return std::accumulate(ends.begin(), ends.end(), Vec3(Vec3::Zero())) / static_cast<double>(ends.size());
}

Vec3 contact_point(Positions x0, Positions x1, const VertexFaceCollision& c,
                   std::span<const Triangle> triangles) {
  const PositionsAt at{x0, x1, c.toi};
  const Triangle& f = triangles[c.face];
  const Vec3 vertex = at(c.vertex_object, c.vertex);
  const Closest closest = vertex_face_closest(
      {vertex, at(c.face_object, f[0]), at(c.face_object, f[1]), at(c.face_object, f[2])});
  return vertex - closest.difference / 2;
}

// The nearest points of two segments are interior to both, or one of them is an end point.
Vec3 contact_point(Positions x0, Positions x1, const EdgeEdgeCollision& c) {
  const PositionsAt at{x0, x1, c.toi};
  const Vec3 a0 = at(c.object_a, c.a[0]), a1 = at(c.object_a, c.a[1]);
  const Vec3 b0 = at(c.object_b, c.b[0]), b1 = at(c.object_b, c.b[1]);
  Vec3 middle = (a0 + b0) / 2;
  double min_distance = std::numeric_limits<double>::infinity();
  const auto consider = [&](double s, double t) {
    const Vec3 on_a = a0 + s * (a1 - a0), on_b = b0 + t * (b1 - b0);
    const double distance = (on_a - on_b).squaredNorm();
    if (!(distance < min_distance)) return;
    min_distance = distance;
    middle = (on_a + on_b) / 2;
  };
  consider(0, nearest(a0, b0, b1));
  consider(1, nearest(a1, b0, b1));
  consider(nearest(b0, a0, a1), 0);
  consider(nearest(b1, a0, a1), 1);
  const Vec3 a = a1 - a0, b = b1 - b0, gap = b0 - a0;
  const double aa = a.squaredNorm(), bb = b.squaredNorm(), ab = a.dot(b), det = aa * bb - ab * ab;
  if (det > 0) {
    const double s = (bb * a.dot(gap) - ab * b.dot(gap)) / det;
    const double t = (ab * a.dot(gap) - aa * b.dot(gap)) / det;
    if (s > 0 && s < 1 && t > 0 && t < 1) consider(s, t);
  }
  return middle;
}

}  // namespace foldproof
