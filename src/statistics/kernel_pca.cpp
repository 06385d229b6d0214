#include <algorithm>
#include <cmath>
#include <limits>

#include "statistics/span.h"

namespace foldproof {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kWidths = 4;  // Median distances; the header says what was measured.
constexpr int kMostIterations = 100;
constexpr int kMostHalvings = 30;
constexpr double kRounding = 1e-10;            // Of the largest eigenvalue of the kernel matrix.
constexpr double kKernelSpanEnergy = 0.99999;  // With more samples than a dense span is made for.

VectorXd squared_distances(const MatrixXd& samples, const VectorView& y) {
  return (samples.colwise() - y).colwise().squaredNorm();
}

// The median distance of two samples that differ; 0 when none do.
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

Eigenpairs kernel_modes(const MatrixXd& centred, double trace, const SubspaceSize& size) {
  std::optional<Eigenpairs> pairs;
  if (centred.rows() > kDenseSide) {
    const auto product = [&](const auto& v, auto& out) { out.noalias() = centred * v; };
    pairs = leading_eigenpairs(centred.rows(), product, trace, size);
  }
  if (!pairs) pairs = dense_eigenpairs(centred);
  Eigen::Index modes = modes_wanted(pairs->values.cwiseMax(0), trace, size);
  while (modes > 0 && !(pairs->values[modes - 1] > kRounding * pairs->values[0])) --modes;
  return {pairs->values.head(modes), pairs->vectors.leftCols(modes)};
}

}  // namespace

VectorXd KernelPca::project_kernel(VectorXd kernel) const {
  // Centring in feature space, where the mean of the samples' images is the origin.
  kernel.array() -= kernel.mean();
  kernel -= row_means;
  kernel.array() += row_means.mean();
  return weights.transpose() * kernel;
}

VectorXd KernelPca::project(const VectorView& x) const {
  if (modes() == 0) return VectorXd(0);
  const VectorXd y = span.project(x);
  const double outside = (x - span.rebuild(y)).squaredNorm();
  const VectorXd squared = squared_distances(samples, y).array() + outside;
  return project_kernel((squared / (-2 * width * width)).array().exp());
}

VectorXd KernelPca::project_span(const VectorView& y) const {
  if (modes() == 0) return VectorXd(0);
  return project_kernel((squared_distances(samples, y) / (-2 * width * width)).array().exp());
}

VectorXd KernelPca::rebuild(const VectorView& p) const { return span.rebuild(rebuild_span(p)); }

VectorXd KernelPca::rebuild_span(const VectorView& p) const {
  if (modes() == 0) return VectorXd::Zero(span.modes());
  // The point of feature space is sum_i gamma_i image(x_i); images have length 1, so the nearest one
  // maximises near(y) = sum_i gamma_i k(y, x_i).
  VectorXd gamma = weights * p;
  gamma.array() += (1 - gamma.sum()) / static_cast<double>(gamma.size());
  const auto pull = [&](const VectorXd& y) -> VectorXd {
    return gamma.array() * (squared_distances(samples, y) / (-2 * width * width)).array().exp();
  };
  // Stays when p is so large that nothing can be compared.
  VectorXd y = VectorXd::Constant(samples.rows(), std::numeric_limits<double>::quiet_NaN());
  double near = -std::numeric_limits<double>::infinity();
  for (Eigen::Index k = 0; k < samples.cols(); ++k) {
    const double value = pull(samples.col(k)).sum();
    if (value > near) near = value, y = samples.col(k);
  }
  for (int iteration = 0; iteration < kMostIterations; ++iteration) {
    const VectorXd weight = pull(y);
    // Mika's step goes to sum_i weight_i x_i / sum_i weight_i. It climbs only while that sum is positive;
    // dividing by the sum of magnitudes otherwise keeps it climbing.
    const double sum = weight.sum();
    const double divisor = sum > 0 ? sum : weight.cwiseAbs().sum();
    if (!(divisor > 0)) break;
    VectorXd step = (samples * weight - y * sum) / divisor;
    VectorXd next = y + step;
    double nearer = pull(next).sum();
    for (int halving = 0; halving < kMostHalvings && !(nearer > near); ++halving) {
      step /= 2;
      next = y + step;
      nearer = pull(next).sum();
    }
    if (!(nearer > near)) break;
    const bool settled = step.norm() <= 1e-10 * width;
    y = next;
    near = nearer;
    if (settled) break;
  }
  return y;
}

double KernelPca::mahalanobis(const VectorView& p) const { return p.cwiseQuotient(deviations).norm(); }

Result<KernelPca> kernel_pca(const MatrixView& samples, const SubspaceSize& size, double width) {
  if (auto checked = check_size(size); !checked) return tl::unexpected(checked.error());
  if (!(width >= 0) || !std::isfinite(width)) {
    return fail("kernel width", "is not a length", "give a number above 0, or 0 to take it from the samples");
  }
  if (auto checked = check_columns(samples, "sample"); !checked) return tl::unexpected(checked.error());
  Span all = span_of(samples, samples.cols() <= kDenseSide ? kAllModes : SubspaceSize{0, kKernelSpanEnergy});

  KernelPca result;
  const MatrixXd exact = all.values.asDiagonal() * all.scores.transpose();
  const MatrixXd directions = all.directions;
  result.span = to_pca(std::move(all));
  // What span.project gives for the samples, so that a sample's distance from itself is 0 in spite of the
  // rounding.
  const MatrixXd to_rounded = result.span.basis.transpose() * directions;
  const MatrixXd gram = result.span.basis.transpose() * result.span.basis;
  result.samples = to_rounded * exact;
  result.samples += to_rounded * exact - gram * result.samples;
  result.width = width > 0 ? width : kWidths * median_distance(result.samples);
  result.weights.resize(samples.cols(), 0);
  result.row_means = VectorXd::Ones(samples.cols());
  if (result.span.modes() == 0) return result;

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
