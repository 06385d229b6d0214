#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "foldproof/keypoints.h"
#include "keypoints/surfaces.h"

namespace foldproof {
namespace {

using testing::cylinder;

Vec3 at(const std::vector<double>& positions, Index v) {
  return {positions[3 * v], positions[3 * v + 1], positions[3 * v + 2]};
}

// There is a radius that explains the result: kept vertices are further apart, and every vertex is within it
// of a kept one. Pair by pair, without a grid.
void expect_thinned(const std::vector<double>& positions, const std::vector<Index>& kept) {
  double apart = INFINITY, covered = 0;
  for (std::size_t a = 0; a < kept.size(); ++a) {
    for (std::size_t b = 0; b < a; ++b) {
      apart = std::min(apart, (at(positions, kept[a]) - at(positions, kept[b])).norm());
    }
  }
  for (Index v = 0; v < positions.size() / 3; ++v) {
    double nearest = INFINITY;
    for (const Index k : kept) nearest = std::min(nearest, (at(positions, v) - at(positions, k)).norm());
    covered = std::max(covered, nearest);
  }
  EXPECT_LT(covered, apart);
}

TEST(Thin, KeepsAboutTheCountEvenlySpread) {
  std::mt19937 random(1);
  std::vector<double> uneven = cylinder(60, 60);
  for (double& x : uneven) x += 0.05 * random() * 0x1p-32;
  for (std::size_t v = 0; v < uneven.size() / 2; ++v) uneven[v] = 5 + 0.2 * uneven[v];  // One half is dense.
  for (const auto& positions : {cylinder(60, 60), uneven}) {
    for (const Index count : {2u, 36u, 72u, 400u}) {
      const std::vector<Index> kept = thin_by_radius(positions, count);
      EXPECT_LE(kept.size(), count);
      EXPECT_TRUE(std::is_sorted(kept.begin(), kept.end()));
      EXPECT_EQ(std::set<Index>(kept.begin(), kept.end()).size(), kept.size());
      expect_thinned(positions, kept);
    }
    EXPECT_GE(thin_by_radius(uneven, 400).size(), 360u);
  }
}

TEST(Thin, KeepsEveryPlaceOnceWhenAskedForAll) {
  std::vector<double> positions = cylinder(10, 10);
  EXPECT_EQ(thin_by_radius(positions, 100).size(), 100u);
  EXPECT_EQ(thin_by_radius(positions, 5000).size(), 100u);
  const std::vector<double> copy = positions;
  positions.insert(positions.end(), copy.begin(), copy.end());
  EXPECT_EQ(thin_by_radius(positions, 200).size(), 100u);
}

TEST(Thin, KeepsOneOfOnePlace) {
  EXPECT_EQ(thin_by_radius(std::vector<double>(30, 0.5), 5), std::vector<Index>{0});
  EXPECT_EQ(thin_by_radius(cylinder(5, 5), 1), std::vector<Index>{0});
  EXPECT_EQ(thin_by_radius(cylinder(5, 5), 0), std::vector<Index>{0});
  EXPECT_TRUE(thin_by_radius({}, 5).empty());
}

TEST(Thin, DoesNotDependOnPlaceOrUnit) {
  const std::vector<double> positions = cylinder(40, 40);
  std::vector<double> scaled = positions;
  for (double& x : scaled) x = 0x1p20 * x - 0x1p22;
  EXPECT_EQ(thin_by_radius(scaled, 50), thin_by_radius(positions, 50));
}

}  // namespace
}  // namespace foldproof
