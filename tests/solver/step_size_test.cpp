// Step sizes: the tolerance of each pair, shorter steps, and the share of the gap that is left.

#include <gtest/gtest.h>

#include "soups.h"

namespace foldproof::oracle {
namespace {

using Limit = StepSize::Limit;

ContactChecker checker_of(const Soup& soup, const ContactSettings& settings = {}) {
  return ContactChecker(std::make_shared<const CollisionMesh>(mesh_of(soup, {})), settings);
}

Soup scaled(Soup soup, double scale) {
  for (double& c : soup.x0) c *= scale;
  for (double& c : soup.x1) c *= scale;
  return soup;
}

// The tolerance as ContactSettings documents it; the narrow phase raises it to what rounding needs.
double tolerance_of(const FeaturePair& pair, std::span<const double> x0) {
  const FourPoints x = pair.at(x0);
  double extent = 0;
  const int first_of_b = pair.kind() == Kind::EdgeEdge ? 2 : 1;
  for (int a = 0; a < first_of_b; ++a) {
    for (int b = first_of_b; b < 4; ++b) extent = std::max(extent, (x[a] - x[b]).cwiseAbs().maxCoeff());
  }
  return 0x1p-30 * extent;
}

CcdResult ccd_of(const FeaturePair& pair, const Soup& soup, double distance) {
  const auto test = pair.kind() == Kind::EdgeEdge ? edge_edge_ccd : vertex_face_ccd;
  return test(pair.at(soup.x0), pair.at(soup.x1), {distance, tolerance_of(pair, soup.x0)});
}

double distance_at(const FeaturePair& pair, std::span<const double> x) {
  const FourPoints at = pair.at(x);
  return (pair.kind() == Kind::EdgeEdge ? edge_edge_closest(at) : vertex_face_closest(at)).distance;
}

// A triangle `height` above a floor of size 1, which moves by `displacement`; and a face that is apart and
// moves by `far` along x. Vertices 0 to 2 are the floor, 3 to 5 the triangle.
Soup above_a_floor(double height, const Vec3& displacement, double far) {
  Soup soup;
  soup.faces = {{0, 1, 2}, {3, 4, 5}, {6, 7, 8}};
  soup.x0 = {-1,     -1, 0,   1,      -1, 0, 0, 1, 0, -0.1, -0.1, height, 0.1, -0.1,
             height, 0,  0.1, height, 3,  3, 3, 4, 3, 3,    3,    4,      3};
  soup.x1 = soup.x0;
  for (std::size_t i = 9; i < 18; ++i) soup.x1[i] += displacement[i % 3];
  for (std::size_t i = 18; i < 27; i += 3) soup.x1[i] += far;
  return soup;
}

TEST(StepSize, WhatMovesFastFarAwayStopsNothingElse) {
  for (const double scale : {1e-6, 1e-3, 1.0, 1e3, 1e6}) {
    for (const double far : {0.0, 1e6, 1e9, 1e12}) {
      const Soup soup = scaled(above_a_floor(1e-4, {0, 0, -2e-4}, far), scale);
      ContactChecker checker = checker_of(soup);
      const StepSize size = checker.collision_free_step_size(soup.x0, soup.x1).value();
      EXPECT_NEAR(size.share, 0.4, 1e-5) << scale << ' ' << far;
      EXPECT_EQ(size.limit, Limit::Contact);
      EXPECT_NEAR(size.contact_time, 0.5, 1e-5);
      EXPECT_LT(size.contact.vertices[0], 6u);
    }
  }
}

// What is fast itself is undecided for the whole step, as positions are not that exact, and free for a part.
TEST(StepSize, APartIsProvenWhereTheWholeIsNot) {
  for (const double scale : {1e-6, 1.0, 1e6}) {
    const Soup soup = scaled(above_a_floor(1e-7, {1e12, 0, 1e12}, 0), scale);
    ContactChecker checker = checker_of(soup);
    const StepSize size = checker.collision_free_step_size(soup.x0, soup.x1).value();
    EXPECT_GT(size.share, 1e-8);
    EXPECT_LT(size.share, 1);
    EXPECT_EQ(size.limit, Limit::Contact);
    EXPECT_EQ(size.contact_time, 0);
    std::vector<double> end(soup.x0.size());
    step_towards(soup.x0, soup.x1, size.share, end);
    EXPECT_TRUE(checker.is_step_collision_free(soup.x0, end).is_yes());
    EXPECT_TRUE(checker.is_step_collision_free(soup.x0, soup.x1).is_no());
  }
}

TEST(StepSize, NothingMovesWhereAPairIsTooCloseInPlace) {
  for (const double scale : {1e-6, 1.0, 1e6}) {
    for (const double far : {0.0, 1e9}) {
      const Soup soup = scaled(above_a_floor(0.5 + 0x1p-33, {0, 0, 1}, far), scale);
      ContactChecker checker = checker_of(soup);
      const StepSize size = checker.collision_free_step_size(soup.x0, soup.x1, 0.5 * scale).value();
      EXPECT_EQ(size.share, 0);
      EXPECT_EQ(size.limit, Limit::Start);
      EXPECT_EQ(size.contact_time, 0);
      EXPECT_NEAR(size.contact.distance, (0.5 + 0x1p-33) * scale, 0x1p-40 * scale);
    }
  }
}

// Whatever else is in the scene, the first contact is that of the narrow phase with the pair's own tolerance.
TEST(StepSize, EachPairHasItsOwnTolerance) {
  int whole = 0, part = 0, start = 0;
  for (int seed = 0; seed < 240; ++seed) {
    Rng rng(static_cast<std::uint64_t>(seed));
    const double grid = seed % 2 == 0 ? 0x1p-40 : 0x1p-4, distance = seed % 3 == 0 ? 0.03 : 0;
    Soup soup = random_soup(rng, 3, 4, 4, 0.25, grid);
    soup.x1[0] += seed % 4 < 2 ? 0 : 1e7;
    for (int k = 0; k < 3; ++k) {
      const double scale = std::array{1e-6, 1.0, 1e6}[k];
      const Soup here = scaled(soup, scale);
      ContactChecker checker = checker_of(here);
      CcdResult first{Answer::Separated, 2};
      for (const FeaturePair& pair :
           all_pairs(here, checker.mesh().edges(), [](Index, Index) { return true; })) {
        const CcdResult r = ccd_of(pair, here, distance * scale);
        if (r.answer != Answer::Separated && r.toi < first.toi) first = r;
      }
      const StepSize size = checker.collision_free_step_size(here.x0, here.x1, distance * scale).value();
      ASSERT_EQ(size.limit == Limit::None, first.toi > 1) << seed << ' ' << scale;
      if (first.toi <= 1) {
        ASSERT_EQ(size.contact_time, first.toi) << seed << ' ' << scale;
      }
      whole += size.share == 1;
      part += size.share > 0 && size.share < 1;
      start += size.share == 0;
    }
  }
  EXPECT_GT(whole, 50);
  EXPECT_GT(part, 50);
  EXPECT_GT(start, 0);
}

// F2: also where the positions of stretches are denormal numbers.
TEST(StepSize, LongStepsAreCutAtAllScales) {
  Soup soup = two_sheets();
  for (std::size_t i = soup.x0.size() / 2 + 2; i < soup.x0.size(); i += 3) soup.x1[i] -= 1.5;
  for (const double scale : {1.0, 0x1p-530, 0x1p-1000, 0x1p-1020, 0x1p530, 0x1p900}) {
    const Soup here = scaled(soup, scale);
    ContactChecker checker = checker_of(here);
    const StepSize size = checker.collision_free_step_size(here.x0, here.x1).value();
    EXPECT_NEAR(size.contact_time, 0.2 / 1.5, 1e-6) << scale;
    EXPECT_NEAR(size.share, 0.16 / 1.5, 1e-6) << scale;
    EXPECT_GT(checker.work().refits, 3u) << scale;
    EXPECT_LT(checker.work().candidates_vf + checker.work().candidates_ee, 2'000'000u) << scale;
  }
}

// V2: segments with a common vertex may fold onto each other; the next ones may not.
TEST(StepSize, RodsFoldAtAVertexButMeetTheSegmentBeyond) {
  for (const double tip : {0.5, 1.5}) {
    Soup rod;
    rod.edges = {{0, 1}, {1, 2}, {2, 3}};
    rod.x0 = rod.x1 = {tip, -0.5, 0, 0, 0, 0, 1, 0, 0, 1, 1, 1};
    rod.x1[1] = 0.5;
    ContactChecker checker = checker_of(rod);
    const StepSize size = checker.collision_free_step_size(rod.x0, rod.x1).value();
    EXPECT_EQ(size.limit, tip < 1 ? Limit::None : Limit::Contact);
    EXPECT_NEAR(size.share, tip < 1 ? 1 : 0.4, 1e-6);
    rod.x0[1] = 0;  // folded flat
    EXPECT_EQ(checker.is_step_collision_free(rod.x0, rod.x0).is_yes(), tip < 1);
    EXPECT_EQ(checker.has_intersections(rod.x0).is_no(), tip < 1);
    EXPECT_EQ(checker.minimum_distance(rod.x0, 2).value() > 0, tip < 1);
  }
}

ContactSettings rescaling_distance(double rescaling = 0.8) {
  ContactSettings settings;
  settings.conservative_rescaling = rescaling;
  settings.rescale_distance = true;
  return settings;
}

// A point passes another; its distance falls less and less fast.
TEST(StepSize, ARescaledDistanceIsAShareOfWhatItWas) {
  Soup soup;
  soup.x0 = {0, 0, 0, 1, 0.15, 0};
  soup.x1 = {0, 0, 0, 0, 0.15, 0};
  for (const double rescaling : {0.9, 0.8, 0.5, 0.1}) {
    ContactChecker checker = checker_of(soup, rescaling_distance(rescaling));
    const StepSize size = checker.collision_free_step_size(soup.x0, soup.x1, 0.2).value();
    std::vector<double> end(soup.x0.size());
    step_towards(soup.x0, soup.x1, size.share, end);
    const double gap = std::hypot(1, 0.15) - 0.2, left = std::hypot(end[3], 0.15) - 0.2;
    EXPECT_GE(left, (1 - rescaling) * gap - 1e-8);
    EXPECT_LE(left, (1 - rescaling) * gap + 0.02);
    EXPECT_EQ(size.limit, Limit::Contact);
    EXPECT_NEAR(size.contact.distance, 0.2 + (1 - rescaling) * gap, 1e-6);
    EXPECT_GE(size.contact_time, size.share);
  }
}

// A point passes another, without a collision, before the triangle comes to the floor.
TEST(StepSize, APairThatDoesNotCollideKeepsItsShareOfTheGap) {
  for (const double start : {1.0, 2.0}) {  // the triangle's gap, of which a fifth is kept, is 1
    Soup soup = above_a_floor(1, {0, 0, -2}, 0);
    soup.x0.insert(soup.x0.end(), {10, 0, 0, 10 + start, 0.01, 0});
    soup.x1.insert(soup.x1.end(), {10, 0, 0, 10 - 3 * start, 0.01, 0});
    ContactChecker usual = checker_of(soup), rescaling = checker_of(soup, rescaling_distance());
    EXPECT_NEAR(usual.collision_free_step_size(soup.x0, soup.x1).value().share, 0.4, 1e-6);
    const StepSize size = rescaling.collision_free_step_size(soup.x0, soup.x1).value();
    EXPECT_NEAR(size.contact_time, (start - 0.2) / (4 * start), 1e-3);
    EXPECT_NEAR(size.share, size.contact_time * 63 / 64, 1e-6);
    EXPECT_GE(size.contact.vertices[0], 9u);
    EXPECT_NEAR(size.contact.distance, 0.2, 1e-6);
    soup.x1[31] = soup.x0[31] = 0.3;  // farther than that
    EXPECT_NEAR(rescaling.collision_free_step_size(soup.x0, soup.x1).value().share, 0.4, 1e-6);
    soup.x1[31] = soup.x0[31] = 0.01;
    for (std::size_t i = 9; i < 18; ++i) soup.x1[i] = soup.x0[i];  // and when nothing collides
    EXPECT_EQ(rescaling.collision_free_step_size(soup.x0, soup.x1).value().share, 1);
  }
}

// A point slides in above the floor, where the sign of the volume proves that they do not touch.
TEST(StepSize, TheVolumeDoesNotProveAGap) {
  Soup soup = above_a_floor(1, {0, 0, -2}, 0);
  soup.x0.insert(soup.x0.end(), {2, -0.5, 0.01});
  soup.x1.insert(soup.x1.end(), {-2, -0.5, 0.01});
  ContactChecker usual = checker_of(soup), rescaling = checker_of(soup, rescaling_distance());
  EXPECT_NEAR(usual.collision_free_step_size(soup.x0, soup.x1).value().share, 0.4, 1e-6);
  const StepSize size = rescaling.collision_free_step_size(soup.x0, soup.x1).value();
  EXPECT_NEAR(size.contact_time, (2 - 0.75 - 0.1 * std::sqrt(5)) / 4, 1e-3);
  EXPECT_NEAR(size.contact.distance, 0.2, 1e-6);
  EXPECT_EQ(size.contact.vertices[0], 9u);
}

// Every pair keeps what is promised, against exact distances.
TEST(StepSize, RescaledDistancesHoldForAllPairs) {
  int shorter = 0, part = 0;
  for (int seed = 0; seed < 150; ++seed) {
    Rng rng(9000000 + static_cast<std::uint64_t>(seed));
    const double distance = seed % 2 == 0 ? 0.01 : 0;
    const Soup soup = random_soup(rng, 3, 4, 4, 0.25, 0x1p-40);
    ContactChecker usual = checker_of(soup), checker = checker_of(soup, rescaling_distance());
    const auto pairs = all_pairs(soup, checker.mesh().edges(), [](Index, Index) { return true; });
    const StepSize size = checker.collision_free_step_size(soup.x0, soup.x1, distance).value();
    if (size.share == 0 || size.share == 1) continue;
    ++part;
    shorter += size.share < usual.collision_free_step_size(soup.x0, soup.x1, distance).value().share;
    std::vector<double> end(soup.x0.size());
    step_towards(soup.x0, soup.x1, size.share, end);
    ASSERT_TRUE(checker.is_step_collision_free(soup.x0, end, distance).is_yes()) << seed;
    const FeaturePair* first = nullptr;
    double earliest = 2;
    for (const FeaturePair& pair : pairs) {
      const CcdResult r = ccd_of(pair, soup, distance);
      if (r.answer == Answer::Separated || r.toi >= earliest) continue;
      first = &pair;
      earliest = r.toi;
    }
    ASSERT_NE(first, nullptr);
    const double most = 0.2 * (distance_at(*first, soup.x0) - distance);
    for (const FeaturePair& pair : pairs) {
      const double tolerance = 2 * tolerance_of(pair, soup.x0) + 1e-12;
      const double gap = std::min(most, 0.2 * (distance_at(pair, soup.x0) - distance)) - tolerance;
      if (gap <= 0) continue;
      ASSERT_NE(approach(pair.kind(), pair.at(soup.x0), pair.at(end), distance + gap, 1e-9), Approach::Within)
          << seed;
    }
  }
  EXPECT_GT(part, 30);
  EXPECT_GT(shorter, 5);
}

}  // namespace
}  // namespace foldproof::oracle
