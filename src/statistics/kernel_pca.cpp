#include <algorithm>
#include <cmath>
#include <limits>

#include "base/try.h"
#include "statistics/thin_svd.h"
#include "statistics/training.h"

namespace foldproof {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kMedianWidths = 4;  // The header says what was measured.
constexpr int kMaxIterations = 100;
constexpr int kMaxHalvings = 30;
constexpr double kRounding = 1e-10;           // Of the largest eigenvalue of the kernel matrix.
constexpr double kIterativeEnergy = 0.99999;  // Of the linear PCA when it is iterative.

VectorXd squared_distances(const MatrixXd& samples, const VectorView& y) {
  return (samples.colwise() - y).colwise().squaredNorm();
}

// The median distance between two different samples; 0 when all are equal.
double median_distance(const MatrixXd& samples) {
  std::vector<double> squared;
  for (Eigen::Index k = 0; k + 1 < samples.cols(); ++k) {
    for (Eigen::Index other = k + 1; other < samples.cols(); ++other) {
      const double d = (samples.col(k) - samples.col(other)).squaredNorm();
      if (d > 0) squared.push_back(d);
    }
  }
  if (squared.empty()) return 0;
  const auto middle = squared.begin() + static_cast<std::ptrdiff_t>(squared.size() / 2);
  std::nth_element(squared.begin(), middle, squared.end());
  return std::sqrt(*middle);
}

MatrixXd kernel_matrix(const MatrixXd& samples, double width) {
  MatrixXd kernel(samples.cols(), samples.cols());
  for (Eigen::Index k = 0; k < samples.cols(); ++k) {
    kernel.col(k) = (squared_distances(samples, samples.col(k)) / (-2 * width * width)).array().exp();
  }
  return kernel;
}

Eigenpairs kernel_modes(const MatrixXd& centered, double trace, const SubspaceSize& size) {
  std::optional<Eigenpairs> pairs;
  if (centered.rows() > kMaxDenseSize) {
    const auto product = [&](const auto& v, auto& out) { out.noalias() = centered * v; };
    pairs = leading_eigenpairs(centered.rows(), product, trace, size);
  }
  if (!pairs) pairs = dense_eigenpairs(centered);
  Eigen::Index modes = mode_count(pairs->values.cwiseMax(0), trace, size);
  while (modes > 0 && !(pairs->values[modes - 1] > kRounding * pairs->values[0])) --modes;
  return {pairs->values.head(modes), pairs->vectors.leftCols(modes)};
}

}  // namespace

VectorXd KernelPca::project_kernel(VectorXd kernel) const {
  // Center in feature space: the mean of the samples' images becomes the origin.
  kernel.array() -= kernel.mean();
  kernel -= row_means;
  kernel.array() += row_means.mean();
  return weights.transpose() * kernel;
}

VectorXd KernelPca::project(const VectorView& x) const {
  if (modes() == 0) return VectorXd(0);
  const VectorXd y = pca.project(x);
  const double outside = (x - pca.reconstruct(y)).squaredNorm();
  const VectorXd squared = squared_distances(samples, y).array() + outside;
  return project_kernel((squared / (-2 * width * width)).array().exp());
}

VectorXd KernelPca::project_coordinates(const VectorView& y) const {
  if (modes() == 0) return VectorXd(0);
  return project_kernel((squared_distances(samples, y) / (-2 * width * width)).array().exp());
}

VectorXd KernelPca::reconstruct(const VectorView& p) const {
  return pca.reconstruct(reconstruct_coordinates(p));
}

