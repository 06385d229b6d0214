// Balls of pairs of nodes against steps inside them, feature by feature; and a search that tries to break
// them.
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

// Pairs of nodes of all sizes: a random way down from the root with itself.
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
      const int way = static_cast<int>(random() % 3);
      pair = way == 0   ? NodePairIds{left, left}
             : way == 1 ? NodePairIds{right, right}
                        : NodePairIds{left, right};
    } else {
      pair[larger] = random() % 2 ? left : right;
    }
  }
}

TEST_P(Balls, StepsInsideAreFree) {
  Maker maker(mesh());
  std::mt19937 random(11);
  int with_ball = 0;
  for (int round = 0; round < 200; ++round) {
    const NodePairIds pair = random_pair(*maker.motion->hierarchy(), random);
    const double radius = maker.balls.radius(pair, 0, 1e6);
    if (radius == 0) continue;
    ++with_ball;
    // Balls of far pairs are too large to be shown wrong by any step.
    const Features features(*maker.motion, pair);
    for (int k = 0; k < 4; ++k) {
      const auto p0 = scaled(random_direction(*maker.motion, random), radius);
      const auto p1 = scaled(random_direction(*maker.motion, random), radius);
      ASSERT_FALSE(features.touch(p0, p1)) << pair[0] << " " << pair[1] << " radius " << radius;
    }
  }
  EXPECT_GT(with_ball, 100);
}

TEST_P(Balls, SearchBreaksNoneButFindsEachPlantedMistake) {
  Maker maker(mesh());
  std::mt19937 random(12);
  int tried = 0, broken_when_wrong = 0;
  for (int round = 0; round < 400 && tried < 12; ++round) {
    const NodePairIds pair = random_pair(*maker.motion->hierarchy(), random);
    const double radius = maker.balls.radius(pair, 0, 1e6);
    if (radius == 0 || radius > 8) continue;
    ++tried;
    EXPECT_FALSE(search_breaks(*maker.motion, pair, radius, 60, random)) << pair[0] << " " << pair[1];
    broken_when_wrong += search_breaks(*maker.motion, pair, 6 * radius, 60, random);
  }
  EXPECT_EQ(tried, 12);
  EXPECT_GE(broken_when_wrong, tried / 2);
}

// What is proven apart is proven farther apart than the gap.
TEST_P(Balls, KeepTheGap) {
  const double gap = 0.01;
  Maker maker(mesh(), gap), without(mesh());
  std::mt19937 random(13);
  int with_ball = 0;
  for (int round = 0; round < 200; ++round) {
    const NodePairIds pair = random_pair(*maker.motion->hierarchy(), random);
    const double radius = maker.balls.radius(pair, 0, 1e6);
    EXPECT_LE(radius, without.balls.radius(pair, 0, 1e6) * (1 + 1e-6));
    if (radius == 0) continue;
    ++with_ball;
    const Features features(*maker.motion, pair);
    for (int k = 0; k < 2; ++k) {
      const auto p = scaled(random_direction(*maker.motion, random), radius);
      ASSERT_GT(features.distance(p), gap) << pair[0] << " " << pair[1] << " radius " << radius;
    }
  }
  EXPECT_GT(with_ball, 50);
}

INSTANTIATE_TEST_SUITE_P(Models, Balls, ::testing::Values("tube", "cloth"),
                         [](const auto& info) { return std::string(info.param); });

}  // namespace
}  // namespace foldproof::testing
