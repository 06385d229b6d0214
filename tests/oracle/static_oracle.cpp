// Exact predicates for features that stand still.
#include <array>
#include <vector>

#include "oracle/integer_points.h"
#include "oracle/oracle.h"

namespace foldproof::oracle {
namespace {

Int determinant(const IntPoint& a, const IntPoint& b, const IntPoint& c) { return dot(cross(a, b), c); }

// Flat tetrahedra are left to their triangles.
bool solid_tetrahedron_holds_origin(const IntPoint& a, const IntPoint& b, const IntPoint& c,
                                    const IntPoint& d) {
  const int whole = determinant(b - a, c - a, d - a).sign();
  if (whole == 0) return false;
  // Each corner replaced by the origin in turn.
  return determinant(b, c, d).sign() * whole >= 0 && determinant(a, d, c).sign() * whole >= 0 &&
         determinant(a, b, d).sign() * whole >= 0 && determinant(a, c, b).sign() * whole >= 0;
}

bool hull_holds_origin(std::vector<IntPoint> p) {
  while (p.size() < 3) p.push_back(p.back());
  const std::size_t n = p.size();
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = i + 1; j < n; ++j) {
      for (std::size_t k = j + 1; k < n; ++k) {
        if (triangle_holds_origin(p[i], p[j], p[k])) return true;
        for (std::size_t l = k + 1; l < n; ++l) {
          if (solid_tetrahedron_holds_origin(p[i], p[j], p[k], p[l])) return true;
        }
      }
    }
  }
  return false;
}

}  // namespace

int orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const std::array<Vec3, 4> points = {a, b, c, d};
  const std::vector<IntPoint> p = to_grid(points).points;
  // Seen from the side to which the normal of abc points, abc runs counter-clockwise.
  return -determinant(p[1] - p[0], p[2] - p[0], p[3] - p[0]).sign();
}

bool hulls_intersect(std::span<const Vec3> a, std::span<const Vec3> b) {
  std::vector<Vec3> all(a.begin(), a.end());
  all.insert(all.end(), b.begin(), b.end());
  const std::vector<IntPoint> p = to_grid(all).points;
  std::vector<IntPoint> differences;
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::size_t j = a.size(); j < p.size(); ++j) differences.push_back(p[i] - p[j]);
  }
  return hull_holds_origin(differences);
}

bool collinear(const Vec3& a, const Vec3& b, const Vec3& c) {
  const std::array<Vec3, 3> points = {a, b, c};
  const std::vector<IntPoint> p = to_grid(points).points;
  return is_zero(cross(p[1] - p[0], p[2] - p[0]));
}

bool meet_beyond_edge(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const std::array<Vec3, 4> points = {a, b, c, d};
  const std::vector<IntPoint> p = to_grid(points).points;
  const IntPoint ab = p[1] - p[0], ac = p[2] - p[0], ad = p[3] - p[0];
  if (is_zero(ab)) return is_zero(cross(ac, ad)) && dot(ac, ad).sign() > 0;
  const IntPoint normal_c = cross(ab, ac), normal_d = cross(ab, ad);
  if (!is_zero(normal_c) && !is_zero(normal_d)) {
    // Two half planes that start at the line ab are the same one, or meet on that line only.
    return is_zero(cross(normal_c, normal_d)) && dot(normal_c, normal_d).sign() > 0;
  }
  if (!is_zero(normal_c) || !is_zero(normal_d))
    return false;  // One meets the line of the other only between a and b.
  const IntPoint bc = p[2] - p[1], bd = p[3] - p[1];
  const bool beyond_a = dot(ac, ab).sign() < 0 && dot(ad, ab).sign() < 0;
  const bool beyond_b = dot(bc, ab).sign() > 0 && dot(bd, ab).sign() > 0;
  return beyond_a || beyond_b;
}

}  // namespace foldproof::oracle
