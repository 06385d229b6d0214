#include "check/triangles_cross.h"

#include <algorithm>

namespace foldproof::internal {

bool have_same_vertices(Triangle a, Triangle b) {
  std::ranges::sort(a);
  std::ranges::sort(b);
  return a == b;
}

bool copies_cross(const Triangle& t) { return t[0] != t[1] && t[1] != t[2] && t[2] != t[0]; }

bool triangles_cross(std::span<const double> x, const Triangle& s, const Triangle& t) {
  std::array<Index, 3> shared{}, only_s{}, only_t{};
  int common = 0, count_s = 0, count_t = 0;
  for (const Index v : s) {
    const bool both = std::find(t.begin(), t.end(), v) != t.end();
    (both ? shared[common++] : only_s[count_s++]) = v;
  }
  for (const Index v : t) {
    if (std::find(s.begin(), s.end(), v) == s.end()) only_t[count_t++] = v;
  }
  const auto p = [&](Index v) { return position(x, v); };
  if (common == 0) return triangles_intersect(corners(x, s), corners(x, t));
  if (count_s == 0 && count_t == 0) return copies_cross(s);
  if (count_s == 0 || count_t == 0) return false;
  if (count_s == 1 && count_t == 1)
    return triangles_fold(p(shared[0]), p(shared[1]), p(only_s[0]), p(only_t[0]));
  // One common vertex: they meet elsewhere only where the opposite side of one meets the other. The opposite
  // side of a triangle that names a vertex twice may be a point.
  const auto opposite_side = [&](const std::array<Index, 3>& only, int count) {
    return std::array<Vec3, 2>{p(only[0]), p(only[count - 1])};
  };
  return segment_intersects_triangle(opposite_side(only_s, count_s), corners(x, t)) ||
         segment_intersects_triangle(opposite_side(only_t, count_t), corners(x, s));
}

}  // namespace foldproof::internal
