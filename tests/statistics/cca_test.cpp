#include <gtest/gtest.h>

#include "statistics/samples.h"
#include "statistics/training.h"

namespace foldproof {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using testing::centered;
using testing::covariance;
using testing::noise;

Cca cca_of(const MatrixXd& x, const MatrixXd& y, Index dimensions, double ridge = 1e-3) {
  auto result = cca(x, y, dimensions, ridge);
  EXPECT_TRUE(result) << result.error().line();
  return result ? *result : Cca{};
}

// The covariance with the ridge, when the samples span `rank` directions.
MatrixXd ridged(const MatrixXd& samples, double ridge, Eigen::Index rank) {
  MatrixXd c = covariance(samples);
  c.diagonal().array() += ridge * c.trace() / static_cast<double>(rank);
  return c;
}

// Ridge regression by the normal equations, with matrices of the squared size.
VectorXd ridge_regression(const MatrixXd& x, const MatrixXd& y, double ridge, const VectorXd& at) {
  const Eigen::Index rank = std::min(x.rows(), x.cols() - 1);
  const MatrixXd cross = centered(y) * centered(x).transpose() / static_cast<double>(x.cols() - 1);
  return y.rowwise().mean() + cross * ridged(x, ridge, rank).ldlt().solve(at - x.rowwise().mean());
}

TEST(Cca, AgreesWithTheGeneralizedEigenproblem) {
  const MatrixXd x = noise(5, 30, 1);
  const MatrixXd y = noise(4, 5, 2) * x + 2 * noise(4, 30, 3);
  for (const double ridge : {1e-6, 1e-3, 0.1}) {
    MatrixXd joint = MatrixXd::Zero(9, 9), metric = MatrixXd::Zero(9, 9);
    joint.topRightCorner(5, 4) = centered(x) * centered(y).transpose() / 29;
    joint.bottomLeftCorner(4, 5) = joint.topRightCorner(5, 4).transpose();
    metric.topLeftCorner(5, 5) = ridged(x, ridge, 5);
    metric.bottomRightCorner(4, 4) = ridged(y, ridge, 4);
    const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> direct(joint, metric);

    const Cca result = cca_of(x, y, 9, ridge);
    ASSERT_EQ(result.dimensions(), 4u);
    for (Eigen::Index k = 0; k < 4; ++k) {
      EXPECT_NEAR(result.correlations[k], direct.eigenvalues()[8 - k], 1e-9) << ridge << ", pair " << k;
      // The eigenvector holds both directions, its x part with half of the metric's length.
      const VectorXd weight = direct.eigenvectors().col(8 - k).head(5) * std::sqrt(2.0);
      const double sign = weight.dot(result.weights.col(k)) < 0 ? -1 : 1;
      EXPECT_LE((sign * weight - result.weights.col(k)).norm(), 1e-8 * weight.norm())
          << ridge << ", pair " << k;
    }
  }
}

TEST(Cca, WithAllDimensionsIsRidgeRegression) {
  for (const auto& [x_size, y_size, count] :
       {std::tuple{5, 4, 40}, {150, 60, 12}, {4, 90, 12}, {90, 2, 25}}) {
    const MatrixXd x = noise(x_size, count, 4);
    const MatrixXd y = (noise(y_size, x_size, 5) * x).array() + 3;
    const VectorXd at = noise(x_size, 1, 6);
    for (const double ridge : {1e-4, 0.05}) {
      const VectorXd expected = ridge_regression(x, y, ridge, at);
      const VectorXd predicted = cca_of(x, y, 1000, ridge).predict(at);
      EXPECT_LE((predicted - expected).norm(), 1e-9 * expected.norm())
          << x_size << " " << y_size << " " << ridge;
    }
  }
}

TEST(Cca, FindsALinearRuleOfFewDimensions) {
  const MatrixXd hidden = noise(3, 40, 7);
  const MatrixXd to_x = noise(300, 3, 8), to_y = noise(50, 3, 9);
  const Cca result = cca_of(to_x * hidden, to_y * hidden, 3, 1e-9);
  ASSERT_EQ(result.dimensions(), 3u);
  EXPECT_GT(result.correlations[2], 0.999);
  const VectorXd unseen = noise(3, 1, 10);
  EXPECT_LE((result.predict(to_x * unseen) - to_y * unseen).norm(), 1e-5 * (to_y * unseen).norm());
}

TEST(Cca, FewerDimensionsKeepTheBestCorrelated) {
  const MatrixXd x = noise(6, 80, 11);
  const MatrixXd y = noise(6, 6, 12) * x + noise(6, 80, 13);
  const Cca all = cca_of(x, y, 6), two = cca_of(x, y, 2);
  ASSERT_EQ(two.dimensions(), 2u);
  EXPECT_EQ(two.weights, all.weights.leftCols(2));
  EXPECT_EQ(two.loadings, all.loadings.leftCols(2));
  for (Eigen::Index k = 0; k + 1 < 6; ++k) EXPECT_GE(all.correlations[k], all.correlations[k + 1]);
  EXPECT_LE(all.correlations[0], 1);
  EXPECT_GE(all.correlations[5], 0);
}

TEST(Cca, WithoutSpreadPredictsTheMean) {
  const MatrixXd x = noise(7, 9, 14), y = noise(5, 9, 15);
  const MatrixXd same_x = x.col(0).replicate(1, 9), same_y = y.col(0).replicate(1, 9);
  EXPECT_EQ(cca_of(x, same_y, 3).predict(x.col(3)), VectorXd(y.col(0)));
  EXPECT_LE((cca_of(same_x, y, 3).predict(x.col(3)) - y.rowwise().mean()).norm(), 1e-12);
  EXPECT_EQ(cca_of(x.leftCols(1), y.leftCols(1), 3).predict(x.col(3)), VectorXd(y.col(0)));
}

TEST(Cca, GivesTheSameTwice) {
  const MatrixXd x = noise(40, 20, 16), y = noise(30, 20, 17);
  EXPECT_EQ(cca_of(x, y, 5).weights, cca_of(x, y, 5).weights);
  EXPECT_EQ(cca_of(x, y, 5).loadings, cca_of(x, y, 5).loadings);
}

TEST(Cca, RefusesWhatDoesNotFit) {
  MatrixXd x = noise(4, 6, 18), y = noise(3, 6, 19);
  EXPECT_FALSE(cca(x, y.leftCols(5), 2));
  EXPECT_FALSE(cca(x, y, 0));
  EXPECT_FALSE(cca(x, y, 2, 0));
  EXPECT_FALSE(cca(x, y, 2, testing::kNaN));
  EXPECT_FALSE(cca(MatrixXd(4, 0), MatrixXd(3, 0), 2));
  y(2, 5) = testing::kNaN;
  EXPECT_FALSE(cca(x, y, 2));
  x(0, 0) = testing::kNaN;
  EXPECT_EQ(cca(x, y, 2).error().line(),
            "sample 0: number 0 is not finite; leave this sample out or repair it");
}

}  // namespace
}  // namespace foldproof
