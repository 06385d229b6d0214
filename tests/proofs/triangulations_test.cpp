// chart_is_valid against a definition of its own, on every set of triangles over few points: it accepts those
// that triangulate the square (docs/soundness.md, Theorem 2).
#include <gtest/gtest.h>

#include <algorithm>

#include "certificate/chart_plane.h"

namespace foldproof {
namespace {

// Points of the plane in a square; the last four are its corners.
struct Points {
  std::vector<Uv> at;
  std::size_t inside() const { return at.size() - kChartCorners.size(); }
};

Points with_corners(std::vector<Uv> inside) {
  inside.insert(inside.end(), kChartCorners.begin(), kChartCorners.end());
  return {std::move(inside)};
}

using Corners = std::array<std::uint16_t, 3>;

// Twice the signed area.
std::int64_t area(const Points& p, std::uint16_t a, std::uint16_t b, std::uint16_t c) {
  const auto x = [&](std::uint16_t i) { return std::int64_t{p.at[i][0]}; };
  const auto y = [&](std::uint16_t i) { return std::int64_t{p.at[i][1]}; };
  return x(a) * y(b) - x(b) * y(a) + x(b) * y(c) - x(c) * y(b) + x(c) * y(a) - x(a) * y(c);
}

// Whether no point inside of one triangle lies in the other: a side of one of them has the other one beyond
// it.
bool are_disjoint(const Points& p, const Corners& s, const Corners& t) {
  for (const auto& [one, other] : {std::pair(&s, &t), std::pair(&t, &s)}) {
    for (int k = 0; k < 3; ++k) {
      const std::uint16_t a = (*one)[k], b = (*one)[(k + 1) % 3];
      if (std::all_of(other->begin(), other->end(), [&](std::uint16_t v) { return area(p, a, b, v) <= 0; }))
        return true;
    }
  }
  return false;
}

// Whether a point lies between the ends of a triangle's side.
bool splits_a_side(const Points& p, std::uint16_t v, const Corners& t) {
  for (int k = 0; k < 3; ++k) {
    const std::uint16_t a = t[k], b = t[(k + 1) % 3];
    const auto along = [&](int axis) {
      return (std::int64_t{p.at[v][axis]} - p.at[a][axis]) * (std::int64_t{p.at[b][axis]} - p.at[v][axis]);
    };
    if (area(p, a, b, v) == 0 && along(0) >= 0 && along(1) >= 0 && along(0) + along(1) > 0) return true;
  }
  return false;
}

bool fit_together(const Points& p, const Corners& s, const Corners& t) {
  if (!are_disjoint(p, s, t)) return false;
  for (int k = 0; k < 3; ++k) {
    if (splits_a_side(p, s[k], t) || splits_a_side(p, t[k], s)) return false;
  }
  return true;
}

// Every triangle over the points, in one or in both orientations.
std::vector<Corners> all_triangles(const Points& p, bool both_orientations) {
  std::vector<Corners> all;
  const auto count = static_cast<std::uint16_t>(p.at.size());
  for (std::uint16_t a = 0; a < count; ++a) {
    for (std::uint16_t b = a + 1; b < count; ++b) {
      for (std::uint16_t c = b + 1; c < count; ++c) {
        const bool counterclockwise = area(p, a, b, c) > 0;
        if (counterclockwise || both_orientations) all.push_back({a, b, c});
        if (!counterclockwise || both_orientations) all.push_back({a, c, b});
      }
    }
  }
  return all;
}

struct Count {
  int valid = 0, right_area = 0;
};

// Sets of triangles, by the bits of their numbers. A set triangulates the square when every two of its
// triangles fit together, all are counterclockwise, and their areas add up.
class AllSets {
 public:
  AllSets(const Points& points, bool both_orientations)
      : points_(points), triangles_(all_triangles(points, both_orientations)) {
    for (const Corners& t : triangles_) {
      std::uint64_t misfits = 0;
      for (std::size_t k = 0; k < triangles_.size(); ++k) {
        if (&t != &triangles_[k] && !fit_together(points, t, triangles_[k])) misfits |= std::uint64_t{1} << k;
      }
      misfits_.push_back(misfits);
      areas_.push_back(area(points, t[0], t[1], t[2]));
    }
    patch_.vertices.resize(points.inside());
    map_.uvs.assign(points.at.begin(), points.at.end() - 4);
    map_.heights.resize(points.inside());
  }

