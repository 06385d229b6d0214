#include <gtest/gtest.h>

#include "statistics/samples.h"
#include "statistics/training.h"

namespace foldproof {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using testing::graded;
using testing::noise;

KernelPca kernel_pca_of(const MatrixXd& samples, const SubspaceSize& size, double width = 0) {
  auto result = kernel_pca(samples, size, width);
  EXPECT_TRUE(result) << result.error().line();
  return result ? *result : KernelPca{};
}

double kernel(const VectorXd& a, const VectorXd& b, double width) {
  return std::exp(-(a - b).squaredNorm() / (2 * width * width));
}

MatrixXd kernel_matrix(const MatrixXd& samples, double width) {
  return MatrixXd::NullaryExpr(samples.cols(), samples.cols(), [&](Eigen::Index a, Eigen::Index b) {
    return kernel(samples.col(a), samples.col(b), width);
  });
}

// Computed from the samples themselves, with the centering matrix H = I - 1/n.
struct Direct {
  VectorXd variances;
  MatrixXd vectors;
  MatrixXd centering;
};

Direct direct(const MatrixXd& samples, double width) {
  const Eigen::Index n = samples.cols();
  const MatrixXd h = MatrixXd::Identity(n, n).array() - 1.0 / static_cast<double>(n);
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(h * kernel_matrix(samples, width) * h);
  return {solver.eigenvalues().reverse(), solver.eigenvectors().rowwise().reverse(), h};
}

void expect_direct(const MatrixXd& samples, const KernelPca& subspace, const VectorXd& x) {
  const Direct reference = direct(samples, subspace.width);
  const double n = static_cast<double>(samples.cols());
  VectorXd to_samples(samples.cols());
  for (Eigen::Index k = 0; k < samples.cols(); ++k) to_samples[k] = kernel(samples.col(k), x, subspace.width);
  const MatrixXd all = kernel_matrix(samples, subspace.width);
  const VectorXd centered = reference.centering * (to_samples - all.rowwise().mean());
  const VectorXd p = subspace.project(x);
  double share = 0;
  ASSERT_GT(p.size(), 0);
  for (Eigen::Index k = 0; k < p.size(); ++k) {
    const double expected = reference.vectors.col(k).dot(centered) / std::sqrt(reference.variances[k]);
    // The rounded basis changes kernel values by about 1e-7, and modes by that over the eigenvalue gap.
    EXPECT_NEAR(std::abs(p[k]), std::abs(expected), 3e-5) << "mode " << k;
    EXPECT_NEAR(subspace.deviations[k], std::sqrt(reference.variances[k] / (n - 1)), 1e-6) << "mode " << k;
    share += reference.variances[k] / reference.variances.sum();
    EXPECT_NEAR(subspace.energy[k], share, 1e-6) << "mode " << k;
  }
}

TEST(KernelPca, AgreesWithADirectComputation) {
  const MatrixXd samples = graded(40, 12, 9, 0.7, 1);
  const KernelPca subspace = kernel_pca_of(samples, {0, 0.95});
  expect_direct(samples, subspace, samples.col(4));
  const VectorXd beside = samples.col(4) + 0.5 * noise(40, 1, 2);  // Not in the samples' linear subspace.
  expect_direct(samples, subspace, beside);
}

TEST(KernelPca, AgreesWithADirectComputationForManySamples) {
  const MatrixXd samples = graded(4, 300, 4, 0.7, 3);
  expect_direct(samples, kernel_pca_of(samples, {12, 1.0}), samples.col(7) + 0.3 * noise(4, 1, 4));
}

TEST(KernelPca, TakesFourMedianDistancesForItsWidth) {
  MatrixXd samples(2, 3);
  samples << 0, 3, 10, 0, 4, 0;  // Distances 5, 10 and sqrt(65).
  EXPECT_NEAR(kernel_pca_of(samples, {0, 1.0}).width, 4 * std::sqrt(65.0), 1e-5);
  EXPECT_EQ(kernel_pca_of(samples, {0, 1.0}, 2.5).width, 2.5);
}

TEST(KernelPca, ReconstructsASample) {
  const MatrixXd samples = graded(40, 12, 11, 0.8, 5);
  const KernelPca subspace = kernel_pca_of(samples, {0, 1.0});
  for (Eigen::Index k = 0; k < samples.cols(); ++k) {
    const VectorXd again = subspace.reconstruct(subspace.project(samples.col(k)));
    EXPECT_LE((again - samples.col(k)).norm(), 1e-6 * subspace.width) << "sample " << k;
  }
}

TEST(KernelPca, FindsPreImagesNearACurvedSetOfSamples) {
  // Samples on a half circle: one mode of PCA cannot follow it, two modes of kernel PCA can.
  MatrixXd samples(2, 60);
  for (int k = 0; k < 60; ++k) samples.col(k) << std::cos(M_PI * k / 59), std::sin(M_PI * k / 59);
  const KernelPca subspace = kernel_pca_of(samples, {4, 1.0}, 0.5);
  double worst = 0;
  for (int k = 0; k < 40; ++k) {
    const double angle = M_PI * (0.1 + 0.8 * k / 39);
    const Eigen::Vector2d on(std::cos(angle), std::sin(angle));
    const VectorXd again = subspace.reconstruct(subspace.project(1.15 * on));
    worst = std::max(worst, (again - on).norm());
  }
  EXPECT_LT(worst, 0.1);
}

TEST(KernelPca, ItsPreImageIsNeverWorseThanTheBestSample) {
  const MatrixXd samples = graded(6, 25, 6, 0.8, 6);
  const KernelPca subspace = kernel_pca_of(samples, {5, 1.0});
  for (unsigned seed = 0; seed < 50; ++seed) {
    // Far out, too, where weights turn negative.
    const VectorXd p = (1 + seed) * subspace.deviations.cwiseProduct(noise(5, 1, 7 + seed));
    // |image(x) - P|^2 = const - 2 sum gamma_i k(x, x_i).
    VectorXd gamma = subspace.weights * p;
    gamma.array() += (1 - gamma.sum()) / 25;
    const auto similarity = [&](const VectorXd& x) {
      double sum = 0;
      for (Eigen::Index k = 0; k < 25; ++k) sum += gamma[k] * kernel(x, samples.col(k), subspace.width);
      return sum;
    };
    const VectorXd x = subspace.reconstruct(p);
    ASSERT_TRUE(x.allFinite());
    double best = -INFINITY;
    for (Eigen::Index k = 0; k < 25; ++k) best = std::max(best, similarity(samples.col(k)));
    EXPECT_GE(similarity(x), best - 1e-6 * std::abs(best)) << seed;
  }
}

TEST(KernelPca, ProjectsAndReconstructsCoordinates) {
  const MatrixXd samples = graded(40, 12, 11, 0.8, 8);
  const KernelPca subspace = kernel_pca_of(samples, {0, 0.9});
  const VectorXd x = (samples.col(1) + samples.col(2)) / 2, y = subspace.pca.project(x);
  EXPECT_LE((subspace.project(x) - subspace.project_coordinates(y)).norm(), 1e-6);
  const VectorXd p = subspace.project(x);
  EXPECT_EQ(subspace.reconstruct(p), subspace.pca.reconstruct(subspace.reconstruct_coordinates(p)));
  EXPECT_NEAR(subspace.mahalanobis(subspace.deviations), std::sqrt(subspace.modes()), 1e-12);
}

TEST(KernelPca, OneSampleOrEqualSamplesGiveTheMeanAlone) {
  for (const Eigen::Index count : {1, 5}) {
    const VectorXd x = noise(30, 1, 9);
    const KernelPca subspace = kernel_pca_of(x.replicate(1, count), {0, 1.0});
    EXPECT_EQ(subspace.modes(), 0u);
    EXPECT_EQ(subspace.project(x).size(), 0);
    EXPECT_EQ(subspace.reconstruct(VectorXd(0)), x);
  }
}

TEST(KernelPca, GivesTheSameTwice) {
  for (const Eigen::Index count : {20, 300}) {
    const MatrixXd samples = graded(8, count, 8, 0.8, 10);
    const KernelPca first = kernel_pca_of(samples, {6, 1.0}), second = kernel_pca_of(samples, {6, 1.0});
    EXPECT_EQ(first.weights, second.weights);
    EXPECT_EQ(first.reconstruct(first.deviations), second.reconstruct(first.deviations));
  }
}

TEST(KernelPca, RefusesWhatHasNoModes) {
  MatrixXd samples = noise(6, 4, 11);
  EXPECT_FALSE(kernel_pca(samples, {0, 0.9}, -1));
  EXPECT_FALSE(kernel_pca(samples, {0, 0.9}, testing::kNaN));
  EXPECT_FALSE(kernel_pca(samples, {0, 2}));
  EXPECT_FALSE(kernel_pca(MatrixXd(3, 0)));
  samples(1, 1) = testing::kNaN;
  EXPECT_FALSE(kernel_pca(samples));
}

}  // namespace
}  // namespace foldproof
