#include "certificate/coverage.h"

#include <algorithm>
#include <random>

namespace foldproof::testing {

std::int64_t Coverage::orient2d(Corner a, Corner b, Corner c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

Coverage::Coverage(const Patch& patch, const UvMap& uv_map, std::uint64_t seed) {
  const auto add = [&](Uv p) { corners_.push_back({2 * std::int64_t{p[0]}, 2 * std::int64_t{p[1]}}); };
  for (const Uv p : uv_map.uvs) add(p);
  vertices_ = corners_.size();
  for (const Uv p : kChartCorners) add(p);
  triangles_ = patch.triangles;
  triangles_.insert(triangles_.end(), uv_map.scaffold.begin(), uv_map.scaffold.end());
  for (const Corners& t : triangles_) {
    counterclockwise_ = counterclockwise_ && *std::max_element(t.begin(), t.end()) < corners_.size() &&
                        orient2d(corners_[t[0]], corners_[t[1]], corners_[t[2]]) > 0;
  }
  std::mt19937_64 rng(seed);
  for (std::size_t i = 0; i < corners_.size(); ++i)
    values_.push_back(static_cast<std::int64_t>(rng() % 1000003));
}

// The interiors of two counterclockwise triangles are disjoint exactly when one lies to the right of a side
// of the other.
bool Coverage::are_disjoint(const Corners& s, const Corners& t) const {
  const auto has_separating_side = [&](const Corners& p, const Corners& q) {
    for (int k = 0; k < 3; ++k) {
      const Corner a = corners_[p[k]], b = corners_[p[(k + 1) % 3]];
      if (std::all_of(q.begin(), q.end(), [&](std::uint16_t v) { return orient2d(a, b, corners_[v]) <= 0; }))
        return true;
    }
    return false;
  };
  return has_separating_side(s, t) || has_separating_side(t, s);
}

bool Coverage::covers_once() const {
  if (!counterclockwise_) return false;
  const std::int64_t extent = 2 * kChartCorners[0][0];
  std::int64_t area = 0;
  for (const Corners& t : triangles_) {
    for (const std::uint16_t v : t) {
      if (std::max(std::abs(corners_[v].x), std::abs(corners_[v].y)) > extent) return false;
    }
    area += orient2d(corners_[t[0]], corners_[t[1]], corners_[t[2]]);
  }
  if (area != 2 * (2 * extent) * (2 * extent)) return false;
  for (std::size_t i = 0; i < triangles_.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (!are_disjoint(triangles_[i], triangles_[j])) return false;
    }
  }
  return true;
}

oracle::Rational Coverage::value(const Corners& t, Corner at) const {
  oracle::Rational sum = 0;
  for (int k = 0; k < 3; ++k) {
    sum += oracle::Rational(orient2d(corners_[t[(k + 1) % 3]], corners_[t[(k + 2) % 3]], at)) * values_[t[k]];
  }
  return sum / orient2d(corners_[t[0]], corners_[t[1]], corners_[t[2]]);
}

bool Coverage::continuous() const {
  if (!counterclockwise_) return false;
  for (const Corners& t : triangles_) {
    for (int k = 0; k < 3; ++k) {
      const Corner a = corners_[t[k]], b = corners_[t[(k + 1) % 3]];
      const Corner middle{(a.x + b.x) / 2, (a.y + b.y) / 2};  // integers, as corners are even
      const oracle::Rational here = value(t, middle);
      for (const Corners& other : triangles_) {
        bool inside = true;
        for (int c = 0; c < 3; ++c)
          inside = inside && orient2d(corners_[other[c]], corners_[other[(c + 1) % 3]], middle) >= 0;
        if (inside && value(other, middle) != here) return false;
      }
    }
  }
  return true;
}

bool Coverage::touches_border() const {
  const std::int64_t extent = 2 * kChartCorners[0][0];
  return std::any_of(corners_.begin(), corners_.begin() + static_cast<std::ptrdiff_t>(vertices_),
                     [&](Corner c) { return std::max(std::abs(c.x), std::abs(c.y)) == extent; });
}

int Coverage::count_at(int x, int y) const {
  int count = 0;
  for (const Corners& t : triangles_) {
    int left = 0;
    for (int k = 0; k < 3; ++k) {
      const std::int64_t side = orient2d(corners_[t[k]], corners_[t[(k + 1) % 3]], {x, y});
      if (side == 0) return -1;
      left += side > 0;
    }
    // Of either orientation.
    count += left == 3 || left == 0;
  }
  return count;
}

}  // namespace foldproof::testing
