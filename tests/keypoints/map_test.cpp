#include <gtest/gtest.h>

#include "keypoints/leave_one_out.h"
#include "keypoints/pose_error.h"
#include "keypoints/surfaces.h"

namespace foldproof {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using testing::bent;
using testing::cylinder;
using testing::pose_error;

MatrixXd key_rows(const MatrixXd& matrix, const std::vector<Index>& vertices) {
  MatrixXd rows(3 * vertices.size(), matrix.cols());
  for (std::size_t k = 0; k < 3 * vertices.size(); ++k) rows.row(k) = matrix.row(3 * vertices[k / 3] + k % 3);
  return rows;
}

// A weight per row: the root of the number of vertices nearest to the key point, found one by one.
VectorXd weights(const VectorXd& pose, const std::vector<Index>& vertices) {
  VectorXd counts = VectorXd::Zero(vertices.size());
  for (Eigen::Index v = 0; v < pose.size(); v += 3) {
    std::size_t nearest = 0;
    const auto distance = [&](std::size_t k) {
      return (pose.segment<3>(3 * vertices[k]) - pose.segment<3>(v)).norm();
    };
    for (std::size_t k = 1; k < vertices.size(); ++k) {
      if (distance(k) < distance(nearest)) nearest = k;
    }
    counts[nearest] += 1;
  }
  VectorXd result(3 * vertices.size());
  for (Eigen::Index k = 0; k < result.size(); ++k) result[k] = std::sqrt(counts[k / 3]);
  return result;
}

struct MapTest : ::testing::Test {
  std::vector<double> rest = cylinder(16, 20);
  MatrixXd poses = bent(rest, 15, 1);
  Pca subspace = *pca(poses, {6, 1.0});
};

TEST_F(MapTest, FindsTheCoordinatesOfAPoseInTheSubspace) {
  const KeyPointMap map(subspace, std::vector<Index>{300, 5, 77, 160});
  const VectorXd p = VectorXd::LinSpaced(6, -1, 2), x = subspace.reconstruct(p);
  EXPECT_FALSE(map.rank_deficient());
  EXPECT_LE((map.coordinates(map.gather(x)) - p).norm(), 1e-9 * p.norm());
}

TEST_F(MapTest, SolvesLeastSquaresWeightedByNearestVertices) {
  const std::vector<Index> vertices{300, 5, 77, 160, 161, 12};
  const KeyPointMap map(subspace, vertices);
  VectorXd x = poses.col(3);
  x.array() += VectorXd::LinSpaced(x.size(), -0.3, 0.4).array().sin();
  const VectorXd keys = key_rows(x, vertices);
  EXPECT_EQ(map.gather(x), keys);
  const VectorXd weight = weights(subspace.mean, vertices);
  const MatrixXd rows = weight.asDiagonal() * key_rows(subspace.basis, vertices);
  const VectorXd expected =
      rows.colPivHouseholderQr().solve(weight.asDiagonal() * (keys - key_rows(subspace.mean, vertices)));
  EXPECT_LE((map.coordinates(keys) - expected).norm(), 1e-9 * expected.norm());
}

TEST_F(MapTest, StaysBoundedWhenKeyPointsDoNotDetermineAllModes) {
  // One vertex has three numbers for six modes.
  const KeyPointMap map(subspace, std::vector<Index>{150});
  EXPECT_TRUE(map.rank_deficient());
  const VectorXd keys = map.gather(poses.col(2));
  const VectorXd p = map.coordinates(keys);
  EXPECT_LE((map.gather(subspace.reconstruct(p)) - keys).norm(), 1e-3);
  // The shortest solution, except for the ridge.
  const VectorXd shortest = key_rows(subspace.basis, {150})
                                .completeOrthogonalDecomposition()
                                .solve(keys - key_rows(subspace.mean, {150}));
  EXPECT_LE((p - shortest).norm(), 1e-4 * shortest.norm());
}

TEST_F(MapTest, KeepsUndeterminedModesAtZero) {
  Pca blind = subspace;
  for (const Index v : {4, 90, 200}) blind.basis.col(2).segment<3>(3 * v).setZero();
  const KeyPointMap map(blind, std::vector<Index>{4, 90, 200});
  EXPECT_TRUE(map.rank_deficient());
  EXPECT_LE(std::abs(map.coordinates(map.gather(poses.col(1)))[2]), 1e-9);
}

TEST_F(MapTest, ClustersOfKeyPointsDoNotOutweighTheOthers) {
  // Sixteen neighbors against six that are spread out, in a pose outside the subspace.
  std::vector<Index> vertices{300, 5, 77, 160, 210, 12};
  const VectorXd x = bent(rest, 1, 99).col(0);
  const double spread_out = pose_error(subspace, KeyPointMap(subspace, vertices), x).total.mean;
  for (Index v = 304; v < 320; ++v) vertices.push_back(v);
  EXPECT_LT(pose_error(subspace, KeyPointMap(subspace, vertices), x).total.mean, 1.1 * spread_out);
}

TEST_F(MapTest, WorksWithoutKeyPointsOrModes) {
  const KeyPointMap none(subspace, {});
  EXPECT_EQ(none.coordinates(VectorXd(0)), VectorXd(VectorXd::Zero(6)));
  const Pca still = *pca(poses.leftCols(1));
  const KeyPointMap map(still, std::vector<Index>{3, 4});
  EXPECT_EQ(map.coordinates(map.gather(poses.col(2))).size(), 0);
  EXPECT_FALSE(map.rank_deficient());
}

TEST_F(MapTest, MeasuresDistancesOfVertices) {
  VectorXd a = VectorXd::Zero(9), b = a;
  b << 0, 3, 4, 0, 0, 0, 0, -1, 0;
  const VertexDistance distance = vertex_distance(a, b);
  EXPECT_DOUBLE_EQ(distance.mean, 2);
  EXPECT_DOUBLE_EQ(distance.worst, 5);
  EXPECT_EQ(distance.worst_vertex, 0u);
}

TEST_F(MapTest, SeparatesProjectionErrorAndCueingError) {
  const std::vector<Index> vertices{300, 5, 77, 160, 161, 12};
  const KeyPointMap map(subspace, vertices);
  const VectorXd x = bent(rest, 1, 99).col(0);
  const PoseError error = pose_error(subspace, map, x);

  const VectorXd difference = x - subspace.mean;
  const VectorXd best = subspace.basis * subspace.basis.colPivHouseholderQr().solve(difference);
  const VectorXd keys = subspace.basis * map.coordinates(map.gather(x));
  EXPECT_NEAR(error.projection.mean, vertex_distance(difference, best).mean, 1e-12);
  EXPECT_NEAR(error.projection.worst, vertex_distance(difference, best).worst, 1e-12);
  EXPECT_NEAR(error.cueing.mean, vertex_distance(best, keys).mean, 1e-12);
  EXPECT_NEAR(error.total.mean, vertex_distance(difference, keys).mean, 1e-12);
  EXPECT_GT(error.projection.mean, 0);
  // The residual is orthogonal to the subspace, so their squares add up to the whole.
  EXPECT_NEAR((difference - keys).squaredNorm(),
              (difference - best).squaredNorm() + (best - keys).squaredNorm(), 1e-9);

  std::vector<Index> all(rest.size() / 3);
  for (Index v = 0; v < all.size(); ++v) all[v] = v;
  EXPECT_LE(pose_error(subspace, KeyPointMap(subspace, all), x).cueing.worst, 1e-9);
}

TEST_F(MapTest, LeaveOneOutEqualsTrainingWithoutTheSample) {
  const std::vector<Index> vertices{300, 5, 77, 160, 161, 12, 250};
  for (const SubspaceSize size : {SubspaceSize{0, 0.98}, SubspaceSize{4, 1.0}}) {
    const auto errors = leave_one_out(poses, thin_svd(poses, kAllModes), size, vertices);
    ASSERT_EQ(errors.size(), 15u);
    for (Eigen::Index k = 0; k < 15; ++k) {
      MatrixXd rest_of_poses(poses.rows(), 14);
      rest_of_poses << poses.leftCols(k), poses.rightCols(14 - k);
      const Pca without = *pca(rest_of_poses, size);
      const PoseError direct = pose_error(without, KeyPointMap(without, vertices), poses.col(k));
      const PoseError& fast = errors[k];
      EXPECT_NEAR(fast.projection.mean, direct.projection.mean, 1e-5);
      EXPECT_NEAR(fast.projection.worst, direct.projection.worst, 1e-5);
      EXPECT_EQ(fast.projection.worst_vertex, direct.projection.worst_vertex);
      EXPECT_NEAR(fast.cueing.mean, direct.cueing.mean, 1e-5);
      EXPECT_NEAR(fast.total.worst, direct.total.worst, 1e-5);
    }
  }
}

TEST_F(MapTest, LeaveOneOutOfFewOrEqualPoses) {
  const std::vector<Index> vertices{1, 2};
  const MatrixXd pair = poses.leftCols(2), same = poses.col(0).replicate(1, 4);
  const auto two = leave_one_out(pair, thin_svd(pair, kAllModes), {}, vertices);
  ASSERT_EQ(two.size(), 2u);  // Each against the other alone.
  EXPECT_NEAR(two[0].projection.mean, vertex_distance(poses.col(0), poses.col(1)).mean, 1e-9);
  EXPECT_EQ(two[0].cueing.worst, 0);
  const auto equal = leave_one_out(same, thin_svd(same, kAllModes), {}, vertices);
  ASSERT_EQ(equal.size(), 4u);
  for (const PoseError& error : equal) EXPECT_EQ(error.total.worst, 0);
}

}  // namespace
}  // namespace foldproof
