#include "reduced/touch_test.h"

#include <algorithm>

#include "check/triangles_cross.h"

namespace foldproof::internal {

bool TouchTest::leaves_touch(Index leaf_a, Index leaf_b) const {
  for (Index s = h_.leaves()[leaf_a].triangles; s < h_.leaves()[leaf_a + 1].triangles; ++s) {
    const Index begin = leaf_a == leaf_b ? s + 1 : h_.leaves()[leaf_b].triangles;
    for (Index t = begin; t < h_.leaves()[leaf_b + 1].triangles; ++t) {
      if (!may_cross(h_.topology(), h_.triangle_ids()[s], h_.triangle_ids()[t])) continue;
      if (triangles_touch(h_.triangles()[s], h_.triangles()[t])) return true;
    }
  }
  return false;
}

// Numbers the vertices of both anew, for their positions.
bool TouchTest::triangles_touch(const Triangle& s, const Triangle& t) const {
  std::array<Index, 6> ids{};
  std::array<double, 18> x{};
  Index count = 0;
  const auto local = [&](const Triangle& of) {
    Triangle out{};
    for (std::size_t k = 0; k < 3; ++k) {
      out[k] = static_cast<Index>(std::find(ids.begin(), ids.begin() + count, of[k]) - ids.begin());
      if (out[k] < count) continue;
      ids[count] = of[k];
      const Vec3 p = pose_.at(of[k]);
      std::copy(p.begin(), p.end(), x.begin() + 3 * count++);
    }
    return out;
  };
  const Triangle a = local(s), b = local(t);
  return triangles_cross(x, a, b);
}

}  // namespace foldproof::internal
