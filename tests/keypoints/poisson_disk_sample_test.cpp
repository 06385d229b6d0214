#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "keypoints/choose.h"
#include "keypoints/surfaces.h"

namespace foldproof {
namespace {

using testing::cylinder;

Vec3 at(const std::vector<double>& positions, Index v) {
  return {positions[3 * v], positions[3 * v + 1], positions[3 * v + 2]};
}

// There is a radius of the sample: kept vertices are farther from each other, and every vertex is within it
// of a kept one. By brute force.
void expect_poisson_disk(const std::vector<double>& positions, const std::vector<Index>& kept) {
  double separation = INFINITY, covering = 0;
  for (std::size_t a = 0; a < kept.size(); ++a) {
    for (std::size_t b = 0; b < a; ++b) {
      separation = std::min(separation, (at(positions, kept[a]) - at(positions, kept[b])).norm());
    }
  }
  for (Index v = 0; v < positions.size() / 3; ++v) {
    double nearest = INFINITY;
    for (const Index k : kept) nearest = std::min(nearest, (at(positions, v) - at(positions, k)).norm());
    covering = std::max(covering, nearest);
  }
  EXPECT_LT(covering, separation);
}

TEST(PoissonDiskSample, KeepsAboutTheCountEvenlySpread) {
  std::mt19937 random(1);
  std::vector<double> uneven = cylinder(60, 60);
  for (double& x : uneven) x += 0.05 * random() * 0x1p-32;
  for (std::size_t v = 0; v < uneven.size() / 2; ++v) uneven[v] = 5 + 0.2 * uneven[v];  // One half is dense.
  for (const auto& positions : {cylinder(60, 60), uneven}) {
    for (const Index count : {2u, 36u, 72u, 400u}) {
      const std::vector<Index> kept = poisson_disk_sample(positions, count);
      EXPECT_LE(kept.size(), count);
      EXPECT_TRUE(std::is_sorted(kept.begin(), kept.end()));
      EXPECT_EQ(std::set<Index>(kept.begin(), kept.end()).size(), kept.size());
      expect_poisson_disk(positions, kept);
    }
    EXPECT_GE(poisson_disk_sample(uneven, 400).size(), 360u);
  }
}

TEST(PoissonDiskSample, KeepsEveryPositionOnceWhenAllFit) {
  std::vector<double> positions = cylinder(10, 10);
  EXPECT_EQ(poisson_disk_sample(positions, 100).size(), 100u);
  EXPECT_EQ(poisson_disk_sample(positions, 5000).size(), 100u);
  const std::vector<double> copy = positions;
  positions.insert(positions.end(), copy.begin(), copy.end());
  EXPECT_EQ(poisson_disk_sample(positions, 200).size(), 100u);
}

TEST(PoissonDiskSample, KeepsOneOfEqualPositions) {
  EXPECT_EQ(poisson_disk_sample(std::vector<double>(30, 0.5), 5), std::vector<Index>{0});
  EXPECT_EQ(poisson_disk_sample(cylinder(5, 5), 1), std::vector<Index>{0});
  EXPECT_EQ(poisson_disk_sample(cylinder(5, 5), 0), std::vector<Index>{0});
  EXPECT_TRUE(poisson_disk_sample({}, 5).empty());
}

TEST(PoissonDiskSample, DoesNotDependOnPositionOrUnit) {
  const std::vector<double> positions = cylinder(40, 40);
  std::vector<double> scaled = positions;
  for (double& x : scaled) x = 0x1p20 * x - 0x1p22;
  EXPECT_EQ(poisson_disk_sample(scaled, 50), poisson_disk_sample(positions, 50));
}

}  // namespace
}  // namespace foldproof
