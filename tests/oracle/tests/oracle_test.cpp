// The oracle against cases whose answers are plain from a drawing.
#include "oracle/oracle.h"

#include <gtest/gtest.h>

#include <cmath>

#include "oracle/families.h"

namespace foldproof::oracle {
namespace {

constexpr Kind kVf = Kind::VertexFace, kEe = Kind::EdgeEdge;

// A vertex above the triangle (0,0,0) (4,0,0) (0,4,0).
FourPoints above(double x, double y, double z) {
  return {Vec3(x, y, z), Vec3(0, 0, 0), Vec3(4, 0, 0), Vec3(0, 4, 0)};
}

// Edge from (-1,0,z) to (1,0,z) over the edge from (0,-1,0) to (0,1,0), the first shifted by (x,y,0).
FourPoints crossing(double x, double y, double z) {
  return {Vec3(x - 1, y, z), Vec3(x + 1, y, z), Vec3(0, -1, 0), Vec3(0, 1, 0)};
}

TEST(Oracle, VertexThroughFace) {
  EXPECT_TRUE(touches(kVf, above(1, 1, 1), above(1, 1, -1)));
  EXPECT_FALSE(touches(kVf, above(3, 3, 1), above(3, 3, -1)));
  EXPECT_FALSE(touches(kVf, above(1, 1, 1), above(1, 1, 0x1p-1000)));
}

TEST(Oracle, EdgeThroughEdge) {
  EXPECT_TRUE(touches(kEe, crossing(0, 0, 1), crossing(0, 0, -1)));
  EXPECT_FALSE(touches(kEe, crossing(1.5, 0, 1), crossing(1.5, 0, -1)));
  EXPECT_FALSE(touches(kEe, crossing(0, 1.5, 1), crossing(0, 1.5, -1)));
  EXPECT_TRUE(touches(kEe, crossing(1, 1, 1), crossing(1, 1, -1)));  // End to end.
}

TEST(Oracle, TouchingAtTheEndsOfTheStepCounts) {
  EXPECT_TRUE(touches(kVf, above(1, 1, 1), above(1, 1, 0)));
  EXPECT_FALSE(touches(kVf, above(1, 1, 1), above(1, 1, 0), {1.0, true}));
  EXPECT_TRUE(touches(kVf, above(1, 1, 0), above(1, 1, 1)));
  EXPECT_TRUE(touches(kVf, above(1, 1, 0), above(1, 1, 1), {0.0, false}));
  EXPECT_FALSE(touches(kVf, above(1, 1, 0), above(1, 1, 1), {0.0, true}));
}

TEST(Oracle, BorderOfTheFaceBelongsToIt) {
  EXPECT_TRUE(touches(kVf, above(2, 2, 1), above(2, 2, -1)));  // Through the hypotenuse.
  EXPECT_TRUE(touches(kVf, above(4, 0, 1), above(4, 0, -1)));  // Through a corner.
  const double outside = std::nextafter(2.0, 3.0);
  EXPECT_FALSE(touches(kVf, above(2, outside, 1), above(2, outside, -1)));
}

// The segment from (2t,1) to (-1,-t) passes the origin when 1 = 2 t^2.
TEST(Oracle, IrrationalTimeOfImpactIsBracketedByNeighboringDoubles) {
  for (const double depth : {0.0, 1.0}) {  // A face that is a segment, and a proper one.
    const FourPoints x0 = {Vec3(0, 0, 0), Vec3(0, 1, 0), Vec3(-1, 0, depth), Vec3(-1, 0, -depth)};
    const FourPoints x1 = {Vec3(0, 0, 0), Vec3(2, 1, 0), Vec3(-1, -1, depth), Vec3(-1, -1, -depth)};
    const double after = std::sqrt(0.5);  // Rounds up.
    EXPECT_TRUE(touches(kVf, x0, x1, {after, true}));
    EXPECT_FALSE(touches(kVf, x0, x1, {std::nextafter(after, 0), false}));
  }
}

TEST(Oracle, CoplanarAllTheTime) {
  const auto flat = [](double x, double y) {
    return FourPoints{Vec3(x, y, 7), Vec3(0, 0, 7), Vec3(4, 0, 7), Vec3(0, 4, 7)};
  };
  EXPECT_TRUE(touches(kVf, flat(-1, 2), flat(5, 2)));
  EXPECT_TRUE(touches(kVf, flat(1, 1), flat(1, 1)));
  EXPECT_FALSE(touches(kVf, flat(-1, -1), flat(5, -1)));
  EXPECT_TRUE(touches(kVf, flat(-1, 0), flat(5, 0)));   // Along the border.
  EXPECT_FALSE(touches(kVf, flat(3, 3), flat(5, -1)));  // Around the corner.
}

TEST(Oracle, ParallelAndCollinearEdges) {
  const auto pair = [](double x, double y, double length) {
    return FourPoints{Vec3(x, y, 0), Vec3(x + length, y, 0), Vec3(0, 0, 0), Vec3(1, 0, 0)};
  };
  EXPECT_TRUE(touches(kEe, pair(0.5, 1, 1), pair(0.5, -1, 1)));
  EXPECT_TRUE(touches(kEe, pair(1, 1, 1), pair(1, -1, 1)));  // End to end.
  EXPECT_FALSE(touches(kEe, pair(1.0000000000000002, 1, 1), pair(1.0000000000000002, -1, 1)));
  EXPECT_TRUE(touches(kEe, pair(-9, 0, 1), pair(9, 0, 1)));
  EXPECT_FALSE(touches(kEe, pair(-9, 0, 1), pair(-1.5, 0, 1)));
  EXPECT_TRUE(touches(kEe, pair(1, 1, 0), pair(1, -1, 0)));  // A point.
}

TEST(Oracle, DegenerateFaces) {
  const FourPoints segment = {Vec3(1, 1, 1), Vec3(0, 0, 0), Vec3(4, 4, 0), Vec3(2, 2, 0)};
  FourPoints after = segment;
  after[0] = Vec3(1, 1, -1);
  EXPECT_TRUE(touches(kVf, segment, after));
  after[0] = Vec3(1, 1.25, -1);
  EXPECT_FALSE(touches(kVf, segment, after));
  const FourPoints point = {Vec3(1, 1, 1), Vec3(1, 1, 0), Vec3(1, 1, 0), Vec3(1, 1, 0)};
  after = point;
  after[0] = Vec3(1, 1, -1);
  EXPECT_TRUE(touches(kVf, point, after));
}

TEST(Oracle, SquaredDistance) {
  EXPECT_EQ(squared_distance(kVf, above(1, 1, 1), above(1, 1, -1), 0.25), Rational(1, 4));
  EXPECT_EQ(squared_distance(kVf, above(3, 3, 0), above(3, 3, 0), 0.5), Rational(2));   // To the hypotenuse.
  EXPECT_EQ(squared_distance(kVf, above(7, -4, 0), above(7, -4, 0), 1), Rational(25));  // To a corner.
  EXPECT_EQ(squared_distance(kEe, crossing(0, 0, 3), crossing(0, 0, 3), 0), Rational(9));
  EXPECT_EQ(squared_distance(kEe, crossing(4, 5, 0), crossing(4, 5, 0), 0), Rational(25));
  EXPECT_TRUE(within_distance(kEe, crossing(0, 0, 3), crossing(0, 0, 3), 0, Rational(3)));
  EXPECT_FALSE(within_distance(kEe, crossing(0, 0, 3), crossing(0, 0, 3), 0, Rational(2.999999999)));
}

TEST(Oracle, ApproachBracketsTheSmallestDistance) {
  const FourPoints x0 = crossing(0, 0, 3), x1 = crossing(0.5, 0.25, 1);
  EXPECT_EQ(approach(kEe, x0, x1, 1, 0x1p-20), Approach::Within);
  EXPECT_EQ(approach(kEe, x0, x1, 0.999, 0x1p-20), Approach::Beyond);
  EXPECT_EQ(approach(kEe, x0, x1, 1, 0x1p-20, {1.0, true}), Approach::Close);
  // Passes over: closest in the middle of the step, at distance 1.
  EXPECT_EQ(approach(kVf, above(-9, 1, 1), above(11, 1, 1), 1, 0x1p-20), Approach::Within);
  EXPECT_EQ(approach(kVf, above(-9, 1, 1), above(11, 1, 1), 0.99, 0x1p-20), Approach::Beyond);
}

TEST(Oracle, StaticPredicates) {
  EXPECT_EQ(orientation(Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, -1)), 1);
  EXPECT_EQ(orientation(Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)), -1);
  EXPECT_EQ(orientation(Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(5, 5, 0)), 0);
  const std::array<Vec3, 3> floor = {Vec3(0, 0, 0), Vec3(4, 0, 0), Vec3(0, 4, 0)};
  const auto pole = [](double x, double y, double lo, double hi) {
    return std::array<Vec3, 2>{Vec3(x, y, lo), Vec3(x, y, hi)};
  };
  EXPECT_TRUE(hulls_intersect(pole(1, 1, -1, 1), floor));
  EXPECT_TRUE(hulls_intersect(pole(2, 2, 0, 1), floor));
  EXPECT_FALSE(hulls_intersect(pole(1, 1, 0x1p-60, 1), floor));
  EXPECT_FALSE(hulls_intersect(pole(3, 3, -1, 1), floor));
  const Vec3 v(0, 0, 0);
  EXPECT_TRUE(meet_beyond_edge(v, Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(3, 2, 0)));
  EXPECT_FALSE(meet_beyond_edge(v, Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(3, -2, 0)));
  EXPECT_FALSE(meet_beyond_edge(v, Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(3, 2, 1)));
  EXPECT_TRUE(meet_beyond_edge(v, Vec3(1, 0, 0), Vec3(2, 0, 0), Vec3(3, 0, 0)));
  EXPECT_FALSE(meet_beyond_edge(v, Vec3(1, 0, 0), Vec3(2, 0, 0), Vec3(-3, 0, 0)));
  EXPECT_TRUE(meet_beyond_edge(v, v, Vec3(2, 0, 0), Vec3(3, 0, 0)));
}

