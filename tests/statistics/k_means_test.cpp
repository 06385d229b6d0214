#include <gtest/gtest.h>

#include <set>

#include "statistics/samples.h"
#include "statistics/training.h"

namespace foldproof {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using testing::noise;

Clusters clusters_of(const MatrixXd& points, Index count) {
  auto result = k_means(points, count);
  EXPECT_TRUE(result) << result.error().line();
  return result ? *result : Clusters{};
}

// Groups around distant corners; point k belongs to group k % groups.
MatrixXd blobs(Index groups, Index points, unsigned seed) {
  MatrixXd centers(3, groups);
  for (Index g = 0; g < groups; ++g) centers.col(g) << 10.0 * (g & 1), 10.0 * (g >> 1 & 1), 10.0 * (g >> 2);
  MatrixXd result = noise(3, points, seed);
  for (Index k = 0; k < points; ++k) result.col(k) += centers.col(k % groups);
  return result;
}

double spread_of(const MatrixXd& points, const std::vector<Index>& groups, Index count) {
  MatrixXd sums = MatrixXd::Zero(points.rows(), count);
  VectorXd sizes = VectorXd::Zero(count);
  for (std::size_t k = 0; k < groups.size(); ++k) {
    sums.col(groups[k]) += points.col(k);
    sizes[groups[k]] += 1;
  }
  double spread = 0;
  for (std::size_t k = 0; k < groups.size(); ++k) {
    spread += (points.col(k) - sums.col(groups[k]) / sizes[groups[k]]).squaredNorm();
  }
  return spread;
}

TEST(KMeans, IsAsTightAsTheBestOfAllGroupings) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const MatrixXd points = noise(2, 9, seed);
    double least = INFINITY;
    for (unsigned grouping = 1; grouping < 256; ++grouping) {  // Point 8 is in group 0.
      std::vector<Index> groups(9, 0);
      for (Index k = 0; k < 8; ++k) groups[k] = grouping >> k & 1;
      least = std::min(least, spread_of(points, groups, 2));
    }
    EXPECT_NEAR(clusters_of(points, 2).spread, least, 1e-9) << seed;
  }
}

TEST(KMeans, EveryPointIsWithItsNearestCenter) {
  const MatrixXd points = noise(4, 200, 30);
  for (const Index count : {1u, 2u, 7u, 50u}) {
    const Clusters clusters = clusters_of(points, count);
    ASSERT_EQ(clusters.count(), count);
    EXPECT_NEAR(clusters.spread, spread_of(points, clusters.cluster_of, count), 1e-9);
    Index seen = 0;
    for (Index k = 0; k < 200; ++k) {
      const Index own = clusters.cluster_of[k];
      ASSERT_LE(own, seen);  // Numbered by first point.
      seen = std::max(seen, own + 1);
      const VectorXd squared = (clusters.centers.colwise() - points.col(k)).colwise().squaredNorm();
      EXPECT_LE(squared[own], squared.minCoeff() + 1e-9);
      const Index medoid = clusters.medoids[own];
      EXPECT_EQ(clusters.cluster_of[medoid], own);
      EXPECT_LE((points.col(medoid) - clusters.centers.col(own)).norm(),
                (points.col(k) - clusters.centers.col(own)).norm());
    }
    EXPECT_EQ(seen, count);
  }
}

TEST(KMeans, HasNoEmptyClusterEvenAmongEqualPoints) {
  MatrixXd points(1, 12);
  points << 1, 1, 1, 1, 2, 2, 2, 2, 2, 5, 5, 5;
  for (const Index count : {1u, 2u, 3u, 4u, 40u}) {
    const Clusters clusters = clusters_of(points, count);
    EXPECT_EQ(clusters.count(), std::min(count, 3u));
    EXPECT_EQ(std::set<Index>(clusters.cluster_of.begin(), clusters.cluster_of.end()).size(),
              clusters.count());
  }
  EXPECT_EQ(clusters_of(points, 3).spread, 0);
}

TEST(KMeans, MeasuresTheSilhouette) {
  MatrixXd points(1, 4);
  points << 0, 1, 10, 11;
  const double outer = 1 - 1 / 10.5, inner = 1 - 1 / 9.5;
  EXPECT_NEAR(clusters_of(points, 2).silhouette, (outer + inner) / 2, 1e-12);
  EXPECT_EQ(clusters_of(points, 1).silhouette, 0);
  EXPECT_EQ(clusters_of(points, 4).silhouette, 0);  // Each point alone.
}

TEST(KMeans, ChoosesTheCountOfLargestSilhouette) {
  for (const Index groups : {2u, 3u, 5u, 8u}) {
    const auto clusters = cluster(blobs(groups, 80, 31), 12);
    ASSERT_TRUE(clusters);
    EXPECT_EQ(clusters->count(), groups);
    for (Index k = 0; k < 80; ++k) EXPECT_EQ(clusters->cluster_of[k], k % groups);
  }
  EXPECT_EQ(cluster(blobs(8, 80, 31), 1)->count(), 1u);
  EXPECT_EQ(cluster(noise(20, 60, 32), 8)->count(), 1u);  // One cloud in many dimensions has no groups.
  EXPECT_EQ(cluster(MatrixXd::Ones(3, 10), 5)->count(), 1u);
  EXPECT_EQ(cluster(MatrixXd::Ones(3, 1), 5)->count(), 1u);
}

TEST(KMeans, GivesTheSameTwice) {
  const MatrixXd points = noise(3, 300, 33);
  EXPECT_EQ(clusters_of(points, 9).cluster_of, clusters_of(points, 9).cluster_of);
}

TEST(KMeans, RefusesWhatCannotBeClustered) {
  EXPECT_FALSE(k_means(MatrixXd(3, 0), 2));
  EXPECT_FALSE(k_means(MatrixXd::Ones(3, 4), 0));
  EXPECT_FALSE(cluster(MatrixXd::Ones(3, 4), 0));
  MatrixXd points = noise(3, 4, 34);
  points(0, 3) = testing::kNaN;
  EXPECT_EQ(k_means(points, 2).error().line(),
            "point 3: number 0 is not finite; leave this point out or repair it");
}

}  // namespace
}  // namespace foldproof
