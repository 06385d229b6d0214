#include "reduced/touch_test.h"

#include <algorithm>

#include "foldproof/ccd.h"

namespace foldproof::internal {

bool TouchTest::leaves_touch(Index leaf_a, Index leaf_b) const {
  for (Index s = h_.leaves()[leaf_a].triangles; s < h_.leaves()[leaf_a + 1].triangles; ++s) {
    const Index begin = leaf_a == leaf_b ? s + 1 : h_.leaves()[leaf_b].triangles;
    for (Index t = begin; t < h_.leaves()[leaf_b + 1].triangles; ++t) {
      if (triangles_touch(h_.triangles()[s], h_.triangles()[t])) return true;
    }
  }
  return false;
}

bool TouchTest::triangles_touch(const Triangle& s, const Triangle& t) const {
  const auto corners = [&](const Triangle& f) {
    return std::array<Vec3, 3>{pose_.at(f[0]), pose_.at(f[1]), pose_.at(f[2])};
  };
  const auto is_in = [](Index v, const Triangle& f) { return std::find(f.begin(), f.end(), v) != f.end(); };
  const auto shared = std::count_if(s.begin(), s.end(), [&](Index v) { return is_in(v, t); });
  if (shared == 0) return triangles_intersect(corners(s), corners(t));
  if (shared != 1) return shared == 3 || folds(s, t);
  const auto opposite_edge_meets = [&](const Triangle& f, const Triangle& g) {
    std::array<Vec3, 2> edge;
    int count = 0;
    for (const Index v : f) {
      if (!is_in(v, g) && count < 2) edge[count++] = pose_.at(v);
    }
    return count == 2 && segment_intersects_triangle(edge, corners(g));
  };
  return opposite_edge_meets(s, t) || opposite_edge_meets(t, s);
}

bool TouchTest::folds(const Triangle& s, const Triangle& t) const {
  std::vector<Vec3> edge, apex;
  for (const Index v : s) (std::find(t.begin(), t.end(), v) != t.end() ? edge : apex).push_back(pose_.at(v));
  for (const Index v : t) {
    if (std::find(s.begin(), s.end(), v) == s.end()) apex.push_back(pose_.at(v));
  }
  return edge.size() != 2 || apex.size() != 2 || triangles_fold(edge[0], edge[1], apex[0], apex[1]);
}

}  // namespace foldproof::internal