// Cases that only hit, or only miss, would test half of the library.
TEST(Families, HitRatesAreBalanced) {
  for (const Family& family : families()) {
    for (const Kind kind : {kVf, kEe}) {
      Rng rng(1);
      int hits = 0;
      constexpr int kCases = 400;
      for (int i = 0; i < kCases; ++i) {
        const Case c = family.make(kind, rng);
        hits += touches(kind, c.x0, c.x1);
      }
      const double rate = double(hits) / kCases;
      EXPECT_GE(rate, 0.3) << family.name << (kind == kVf ? " vertex-face" : " edge-edge");
      EXPECT_LE(rate, 0.7) << family.name << (kind == kVf ? " vertex-face" : " edge-edge");
    }
  }
}

TEST(Families, IntegerFamiliesAreOnTheGrid) {
  for (const Family& family : families()) {
    if (!family.integers) continue;
    Rng rng(2);
    for (int i = 0; i < 500; ++i) {
      const Case c = family.make(i % 2 ? kVf : kEe, rng);
      for (const FourPoints* x : {&c.x0, &c.x1}) {
        for (const Vec3& p : *x) {
          ASSERT_EQ(p, nearest_multiple(p, 1)) << family.name;
          ASSERT_LT(p.cwiseAbs().maxCoeff(), 0x1p20) << family.name;
        }
      }
    }
  }
}

}  // namespace
}  // namespace foldproof::oracle
