#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "foldproof/statistics.h"
#include "statistics/samples.h"

namespace foldproof {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using testing::centered;
using testing::covariance;
using testing::graded;
using ::testing::HasSubstr;
using testing::noise;

Pca pca_of(const MatrixXd& samples, const SubspaceSize& size) {
  auto result = pca(samples, size);
  EXPECT_TRUE(result) << result.error().line();
  return result ? *result : Pca{};
}

// Against the eigenvectors of the covariance matrix, which the library never forms when it is large.
void expect_modes_of_covariance(const MatrixXd& samples, const Pca& subspace) {
  const MatrixXd c = covariance(samples);
  const Eigen::SelfAdjointEigenSolver<MatrixXd> dense(c);
  ASSERT_GT(subspace.modes(), 0u);
  double share = 0;
  for (Eigen::Index k = 0; k < subspace.basis.cols(); ++k) {
    const Eigen::Index there = c.rows() - 1 - k;
    const double variance = dense.eigenvalues()[there];
    EXPECT_NEAR(subspace.deviations[k], std::sqrt(variance), 1e-7 * std::sqrt(variance)) << "mode " << k;
    EXPECT_NEAR(std::abs(subspace.basis.col(k).dot(dense.eigenvectors().col(there))), 1, 1e-6)
        << "mode " << k;
    share += variance / c.trace();
    EXPECT_NEAR(subspace.energy[k], share, 1e-9) << "mode " << k;
  }
  const double scale = samples.cwiseAbs().maxCoeff();
  EXPECT_LE((subspace.mean - samples.rowwise().mean()).cwiseAbs().maxCoeff(), 1e-14 * scale);
  const MatrixXd gram = subspace.basis.transpose() * subspace.basis;
  EXPECT_LE((gram - MatrixXd::Identity(gram.rows(), gram.cols())).cwiseAbs().maxCoeff(), 5e-7);
}

TEST(Pca, AgreesWithTheCovarianceForFewSamples) {
  const MatrixXd samples = graded(90, 12, 11, 0.7, 1);
  const Pca subspace = pca_of(samples, {0, 1.0});
  EXPECT_EQ(subspace.modes(), 11u);
  expect_modes_of_covariance(samples, subspace);
}

TEST(Pca, AgreesWithTheCovarianceForFewNumbers) {
  const MatrixXd samples = graded(7, 500, 7, 0.6, 2);
  const Pca subspace = pca_of(samples, {0, 1.0});
  EXPECT_EQ(subspace.modes(), 7u);
  expect_modes_of_covariance(samples, subspace);
}

TEST(Pca, AgreesWithTheCovarianceForManySamples) {
  const MatrixXd samples = graded(300, 400, 60, 0.85, 3);
  const Pca by_energy = pca_of(samples, {0, 0.9999});  // More than the first guess of modes.
  EXPECT_GT(by_energy.modes(), 16u);
  EXPECT_LT(by_energy.modes(), 60u);
  expect_modes_of_covariance(samples, by_energy);
  const Pca by_count = pca_of(samples, {9, 0.5});
  EXPECT_EQ(by_count.modes(), 9u);
  expect_modes_of_covariance(samples, by_count);
}

TEST(Pca, AgreesWithTheCovarianceWhenManySamplesNeedMostModes) {
  const MatrixXd wide = noise(270, 300, 4), tall = noise(300, 270, 5);
  EXPECT_EQ(pca_of(wide, {0, 1.0}).modes(), 270u);
  EXPECT_EQ(pca_of(tall, {0, 1.0}).modes(), 269u);
  expect_modes_of_covariance(wide, pca_of(wide, {0, 0.9}));
  expect_modes_of_covariance(tall, pca_of(tall, {200, 0.9}));
}

TEST(Pca, FindsModesThatAreTinyBesideTheFirst) {
  const MatrixXd samples = graded(200, 8, 7, 0.15, 6);
  const Pca subspace = pca_of(samples, {0, 1.0});
  ASSERT_EQ(subspace.modes(), 7u);
  const Eigen::JacobiSVD<MatrixXd> svd(centered(samples), Eigen::ComputeThinU);
  EXPECT_LT(svd.singularValues()[6], 1e-5 * svd.singularValues()[0]);
  for (int k = 0; k < 7; ++k) {
    EXPECT_NEAR(subspace.deviations[k] / (svd.singularValues()[k] / std::sqrt(7.0)), 1, 1e-6) << "mode " << k;
    EXPECT_NEAR(std::abs(subspace.basis.col(k).dot(svd.matrixU().col(k))), 1, 1e-6) << "mode " << k;
  }
}

TEST(Pca, KeepsAsManyModesAsTheEnergyNeedsAndNoMore) {
  const MatrixXd samples = graded(50, 20, 19, 0.8, 7);
  for (const double energy : {0.1, 0.5, 0.9, 0.999}) {
    const Pca subspace = pca_of(samples, {0, energy});
    const Index last = subspace.modes() - 1;
    EXPECT_GE(subspace.energy[last], energy);
    if (last > 0) {
      EXPECT_LT(subspace.energy[last - 1], energy);
    }
  }
  EXPECT_EQ(pca_of(samples, {5, 0.1}).modes(), 5u);
  EXPECT_EQ(pca_of(samples, {500, 0.1}).modes(), 19u);
}

TEST(Pca, HasNoModeWithoutVariance) {
  EXPECT_EQ(pca_of(graded(60, 20, 5, 0.9, 8), {0, 1.0}).modes(), 5u);
  EXPECT_EQ(pca_of(graded(60, 20, 5, 0.9, 8), {15, 1.0}).modes(), 5u);
  EXPECT_EQ(pca_of(graded(9, 900, 5, 0.9, 9), {0, 1.0}).modes(), 5u);
  EXPECT_EQ(pca_of(graded(300, 400, 5, 0.9, 10), {20, 1.0}).modes(), 5u);  // Iterative.
  EXPECT_EQ(pca_of(graded(300, 400, 5, 0.9, 11), {0, 1.0}).modes(), 5u);
}

TEST(Pca, OneSampleOrEqualSamplesGiveTheMeanAlone) {
  for (const Eigen::Index count : {1, 2, 3, 7, 300}) {
    const VectorXd x = noise(400, 1, 12) / 3;
    const Pca subspace = pca_of(x.replicate(1, count), {0, 1.0});
    EXPECT_EQ(subspace.modes(), 0u);
    EXPECT_EQ(subspace.mean, x);
    EXPECT_EQ(subspace.project(x).size(), 0);
    EXPECT_EQ(subspace.reconstruct(VectorXd(0)), x);
    EXPECT_EQ(subspace.mahalanobis(VectorXd(0)), 0);
  }
}

TEST(Pca, DoesNotTakeRoundingForVariance) {
  MatrixXd samples = (1000 * noise(300, 1, 13)).replicate(1, 9);
  std::mt19937 random(14);
  for (double& number : samples.reshaped()) number *= 1 + (static_cast<int>(random() % 3) - 1) * 0x1p-52;
  EXPECT_EQ(pca_of(samples, {0, 1.0}).modes(), 0u);
}

TEST(Pca, ProjectsByLeastSquares) {
  const MatrixXd samples = graded(60, 15, 14, 0.8, 15);
  const Pca subspace = pca_of(samples, {6, 1.0});
  const VectorXd x = samples.col(3) + noise(60, 1, 16);
  const VectorXd p = subspace.project(x);
  const VectorXd reference = subspace.basis.colPivHouseholderQr().solve(x - subspace.mean);
  EXPECT_LE((p - reference).norm(), 1e-12 * reference.norm());
  EXPECT_LE((subspace.project(subspace.reconstruct(p)) - p).norm(), 1e-12 * p.norm());
}

TEST(Pca, ReconstructsItsSamplesFromAllModes) {
  const MatrixXd samples = graded(60, 15, 14, 0.8, 17);
  const Pca subspace = pca_of(samples, {0, 1.0});
  for (Eigen::Index k = 0; k < samples.cols(); ++k) {
    const VectorXd again = subspace.reconstruct(subspace.project(samples.col(k)));
    EXPECT_LE((again - samples.col(k)).norm(), 1e-6 * samples.col(k).norm());
  }
}

TEST(Pca, MeasuresInStandardDeviations) {
  const MatrixXd samples = graded(40, 10, 9, 0.8, 18);
  const Pca subspace = pca_of(samples, {0, 1.0});
  EXPECT_DOUBLE_EQ(subspace.mahalanobis(subspace.deviations), 3);
  double sum = 0;  // The squared norms of n samples add up to (n - 1) per mode.
  for (Eigen::Index k = 0; k < 10; ++k) {
    sum += std::pow(subspace.mahalanobis(subspace.project(samples.col(k))), 2);
  }
  EXPECT_NEAR(sum, 9 * 9, 1e-4);
}

TEST(Pca, IsTheSameFarFromTheOrigin) {
  const MatrixXd samples = graded(60, 12, 4, 0.8, 19);
  const Pca near = pca_of(samples, {0, 0.99}), far = pca_of(samples.array() + 1e6, {0, 0.99});
  ASSERT_EQ(near.modes(), far.modes());
  EXPECT_LE((near.basis - far.basis).cwiseAbs().maxCoeff(), 1e-6);
}

TEST(Pca, HasFloatsInItsBasisAndAFixedSign) {
  for (const auto& [size, count] : {std::pair{80, 20}, {20, 400}, {300, 400}}) {
    const Pca subspace = pca_of(graded(size, count, 12, 0.8, 20), {10, 1.0});
    for (Eigen::Index k = 0; k < 10; ++k) {
      EXPECT_EQ(subspace.basis.col(k), subspace.basis.col(k).cast<float>().cast<double>());
      EXPECT_EQ(subspace.basis.col(k).maxCoeff(), subspace.basis.col(k).cwiseAbs().maxCoeff());
    }
  }
}

TEST(Pca, GivesTheSameTwice) {
  for (const Eigen::Index count : {30, 400}) {
    const MatrixXd samples = graded(300, count, 29, 0.9, 21);
    const Pca first = pca_of(samples, {0, 0.99}), second = pca_of(samples, {0, 0.99});
    EXPECT_EQ(first.basis, second.basis);
    EXPECT_EQ(first.deviations, second.deviations);
  }
}

TEST(Pca, RefusesWhatHasNoModes) {
  MatrixXd samples = noise(6, 4, 22);
  EXPECT_THAT(pca(samples, {0, 0.0}).error().line(), HasSubstr("energy"));
  EXPECT_FALSE(pca(samples, {0, 1.5}));
  EXPECT_FALSE(pca(samples, {0, testing::kNaN}));
  EXPECT_TRUE(pca(samples, {1, 0.0}));
  EXPECT_FALSE(pca(MatrixXd(6, 0)));
  EXPECT_FALSE(pca(MatrixXd(0, 4)));
  samples(5, 2) = testing::kNaN;
  EXPECT_EQ(pca(samples).error().line(),
            "sample 2: number 5 is not finite; leave this sample out or repair it");
  samples(5, 2) = INFINITY;
  EXPECT_FALSE(pca(samples));
}

}  // namespace
}  // namespace foldproof
