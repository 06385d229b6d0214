#include <gtest/gtest.h>

#include "statistics/samples.h"
#include "statistics/training.h"

namespace foldproof {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using testing::covariance;
using testing::noise;
using Classes = std::vector<std::uint8_t>;

Lda lda_of(const MatrixXd& points, const Classes& classes, double ridge = 1e-3) {
  auto result = lda(points, classes, ridge);
  EXPECT_TRUE(result) << result.error().line();
  return result ? *result : Lda{};
}

struct Labeled {
  MatrixXd points;
  Classes classes;
};

// Two stretched clouds at a distance; every third point is of class 1.
Labeled clouds(Eigen::Index size, Eigen::Index count, double distance, unsigned seed) {
  Labeled set{noise(size, size, seed) * noise(size, count, seed + 1), Classes(count, 0)};
  const VectorXd offset = distance * noise(size, 1, seed + 2);
  for (Eigen::Index k = 0; k < count; k += 3) {
    set.points.col(k) += offset;
    set.classes[k] = 1;
  }
  return set;
}

struct Scatter {
  MatrixXd within;
  VectorXd mean_difference;
};

Scatter scatter(const Labeled& set) {
  MatrixXd group[2] = {MatrixXd(set.points.rows(), 0), MatrixXd(set.points.rows(), 0)};
  for (std::size_t k = 0; k < set.classes.size(); ++k) {
    MatrixXd& own = group[set.classes[k]];
    own.conservativeResize(Eigen::NoChange, own.cols() + 1);
    own.rightCols(1) = set.points.col(static_cast<Eigen::Index>(k));
  }
  const double n = static_cast<double>(set.classes.size());
  const MatrixXd within = (covariance(group[0]) * static_cast<double>(group[0].cols() - 1) +
                           covariance(group[1]) * static_cast<double>(group[1].cols() - 1)) /
                          (n - 2);
  return {within, group[1].rowwise().mean() - group[0].rowwise().mean()};
}

double balanced_error(const Lda& result, const Labeled& set, double threshold) {
  double wrong[2] = {0, 0}, sizes[2] = {0, 0};
  for (std::size_t k = 0; k < set.classes.size(); ++k) {
    const bool above = result.direction.dot(set.points.col(static_cast<Eigen::Index>(k))) > threshold;
    wrong[set.classes[k]] += above != (set.classes[k] == 1);
    sizes[set.classes[k]] += 1;
  }
  return (wrong[0] / sizes[0] + wrong[1] / sizes[1]) / 2;
}

TEST(Lda, AgreesWithTheGeneralizedEigenproblem) {
  const Labeled set = clouds(5, 60, 2, 1);
  const Scatter s = scatter(set);
  const double ridge = 0.01;
  MatrixXd metric = s.within;
  metric.diagonal().array() += ridge * s.within.trace() / 5;
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> direct(
      s.mean_difference * s.mean_difference.transpose(), metric);
  VectorXd expected = direct.eigenvectors().col(4).normalized();
  if (expected.dot(s.mean_difference) < 0) expected = -expected;
  EXPECT_LE((lda_of(set.points, set.classes, ridge).direction - expected).norm(), 1e-9);
}

TEST(Lda, WorksWhenNumbersOutnumberPoints) {
  const Labeled set = clouds(120, 16, 1, 2);
  const Scatter s = scatter(set);
  MatrixXd metric = s.within;
  metric.diagonal().array() += 1e-3 * s.within.trace() / 15;  // 16 points span 15 directions.
  const VectorXd expected = metric.ldlt().solve(s.mean_difference).normalized();
  EXPECT_LE((lda_of(set.points, set.classes).direction - expected).norm(), 1e-7);
}

TEST(Lda, NoOtherThresholdSeparatesBetter) {
  for (const double distance : {0.1, 0.5, 2.0}) {
    for (unsigned seed = 3; seed < 13; ++seed) {
      const Labeled set = clouds(3, 45, distance, seed);
      const Lda result = lda_of(set.points, set.classes);
      EXPECT_NEAR(balanced_error(result, set, result.threshold), result.error, 1e-12);
      EXPECT_LE(result.error, 0.5);
      const VectorXd scores = set.points.transpose() * result.direction;
      for (const double cut : scores) {
        EXPECT_GE(balanced_error(result, set, cut) + 1e-12, result.error);
        EXPECT_GE(balanced_error(result, set, std::nextafter(cut, -INFINITY)) + 1e-12, result.error);
      }
    }
  }
}

TEST(Lda, CutsInTheMiddleOfTheWidestGap) {
  MatrixXd points(1, 6);
  points << 0, 1, 2, 8, 9, 10;
  const Lda result = lda_of(points, {0, 0, 0, 1, 1, 1});
  EXPECT_DOUBLE_EQ(result.threshold, 5);
  EXPECT_EQ(result.error, 0);
  EXPECT_GT(result.score(VectorXd::Constant(1, 5.5)), 0);
  EXPECT_LT(result.score(VectorXd::Constant(1, 4.5)), 0);
  // Class 1 below: the direction is reversed, and a score above 0 still means class 1.
  const Lda turned = lda_of(points, {1, 1, 1, 0, 0, 0});
  EXPECT_GT(turned.score(VectorXd::Constant(1, 0)), 0);
  EXPECT_DOUBLE_EQ(turned.threshold, -5);
}

TEST(Lda, MinimizesTheBalancedError) {
  // One point of class 1 among many: "always class 0" would be nearly always right, and useless.
  MatrixXd points(1, 9);
  points << 0, 1, 2, 3, 4, 5, 6, 6.5, 6;
  const Lda result = lda_of(points, {0, 0, 0, 0, 0, 0, 0, 0, 1});
  EXPECT_NEAR(result.threshold, 5.5, 1e-12);
  EXPECT_NEAR(result.error, (2.0 / 8) / 2, 1e-12);
}

TEST(Lda, SeparatesTwoPointsAndClassesWithoutSpread) {
  MatrixXd points(3, 4);
  points << 0, 0, 3, 3, 1, 1, 1, 1, 0, 0, 4, 4;
  const Lda result = lda_of(points, {0, 0, 1, 1});
  EXPECT_LE((result.direction - Eigen::Vector3d(0.6, 0, 0.8)).norm(), 1e-12);
  EXPECT_NEAR(result.threshold, 2.5, 1e-12);
  EXPECT_EQ(lda_of(points.middleCols(1, 2), {0, 1}).error, 0);
}

TEST(Lda, GivesTheSameTwice) {
  const Labeled set = clouds(40, 20, 1, 20);
  EXPECT_EQ(lda_of(set.points, set.classes).direction, lda_of(set.points, set.classes).direction);
}

TEST(Lda, RefusesClassesThatCannotBeSeparated) {
  MatrixXd points = noise(3, 4, 21);
  EXPECT_FALSE(lda(points, Classes{1, 1, 1, 1}));
  EXPECT_EQ(lda(points, Classes{0, 0, 0, 0}).error().line(),
            "classes: class 1 has no points; give points of both");
  EXPECT_FALSE(lda(points, Classes{0, 1}));
  EXPECT_FALSE(lda(points, Classes{0, 1, 0, 1}, 0));
  EXPECT_FALSE(lda(MatrixXd::Ones(3, 4), Classes{0, 1, 0, 1}));
  MatrixXd same_mean(1, 4);
  same_mean << -1, 1, -2, 2;
  EXPECT_FALSE(lda(same_mean, Classes{0, 0, 1, 1}));
  points(1, 1) = testing::kNaN;
  EXPECT_FALSE(lda(points, Classes{0, 1, 0, 1}));
}

}  // namespace
}  // namespace foldproof
