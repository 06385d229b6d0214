// Exact predicates on every choice of points of small grids, against integers and separating directions. The
// grids are scaled such that the filter decides, or such that only integers of any size can
// (docs/soundness.md, E1 to E3).
#include <gtest/gtest.h>

#include <cmath>

#include "foldproof/ccd.h"

namespace foldproof {
namespace {

using Point = std::array<int, 3>;

std::vector<Point> grid(int side) {
  std::vector<Point> all;
  for (int x = 0; x < side; ++x) {
    for (int y = 0; y < side; ++y) {
      for (int z = 0; z < side; ++z) all.push_back({x, y, z});
    }
  }
  return all;
}

// Within the filter's range, beyond it on both sides, at the smallest denormal numbers, and far from the
// origin, where differences are the last digits.
struct Placement {
  double scale, offset;
  Vec3 operator()(const Point& p) const {
    return {offset + scale * p[0], offset + scale * p[1], offset + scale * p[2]};
  }
};
const Placement kPlacements[] = {{1, 0}, {0x1p400, 0}, {0x1p-400, 0}, {0x1p-1074, 0}, {0x1p-52, 1}};

Point minus(const Point& a, const Point& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Point cross(const Point& a, const Point& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
int dot(const Point& a, const Point& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
int sign(int x) { return (x > 0) - (x < 0); }

TEST(Predicates, OrientationOfAnyFourPoints) {
  const auto points = grid(3);
  for (const Placement& place : kPlacements) {
    for (const Point& a : points) {
      for (const Point& b : points) {
        for (const Point& c : points) {
          const Point& d = points[13];  // the middle; with other points all differences are among these
          const int expected = sign(dot(minus(a, d), cross(minus(b, d), minus(c, d))));
          ASSERT_EQ(orient3d(place(a), place(b), place(c), place(d)), expected);
        }
      }
    }
  }
}

TEST(Predicates, AreaOfAnyThreePoints) {
  const auto points = grid(3);
  for (const Placement& place : kPlacements) {
    for (const Point& a : points) {
      for (const Point& b : points) {
        for (const Point& c : points) {
          const bool expected = cross(minus(b, a), minus(c, a)) != Point{};
          ASSERT_EQ(triangle_has_area(place(a), place(b), place(c)), expected);
        }
      }
    }
  }
}

using Points = std::vector<Point>;

// Convex sets that do not meet have a plane between them. With corners as near as these, one of its normals
// has small integers as coordinates.
bool can_be_separated(const Points& s, const Points& t) {
  constexpr int kLargest = 3;
  for (int x = -kLargest; x <= kLargest; ++x) {
    for (int y = -kLargest; y <= kLargest; ++y) {
      for (int z = -kLargest; z <= kLargest; ++z) {
        int highest = -100, lowest = 100;
        for (const Point& p : s) highest = std::max(highest, dot({x, y, z}, p));
        for (const Point& p : t) lowest = std::min(lowest, dot({x, y, z}, p));
        if (highest < lowest) return true;
      }
    }
  }
  return false;
}

TEST(Predicates, AnyTwoTrianglesOfACube) {
  const auto points = grid(2);
  std::vector<Points> triangles;  // those without an area, too
  for (std::size_t a = 0; a < points.size(); ++a) {
    for (std::size_t b = a; b < points.size(); ++b) {
      for (std::size_t c = b; c < points.size(); ++c) triangles.push_back({points[a], points[b], points[c]});
    }
  }
  int meet = 0;
  for (const Points& s : triangles) {
    for (const Points& t : triangles) {
      const bool expected = !can_be_separated(s, t);
      meet += expected;
      for (const Placement& place : kPlacements) {
        const std::array<Vec3, 3> one{place(s[0]), place(s[1]), place(s[2])},
            other{place(t[0]), place(t[1]), place(t[2])};
        ASSERT_EQ(triangles_intersect(one, other), expected);
      }
    }
  }
  EXPECT_GT(meet, 1000);
}

}  // namespace
}  // namespace foldproof
