#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "statistics/span.h"

namespace foldproof {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Variances of the span's directions with the ridge on top.
VectorXd with_ridge(const Span& span, double degrees, double ridge) {
  const VectorXd variances = span.values.cwiseAbs2() / degrees;
  return variances.array() + ridge * variances.mean();
}

}  // namespace

VectorXd Cca::predict(const VectorView& x) const {
  return mean_y + loads * (weights.transpose() * (x - mean_x)).eval();
}

Result<Cca> cca(const MatrixView& x_samples, const MatrixView& y_samples, Index dimensions, double ridge) {
  if (auto checked = check_columns(x_samples, "sample"); !checked) return tl::unexpected(checked.error());
  if (auto checked = check_columns(y_samples, "sample"); !checked) return tl::unexpected(checked.error());
  if (x_samples.cols() != y_samples.cols()) {
    return fail("samples", "the two sets differ in number", "give both for the same samples");
  }
  if (dimensions == 0) return fail("dimensions", "none are asked for", "ask for at least one");
  if (!(ridge > 0) || !std::isfinite(ridge)) return fail("ridge", "is not positive", "give a number above 0");

  return cca_of_spans(span_of(x_samples, kAllModes), span_of(y_samples, kAllModes), dimensions, ridge);
}

Cca cca_of_spans(const Span& x, const Span& y, Index dimensions, double ridge) {
  Cca result{x.mean, y.mean, MatrixXd(x.mean.size(), 0), MatrixXd(y.mean.size(), 0), VectorXd()};
  if (x.rank() == 0 || y.rank() == 0) return result;

  // In coordinates of both spans, scaled to unit (ridged) variance, the canonical pairs are the singular
  // vectors of the cross covariance.
  const double degrees = static_cast<double>(x.scores.rows() - 1);
  const VectorXd x_scale = with_ridge(x, degrees, ridge).cwiseSqrt().cwiseInverse();
  const VectorXd y_scale = with_ridge(y, degrees, ridge).cwiseSqrt().cwiseInverse();
  const MatrixXd cross =
      y.values.asDiagonal() * (y.scores.transpose() * x.scores) * x.values.asDiagonal() / degrees;
  const Eigen::JacobiSVD<MatrixXd> svd(x_scale.asDiagonal() * cross.transpose() * y_scale.asDiagonal(),
                                       Eigen::ComputeThinU | Eigen::ComputeThinV);
  Eigen::Index kept = std::min<Eigen::Index>(dimensions, svd.singularValues().size());
  while (kept > 0 && svd.singularValues()[kept - 1] < 1e-12) --kept;

  const MatrixXd in_span = x_scale.asDiagonal() * svd.matrixU().leftCols(kept);
  result.weights = x.directions * in_span;
  result.loads = y.directions * (cross * in_span);
  result.correlations = svd.singularValues().head(kept).cwiseMin(1);
  for (Eigen::Index k = 0; k < kept; ++k) {
    const double sign = sign_of(result.weights.col(k));
    result.weights.col(k) *= sign;
    result.loads.col(k) *= sign;
  }
  return result;
}

}  // namespace foldproof
