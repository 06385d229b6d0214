// Exact predicates: a floating-point filter, then integers of any size where it cannot decide.

#include <algorithm>
#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <limits>

#include "base/plain_arithmetic.h"
#include "ccd/bounds.h"
#include "foldproof/ccd.h"

// GCC 12 believes that Boost's integers are read before they are written.
#pragma GCC diagnostic ignored "-Wpragmas"
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"

namespace foldproof {
namespace {

using Big = boost::multiprecision::cpp_int;

struct Vec2 {
  double x, y;
  bool operator==(const Vec2&) const = default;
};

// Doubles, times one common power of two, as integers. It does not change signs of homogeneous polynomials.
template <std::size_t N>
std::array<Big, N> to_integers(const std::array<double, N>& values) {
  std::array<int, N> exponents{};
  std::array<std::int64_t, N> mantissas{};
  int lowest = std::numeric_limits<int>::max();
  for (std::size_t i = 0; i < N; ++i) {
    if (values[i] == 0) continue;
    const double fraction = std::frexp(values[i], &exponents[i]);
    mantissas[i] = static_cast<std::int64_t>(std::ldexp(fraction, 53));
    lowest = std::min(lowest, exponents[i]);
  }
  std::array<Big, N> result;
  for (std::size_t i = 0; i < N; ++i) {
    if (mantissas[i] != 0) result[i] = Big(mantissas[i]) << (exponents[i] - lowest);
  }
  return result;
}

int orient3d_exact(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const auto v =
      to_integers<12>({a.x(), a.y(), a.z(), b.x(), b.y(), b.z(), c.x(), c.y(), c.z(), d.x(), d.y(), d.z()});
  const Big ax = v[0] - v[9], ay = v[1] - v[10], az = v[2] - v[11];
  const Big bx = v[3] - v[9], by = v[4] - v[10], bz = v[5] - v[11];
  const Big cx = v[6] - v[9], cy = v[7] - v[10], cz = v[8] - v[11];
  return Big(ax * (by * cz - bz * cy) - ay * (bx * cz - bz * cx) + az * (bx * cy - by * cx)).sign();
}

int orient2d_exact(const Vec2& a, const Vec2& b, const Vec2& c) {
  const auto v = to_integers<6>({a.x, a.y, b.x, b.y, c.x, c.y});
  return Big((v[0] - v[4]) * (v[3] - v[5]) - (v[1] - v[5]) * (v[2] - v[4])).sign();
}

bool filter_applies(double smallest_size, double largest_size) {
  return smallest_size > kSmallestFiltered && largest_size < kLargestFiltered;
}

// Positive when a, b, c turn counterclockwise.
int orient2d(const Vec2& a, const Vec2& b, const Vec2& c) {
  const double ax = a.x - c.x, ay = a.y - c.y, bx = b.x - c.x, by = b.y - c.y;
  const double sx = std::max(std::abs(ax), std::abs(bx)), sy = std::max(std::abs(ay), std::abs(by));
  // Differences of doubles are zero only when they are equal, as denormal ones are kept (tests/arithmetic:
  // Modes, Rounding).
  if (sx == 0 || sy == 0) return 0;
  if (filter_applies(std::min(sx, sy), std::max(sx, sy))) {
    const double det = ax * by - ay * bx;
    const double error = 16 * 0x1p-53 * sx * sy;  // docs/soundness.md, E1
    if (det > error) return 1;
    if (det < -error) return -1;
  }
  return orient2d_exact(a, b, c);
}

int sign_of_volume(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const Vec3 ad = a - d, bd = b - d, cd = c - d;
  const Vec3 size = ad.cwiseAbs().cwiseMax(bd.cwiseAbs()).cwiseMax(cd.cwiseAbs());
  if (size.minCoeff() == 0) return 0;  // all four lie in a plane perpendicular to an axis
  if (filter_applies(size.minCoeff(), size.maxCoeff())) {
    const double det = ad.x() * (bd.y() * cd.z() - bd.z() * cd.y()) -
                       ad.y() * (bd.x() * cd.z() - bd.z() * cd.x()) +
                       ad.z() * (bd.x() * cd.y() - bd.y() * cd.x());
    const double error = kVolumeError * (size.x() * size.y() * size.z());  // docs/soundness.md, E1
    if (det > error) return 1;
    if (det < -error) return -1;
  }
  return orient3d_exact(a, b, c, d);
}

Vec2 project(const Vec3& p, int axis) {
  return axis == 0 ? Vec2{p.y(), p.z()} : axis == 1 ? Vec2{p.z(), p.x()} : Vec2{p.x(), p.y()};
}

// An axis along which the projected triangle has an area; -1 when there is none.
int projection_axis(const Vec3& a, const Vec3& b, const Vec3& c) {
  for (int axis = 0; axis < 3; ++axis) {
    if (orient2d(project(a, axis), project(b, axis), project(c, axis)) != 0) return axis;
  }
  return -1;
}

bool before(const Vec3& a, const Vec3& b) {
  return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
}

// For collinear points the lexicographic order is the order along the line.
bool collinear_segments_meet(const Vec3& p, const Vec3& q, const Vec3& r, const Vec3& s) {
  const auto [p0, p1] = before(q, p) ? std::pair(q, p) : std::pair(p, q);
  const auto [r0, r1] = before(s, r) ? std::pair(s, r) : std::pair(r, s);
  return !before(p1, r0) && !before(r1, p0);
}

bool between(const Vec2& p, const Vec2& q, const Vec2& x) {
  return std::min(p.x, q.x) <= x.x && x.x <= std::max(p.x, q.x) && std::min(p.y, q.y) <= x.y &&
         x.y <= std::max(p.y, q.y);
}

bool segments_meet_2d(const Vec2& p, const Vec2& q, const Vec2& r, const Vec2& s) {
  const int pr = orient2d(p, q, r), ps = orient2d(p, q, s), rp = orient2d(r, s, p), rq = orient2d(r, s, q);
  if (pr * ps < 0 && rp * rq < 0) return true;
  return (pr == 0 && between(p, q, r)) || (ps == 0 && between(p, q, s)) || (rp == 0 && between(r, s, p)) ||
         (rq == 0 && between(r, s, q));
}

bool segments_meet(const Vec3& p, const Vec3& q, const Vec3& r, const Vec3& s) {
  if (sign_of_volume(p, q, r, s) != 0) return false;
  for (const auto& [a, b, c] :
       {std::array{p, q, r}, std::array{p, q, s}, std::array{r, s, p}, std::array{r, s, q}}) {
    const int axis = projection_axis(a, b, c);
    if (axis >= 0)
      return segments_meet_2d(project(p, axis), project(q, axis), project(r, axis), project(s, axis));
  }
  return collinear_segments_meet(p, q, r, s);
}

bool coplanar_segment_meets_triangle(const std::array<Vec3, 2>& s, const std::array<Vec3, 3>& t, int axis) {
  const Vec2 p = project(s[0], axis), q = project(s[1], axis);
  const std::array<Vec2, 3> c{project(t[0], axis), project(t[1], axis), project(t[2], axis)};
  int lowest = 1, highest = -1;
  for (int k = 0; k < 3; ++k) {
    if (segments_meet_2d(p, q, c[k], c[(k + 1) % 3])) return true;
    const int side = orient2d(c[k], c[(k + 1) % 3], p);
    lowest = std::min(lowest, side);
    highest = std::max(highest, side);
  }
  return lowest >= 0 || highest <= 0;
}

bool segment_meets_triangle(const std::array<Vec3, 2>& s, const std::array<Vec3, 3>& t) {
  const auto& [p, q] = s;
  const auto& [a, b, c] = t;
  const int at_p = sign_of_volume(a, b, c, p), at_q = sign_of_volume(a, b, c, q);
  if (at_p * at_q > 0) return false;
  if (at_p == 0 && at_q == 0) {
    const int axis = projection_axis(a, b, c);
    if (axis >= 0) return coplanar_segment_meets_triangle(s, t, axis);
    return segments_meet(p, q, a, b) || segments_meet(p, q, b, c) || segments_meet(p, q, c, a);
  }
  const int ab = sign_of_volume(p, q, a, b), bc = sign_of_volume(p, q, b, c), ca = sign_of_volume(p, q, c, a);
  return (ab >= 0 && bc >= 0 && ca >= 0) || (ab <= 0 && bc <= 0 && ca <= 0);
}

bool triangles_meet(const std::array<Vec3, 3>& a, const std::array<Vec3, 3>& b) {
  // The plane of one triangle separates it from the other one in most pairs.
  for (const auto& [t, o] : {std::pair(&a, &b), std::pair(&b, &a)}) {
    const int side = sign_of_volume((*t)[0], (*t)[1], (*t)[2], (*o)[0]);
    if (side != 0 && sign_of_volume((*t)[0], (*t)[1], (*t)[2], (*o)[1]) == side &&
        sign_of_volume((*t)[0], (*t)[1], (*t)[2], (*o)[2]) == side) {
      return false;
    }
  }
  for (int k = 0; k < 3; ++k) {
    if (segment_meets_triangle({a[k], a[(k + 1) % 3]}, b)) return true;
    if (segment_meets_triangle({b[k], b[(k + 1) % 3]}, a)) return true;
  }
  return false;
}

bool fold_flat(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const int axis = projection_axis(a, b, c);
  if (axis >= 0 && projection_axis(a, b, d) >= 0) {
    if (sign_of_volume(a, b, c, d) != 0) return false;
    const Vec2 a2 = project(a, axis), b2 = project(b, axis);
    return orient2d(a2, b2, project(c, axis)) == orient2d(a2, b2, project(d, axis));
  }
  const auto beyond_edge = [&](const Vec3& p, const Vec3& other) {
    return segment_meets_triangle({p, p}, {a, b, other}) && !segments_meet(p, p, a, b);
  };
  return beyond_edge(c, d) || beyond_edge(d, c);
}

}  // namespace

int orient3d(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const PlainArithmetic plain;
  return sign_of_volume(a, b, c, d);
}

bool triangle_has_area(const Vec3& a, const Vec3& b, const Vec3& c) {
  const PlainArithmetic plain;
  return projection_axis(a, b, c) >= 0;
}

bool triangles_intersect(const std::array<Vec3, 3>& a, const std::array<Vec3, 3>& b) {
  const PlainArithmetic plain;
  return triangles_meet(a, b);
}

bool segment_intersects_triangle(const std::array<Vec3, 2>& s, const std::array<Vec3, 3>& t) {
  const PlainArithmetic plain;
  return segment_meets_triangle(s, t);
}

bool triangles_fold(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const PlainArithmetic plain;
  return fold_flat(a, b, c, d);
}

}  // namespace foldproof
