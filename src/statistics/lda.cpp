#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/try.h"
#include "statistics/thin_svd.h"
#include "statistics/training.h"

namespace foldproof::internal {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

struct Scored {
  double score;
  bool is_class_1;
};

// Sets threshold and error; false when all scores are equal.
bool find_threshold(std::vector<Scored> scored, Lda& lda) {
  std::sort(scored.begin(), scored.end(), [](const Scored& a, const Scored& b) { return a.score < b.score; });
  double class_1 = 0;
  for (const Scored& s : scored) class_1 += s.is_class_1;
  const double class_0 = static_cast<double>(scored.size()) - class_1;

  double below_0 = 0, below_1 = 0, widest = 0;
  lda.error = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k + 1 < scored.size(); ++k) {
    (scored[k].is_class_1 ? below_1 : below_0) += 1;
    const double gap = scored[k + 1].score - scored[k].score;
    if (!(gap > 0)) continue;
    const double error = (below_1 / class_1 + (class_0 - below_0) / class_0) / 2;
    if (error < lda.error || (error == lda.error && gap > widest)) {
      lda.error = error;
      lda.threshold = scored[k].score + gap / 2;
      widest = gap;
    }
  }
  return std::isfinite(lda.error);
}

// S^-1 (mean_1 - mean_0) in subspace coordinates of the points; zero when the means are equal.
VectorXd discriminant(const MatrixXd& coordinates, std::span<const std::uint8_t> is_class_1, double ridge) {
  const Eigen::Index rank = coordinates.rows();
  VectorXd means[2] = {VectorXd::Zero(rank), VectorXd::Zero(rank)};
  double sizes[2] = {0, 0};
  for (std::size_t k = 0; k < is_class_1.size(); ++k) {
    means[is_class_1[k] != 0] += coordinates.col(k);
    ++sizes[is_class_1[k] != 0];
  }
  for (int c = 0; c < 2; ++c) means[c] /= sizes[c];
  MatrixXd within = coordinates;
  for (std::size_t k = 0; k < is_class_1.size(); ++k) within.col(k) -= means[is_class_1[k] != 0];
  VectorXd difference = means[1] - means[0];
  if (difference.norm() <= 1e-12 * coordinates.norm()) return VectorXd::Zero(rank);

  const double degrees = std::max(1.0, static_cast<double>(is_class_1.size()) - 2);
  MatrixXd covariance = within * within.transpose() / degrees;
  const double variance = covariance.trace() / static_cast<double>(rank);
  // Each class is a single point: every metric gives the line through the two.
  if (within.norm() <= 1e-12 * coordinates.norm()) return difference;
  covariance.diagonal().array() += ridge * variance;
  return covariance.ldlt().solve(difference);
}

}  // namespace

Result<Lda> lda(const MatrixView& points, std::span<const std::uint8_t> is_class_1, double ridge) {
  FOLDPROOF_TRY(check_columns(points, "point"));
  if (static_cast<std::size_t>(points.cols()) != is_class_1.size()) {
    return fail(ErrorCode::InvalidArgument, "classes",
                fmt::format("there are {} for {} points", is_class_1.size(), points.cols()),
                "give one per point");
  }
  if (!(ridge > 0) || !std::isfinite(ridge)) {
    return fail(ErrorCode::InvalidArgument, "ridge", "is not positive", "give a number above 0");
  }
  const auto ones =
      std::count_if(is_class_1.begin(), is_class_1.end(), [](std::uint8_t c) { return c != 0; });
  if (ones == 0 || ones == points.cols()) {
    return fail(ErrorCode::InvalidArgument, "classes",
                fmt::format("class {} has no points", ones == 0 ? 1 : 0), "give points of both");
  }
  const auto same_mean =
      fail(ErrorCode::InvalidArgument, "classes", "both have the same mean, so no direction separates them",
           "give points that differ");
  const ThinSvd svd = thin_svd(points, kAllModes);
  const VectorXd in_subspace =
      discriminant(svd.values.asDiagonal() * svd.scores.transpose(), is_class_1, ridge);
  if (!(in_subspace.norm() > 0)) return same_mean;

  Lda result;
  result.direction = (svd.directions * in_subspace).normalized();
  std::vector<Scored> scored(is_class_1.size());
  for (std::size_t k = 0; k < scored.size(); ++k) {
    scored[k] = {result.direction.dot(points.col(k)), is_class_1[k] != 0};
  }
  if (!find_threshold(std::move(scored), result)) return same_mean;
  return result;
}

}  // namespace foldproof::internal
