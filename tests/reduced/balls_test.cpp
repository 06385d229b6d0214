// Balls of pairs of nodes against steps inside them, feature by feature, and against a search for contact.
#include <gtest/gtest.h>

#include "reduced/features.h"

namespace foldproof::testing {
namespace {

class Balls : public ::testing::TestWithParam<const char*> {
 protected:
  ReducedMesh mesh() const {
    return std::string(GetParam()) == "tube" ? bending_tube(12, 24, 0.5) : waving_cloth(14);
  }
};

// Pairs of nodes of all sizes: a random descent from the root with itself.
NodePairIds random_pair(const Hierarchy& h, std::mt19937& random) {
  const auto leaf_limit = std::size_t{1} << random() % 4;
  NodePairIds pair{0, 0};
  for (;;) {
    const auto &a = h.nodes()[pair[0]], &b = h.nodes()[pair[1]];
    const std::size_t size_a = a.leaf_end - a.leaf_begin, size_b = b.leaf_end - b.leaf_begin;
    if (std::max(size_a, size_b) <= leaf_limit) return pair;
    const Index larger = size_a >= size_b ? 0 : 1;
    const Index at = pair[larger], left = at + 1, right = h.nodes()[at].right;
    if (pair[0] == pair[1]) {
      const int choice = static_cast<int>(random() % 3);
      pair = choice == 0   ? NodePairIds{left, left}
             : choice == 1 ? NodePairIds{right, right}
                           : NodePairIds{left, right};
    } else {
      pair[larger] = random() % 2 ? left : right;
    }
  }
}

TEST_P(Balls, StepsInsideAreFree) {
  BallSetup setup(mesh());
  std::mt19937 random(11);
  int with_ball = 0;
  for (int round = 0; round < 200; ++round) {
    const NodePairIds pair = random_pair(*setup.motion->hierarchy(), random);
    const double radius = setup.balls.radius(pair, 0, 1e6);
    if (radius == 0) continue;
    ++with_ball;
    const Features features(*setup.motion, pair);
    for (int k = 0; k < 4; ++k) {
      const auto p0 = scaled(random_direction(*setup.motion, random), radius);
      const auto p1 = scaled(random_direction(*setup.motion, random), radius);
      ASSERT_FALSE(features.touch(p0, p1)) << pair[0] << " " << pair[1] << " radius " << radius;
    }
  }
  EXPECT_GT(with_ball, 100);
}

TEST_P(Balls, SearchFindsContactOnlyWhereBallsAreTooLarge) {
  BallSetup setup(mesh());
  std::mt19937 random(12);
  int tried = 0, found_when_wrong = 0;
  for (int round = 0; round < 400 && tried < 12; ++round) {
    const NodePairIds pair = random_pair(*setup.motion->hierarchy(), random);
    const double radius = setup.balls.radius(pair, 0, 1e6);
    if (radius == 0 || radius > 8) continue;
    ++tried;
    EXPECT_FALSE(search_finds_contact(*setup.motion, pair, radius, 60, random)) << pair[0] << " " << pair[1];
    found_when_wrong += search_finds_contact(*setup.motion, pair, 6 * radius, 60, random);
  }
  EXPECT_EQ(tried, 12);
  EXPECT_GE(found_when_wrong, tried / 2);
}

TEST_P(Balls, KeepTheGap) {
  const double gap = 0.01;
  BallSetup setup(mesh(), gap), without(mesh());
  std::mt19937 random(13);
  int with_ball = 0;
  for (int round = 0; round < 200; ++round) {
    const NodePairIds pair = random_pair(*setup.motion->hierarchy(), random);
    const double radius = setup.balls.radius(pair, 0, 1e6);
    EXPECT_LE(radius, without.balls.radius(pair, 0, 1e6) * (1 + 1e-6));
    if (radius == 0) continue;
    ++with_ball;
    const Features features(*setup.motion, pair);
    for (int k = 0; k < 2; ++k) {
      const auto p = scaled(random_direction(*setup.motion, random), radius);
      ASSERT_GT(features.distance(p), gap) << pair[0] << " " << pair[1] << " radius " << radius;
    }
  }
  EXPECT_GT(with_ball, 50);
}

INSTANTIATE_TEST_SUITE_P(Models, Balls, ::testing::Values("tube", "cloth"),
                         [](const auto& info) { return std::string(info.param); });

}  // namespace
}  // namespace foldproof::testing
