#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "keypoints/choose.h"
#include "keypoints/surfaces.h"

namespace foldproof {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using testing::bent;
using testing::cylinder;
using ::testing::HasSubstr;

KeyPoints key_points_of(const std::vector<double>& rest, const MatrixXd& poses, const Pca& subspace,
                        const KeyPointSettings& settings) {
  auto result = choose_key_points(rest, poses, subspace, settings);
  EXPECT_TRUE(result) << result.error().line();
  return result ? *result : KeyPoints{};
}

double root_mean_square(const MatrixXd& poses, const Pca& subspace, std::span<const Index> vertices) {
  const KeyPointMap map(subspace, vertices);
  double sum = 0;
  for (Eigen::Index k = 0; k < poses.cols(); ++k) {
    sum += (poses.col(k) - subspace.reconstruct(map.coordinates(map.gather(poses.col(k))))).squaredNorm();
  }
  return std::sqrt(sum / (static_cast<double>(poses.size()) / 3));
}

struct ChooseTest : ::testing::Test {
  std::vector<double> rest = cylinder(20, 30);  // 600 vertices
  MatrixXd poses = bent(rest, 14, 1);
  Pca subspace = *pca(poses, {5, 1.0});
};

TEST_F(ChooseTest, RecordsItsRounds) {
  const KeyPoints chosen = key_points_of(rest, poses, subspace, {0.01, 0.2, 0, 4, 0});
  const std::set<Index> different(chosen.vertices.begin(), chosen.vertices.end());
  EXPECT_EQ(different.size(), chosen.vertices.size());
  EXPECT_LT(*different.rbegin(), 600u);
  ASSERT_EQ(chosen.round_ends.size(), 5u);
  ASSERT_EQ(chosen.errors.size(), 5u);
  EXPECT_EQ(chosen.round_ends.back(), chosen.vertices.size());
  const std::vector<Index> first(chosen.vertices.begin(), chosen.vertices.begin() + chosen.round_ends[0]);
  EXPECT_EQ(first, poisson_disk_sample(rest, 6));
  for (std::size_t round = 0; round < 5; ++round) {
    const std::span<const Index> so_far(chosen.vertices.data(), chosen.round_ends[round]);
    EXPECT_NEAR(chosen.errors[round], root_mean_square(poses, subspace, so_far), 1e-9) << round;
    if (round > 0) {
      EXPECT_GT(chosen.round_ends[round], chosen.round_ends[round - 1]);
    }
  }
}

TEST_F(ChooseTest, RoundsReduceTheError) {
  const KeyPoints chosen = key_points_of(rest, poses, subspace, {0.004, 0.2, 0, 6});
  EXPECT_LT(chosen.errors.back(), 0.7 * chosen.errors.front());
  // The remaining error is mostly outside the subspace; key points cannot reduce it.
  std::vector<Index> all(600);
  for (Index v = 0; v < 600; ++v) all[v] = v;
  EXPECT_LT(chosen.errors.back(), 1.2 * root_mean_square(poses, subspace, all));
}

TEST_F(ChooseTest, StopsAtTheBudgetTheToleranceAndTheRounds) {
  EXPECT_EQ(key_points_of(rest, poses, subspace, {0.02, 0.04, 0, 32, 0}).vertices.size(), 24u);
  EXPECT_EQ(key_points_of(rest, poses, subspace, {0.02, 0.04, 0, 0}).round_ends.size(), 1u);
  EXPECT_EQ(key_points_of(rest, poses, subspace, {0.02, 0.02, 0, 32}).vertices.size(), 12u);
  const KeyPoints free = key_points_of(rest, poses, subspace, {0.004, 0.5, 0, 32, 0});
  const double size = 4;  // The cylinder's length.
  const double between = (free.errors[1] + free.errors[2]) / 2;
  const KeyPoints stopped = key_points_of(rest, poses, subspace, {0.004, 0.5, between / size, 32, 0});
  ASSERT_EQ(stopped.errors.size(), 3u);
  EXPECT_GT(stopped.errors[1], between);
  EXPECT_LE(stopped.errors[2], between);
  EXPECT_TRUE(std::equal(stopped.vertices.begin(), stopped.vertices.end(), free.vertices.begin()));
}

TEST_F(ChooseTest, DiscardsRoundsThatGainNothing) {
  const KeyPoints all = key_points_of(rest, poses, subspace, {0.004, 0.9, 0, 20, 0});
  const KeyPoints kept = key_points_of(rest, poses, subspace, {0.004, 0.9, 0, 20, 3});
  ASSERT_LT(kept.errors.size() + 3, all.errors.size());
  EXPECT_EQ(kept.errors.back(), *std::min_element(kept.errors.begin(), kept.errors.end()));
  EXPECT_EQ(kept.vertices.size(), kept.round_ends.back());
  EXPECT_TRUE(std::equal(kept.errors.begin(), kept.errors.end(), all.errors.begin()));
  EXPECT_TRUE(std::equal(kept.vertices.begin(), kept.vertices.end(), all.vertices.begin()));
  // The three after it were no better than by a thousandth.
  const auto after = all.errors.begin() + static_cast<std::ptrdiff_t>(kept.errors.size());
  EXPECT_GT(*std::min_element(after, after + 3), 0.999 * kept.errors.back());
}

TEST_F(ChooseTest, EndsWhenTheResidualIsRounding) {
  const Pca whole = *pca(poses, {0, 1.0});
  const KeyPoints chosen = key_points_of(rest, poses, whole, {0.02, 0.9, 0, 32});
  EXPECT_LT(chosen.vertices.size(), 100u);
  EXPECT_LT(chosen.errors.back(), 1e-6);
}

TEST_F(ChooseTest, TakesTheLargestAndTheMostOpposed) {
  // One mode, set by hand: vertex 100 moves most, 200 most against it, 300 farther than 200 but sideways.
  Pca one = *pca(poses, {1, 1.0});
  one.basis.setZero();
  one.basis.col(0).segment<3>(300) << 0.8, 0, 0;
  one.basis.col(0).segment<3>(600) << -0.3, 0.1, 0;
  one.basis.col(0).segment<3>(900) << -0.1, 0.5, 0;
  one.basis.col(0).segment<3>(1200) << 0.7, 0, 0;
  const KeyPoints chosen = key_points_of(rest, poses, one, {0.004, 0.5, 0, 1, 0});
  const std::vector<Index> added(chosen.vertices.begin() + chosen.round_ends[0], chosen.vertices.end());
  EXPECT_EQ(added, (std::vector<Index>{100, 200}));
  one.basis.col(0).segment<3>(600).setZero();
  one.basis.col(0).segment<3>(900).setZero();  // Nothing moves against it now.
  const KeyPoints single = key_points_of(rest, poses, one, {0.004, 0.5, 0, 1, 0});
  EXPECT_EQ(single.vertices.size(), single.round_ends[0] + 1u);
}

TEST_F(ChooseTest, LaterRoundsUseTheResidual) {
  // Vertex 321 leaves the mesh in a single pose, far outside the five modes.
  MatrixXd torn = poses;
  torn.col(6).segment<3>(3 * 321) += Eigen::Vector3d(0, 0, 30);
  const KeyPoints chosen = key_points_of(rest, torn, subspace, {0.004, 0.5, 0, 2, 0});
  EXPECT_EQ(chosen.vertices[chosen.round_ends[1]], 321u);
}

TEST_F(ChooseTest, WorksWithoutModesOrMotion) {
  const MatrixXd still = poses.col(0).replicate(1, 3);
  const KeyPoints chosen = key_points_of(rest, still, *pca(still), {});
  EXPECT_EQ(chosen.vertices, poisson_disk_sample(rest, 12));
  EXPECT_EQ(chosen.errors, std::vector<double>{0});
  // A subspace without modes: rounds use the residuals, of at most 128 poses.
  const Pca nothing = *pca(poses.leftCols(1));
  EXPECT_EQ(key_points_of(rest, bent(rest, 150, 3), nothing, {0.02, 0.04, 0, 32, 0}).vertices.size(), 24u);
}

TEST_F(ChooseTest, GivesTheSameTwice) {
  const KeyPointSettings settings{0.01, 0.1, 0, 5};
  EXPECT_EQ(key_points_of(rest, poses, subspace, settings).vertices,
            key_points_of(rest, poses, subspace, settings).vertices);
}

TEST_F(ChooseTest, RefusesWhatDoesNotFit) {
  EXPECT_THAT(choose_key_points(rest, poses, subspace, {0.05, 0.04}).error().line(), HasSubstr("shares"));
  EXPECT_FALSE(choose_key_points(rest, poses, subspace, {0, 0.04}));
  EXPECT_FALSE(choose_key_points(rest, poses, subspace, {0.01, 1.5}));
  EXPECT_FALSE(choose_key_points(rest, poses, subspace, {0.01, 0.04, NAN}));
  EXPECT_FALSE(choose_key_points(std::span(rest).first(300), poses, subspace));
  EXPECT_FALSE(choose_key_points(rest, poses.topRows(300), subspace));
  EXPECT_FALSE(choose_key_points(rest, MatrixXd(1800, 0), subspace));
  MatrixXd bad = poses;
  bad(3, 3) = NAN;
  EXPECT_THAT(choose_key_points(rest, bad, subspace).error().line(), HasSubstr("sample 3"));
  rest[5] = INFINITY;
  EXPECT_FALSE(choose_key_points(rest, poses, subspace));
}

}  // namespace
}  // namespace foldproof