VectorXd KernelPca::reconstruct_coordinates(const VectorView& p) const {
  if (modes() == 0) return VectorXd::Zero(pca.modes());
  // The point of feature space is sum_i gamma_i image(x_i). Images have length 1, so the nearest one
  // maximizes similarity(y) = sum_i gamma_i k(y, x_i).
  VectorXd gamma = weights * p;
  gamma.array() += (1 - gamma.sum()) / static_cast<double>(gamma.size());
  const auto terms = [&](const VectorXd& y) -> VectorXd {
    return gamma.array() * (squared_distances(samples, y) / (-2 * width * width)).array().exp();
  };
  // NaN remains when p is too large to compute with.
  VectorXd y = VectorXd::Constant(samples.rows(), std::numeric_limits<double>::quiet_NaN());
  double similarity = -std::numeric_limits<double>::infinity();
  for (Eigen::Index k = 0; k < samples.cols(); ++k) {
    const double value = terms(samples.col(k)).sum();
    if (value > similarity) similarity = value, y = samples.col(k);
  }
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    const VectorXd weight = terms(y);
    // Mika's step goes to sum_i weight_i x_i / sum_i weight_i. It ascends only while that sum is positive;
    // otherwise the sum of magnitudes is the divisor, so that it still ascends.
    const double sum = weight.sum();
    const double divisor = sum > 0 ? sum : weight.cwiseAbs().sum();
    if (!(divisor > 0)) break;
    VectorXd step = (samples * weight - y * sum) / divisor;
    VectorXd next = y + step;
    double next_similarity = terms(next).sum();
    for (int halving = 0; halving < kMaxHalvings && !(next_similarity > similarity); ++halving) {
      step /= 2;
      next = y + step;
      next_similarity = terms(next).sum();
    }
    if (!(next_similarity > similarity)) break;
    const bool converged = step.norm() <= 1e-10 * width;
    y = next;
    similarity = next_similarity;
    if (converged) break;
  }
  return y;
}

double KernelPca::mahalanobis(const VectorView& p) const { return p.cwiseQuotient(deviations).norm(); }

Result<KernelPca> internal::kernel_pca(const MatrixView& samples, const SubspaceSize& size, double width) {
  FOLDPROOF_TRY(check_size(size));
  if (!(width >= 0) || !std::isfinite(width)) {
    return fail(ErrorCode::InvalidArgument, "kernel width", "is not a length",
                "give a number above 0, or 0 to take it from the samples");
  }
  FOLDPROOF_TRY(check_columns(samples, "sample"));
  ThinSvd all =
      thin_svd(samples, samples.cols() <= kMaxDenseSize ? kAllModes : SubspaceSize{0, kIterativeEnergy});

  KernelPca result;
  const MatrixXd exact = all.values.asDiagonal() * all.scores.transpose();
  const MatrixXd directions = all.directions;
  result.pca = to_pca(std::move(all));
  // As pca.project computes them, so that a sample's distance from itself is 0 in spite of the rounded basis.
  const MatrixXd to_rounded = result.pca.basis.transpose() * directions;
  const MatrixXd gram = result.pca.basis.transpose() * result.pca.basis;
  result.samples = to_rounded * exact;
  result.samples += to_rounded * exact - gram * result.samples;
  result.width = width > 0 ? width : kMedianWidths * median_distance(result.samples);
  result.weights.resize(samples.cols(), 0);
  result.row_means = VectorXd::Ones(samples.cols());
  if (result.pca.modes() == 0) return result;

  MatrixXd kernel = kernel_matrix(result.samples, result.width);
  result.row_means = kernel.rowwise().mean();
  const double mean = result.row_means.mean();
  kernel.colwise() -= result.row_means;
  kernel.rowwise() -= result.row_means.transpose();
  kernel.array() += mean;
  const double trace = kernel.trace();
  const Eigenpairs modes = kernel_modes(kernel, trace, size);
  result.weights = modes.vectors * modes.values.cwiseSqrt().cwiseInverse().asDiagonal();
  for (Eigen::Index k = 0; k < result.weights.cols(); ++k) {
    result.weights.col(k) *= sign_of(result.weights.col(k));
  }
  result.deviations = (modes.values / static_cast<double>(samples.cols() - 1)).cwiseSqrt();
  result.energy = cumulative_share(modes.values, trace);
  return result;
}

}  // namespace foldproof