  std::size_t triangles() const { return triangles_.size(); }

  // Every set.
  Count compare_all() {
    for (std::uint64_t set = 0; set < std::uint64_t{1} << triangles_.size(); ++set) compare(set);
    return count_;
  }
  // Every set of counterclockwise triangles with the square's area; others are rejected for their area.
  Count compare_right_areas() {
    add_triangles(0, 0, 0);
    return count_;
  }

 private:
  static constexpr std::int64_t kArea = 2 * std::int64_t{64000} * 64000;

  void add_triangles(std::size_t from, std::uint64_t set, std::int64_t total) {
    if (total == kArea) compare(set);
    for (std::size_t k = from; k < triangles_.size(); ++k) {
      if (areas_[k] > 0 && total + areas_[k] <= kArea)
        add_triangles(k + 1, set | std::uint64_t{1} << k, total + areas_[k]);
    }
  }

  void compare(std::uint64_t set) {
    bool fits = true;
    std::int64_t total = 0;
    patch_.triangles.clear();
    map_.scaffold.clear();
    for (std::uint64_t left = set; left != 0; left &= left - 1) {
      const int k = __builtin_ctzll(left);
      const Corners& t = triangles_[k];
      fits &= areas_[k] > 0 && (misfits_[k] & set) == 0;
      total += areas_[k];
      const bool scaffold = std::max({t[0], t[1], t[2]}) >= points_.inside();
      (scaffold ? map_.scaffold : patch_.triangles).push_back(t);
    }
    const bool expected = fits && total == kArea;
    ASSERT_EQ(chart_is_valid(patch_, map_, scratch_), expected) << "set " << set;
    count_.valid += expected;
    count_.right_area += total == kArea;
  }

  const Points points_;
  const std::vector<Corners> triangles_;
  std::vector<std::uint64_t> misfits_;
  std::vector<std::int64_t> areas_;
  Patch patch_;
  UvMap map_;
  HalfEdgeSet scratch_;
  Count count_;
};

TEST(Triangulations, FourAndFivePointsInBothOrientations) {
  EXPECT_EQ(AllSets(with_corners({}), true).compare_all().valid, 2) << "two diagonals";
  // The point is left out, joined to all corners, or inside of one of two triangles.
  for (const auto& [point, valid] :
       {std::pair(Uv{1000, 3000}, 2 + 1 + 2), std::pair(Uv{-31999, 31998}, 2 + 1 + 2),
        std::pair(Uv{7, 7}, 2 + 1 + 1), std::pair(Uv{0, 0}, 2 + 1)}) {
    AllSets sets(with_corners({point}), true);
    ASSERT_EQ(sets.triangles(), 20u);
    const Count count = sets.compare_all();
    EXPECT_EQ(count.valid, valid);
    EXPECT_GT(count.right_area, count.valid);
  }
}

TEST(Triangulations, SixPoints) {
  // General, symmetric, and on a diagonal.
  for (const auto& [a, b] :
       {std::pair(Uv{-9000, 4000}, Uv{7000, 1000}), std::pair(Uv{-16000, 0}, Uv{16000, 0}),
        std::pair(Uv{-8000, -8000}, Uv{8000, 8000})}) {
    AllSets sets(with_corners({a, b}), false);
    ASSERT_EQ(sets.triangles(), 20u);
    const Count count = sets.compare_all();
    EXPECT_GT(count.valid, 0);
    EXPECT_GT(count.right_area, count.valid) << "some sets overlap and leave as much open";
  }
}

TEST(Triangulations, SevenPoints) {
  for (const auto& inside : {std::vector<Uv>{{-9000, 4000}, {7000, 1000}, {2000, -20000}},
                             std::vector<Uv>{{-16000, 0}, {0, 0}, {16000, 0}}}) {
    AllSets sets(with_corners(inside), false);
    ASSERT_EQ(sets.triangles(), 35u);
    EXPECT_GT(sets.compare_right_areas().valid, 10);
  }
}

}  // namespace
}  // namespace foldproof
