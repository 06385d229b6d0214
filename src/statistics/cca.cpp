#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "base/try.h"
#include "statistics/thin_svd.h"
#include "statistics/training.h"

namespace foldproof {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Variances along the directions, with the ridge added.
VectorXd ridged_variances(const ThinSvd& svd, double degrees, double ridge) {
  const VectorXd variances = svd.values.cwiseAbs2() / degrees;
  return variances.array() + ridge * variances.mean();
}

}  // namespace

VectorXd Cca::predict(const VectorView& x) const {
  return mean_y + loadings * (weights.transpose() * (x - mean_x)).eval();
}

Result<Cca> internal::cca(const MatrixView& x_samples, const MatrixView& y_samples, Index dimensions,
                          double ridge) {
  FOLDPROOF_TRY(check_columns(x_samples, "sample"));
  FOLDPROOF_TRY(check_columns(y_samples, "sample"));
  if (x_samples.cols() != y_samples.cols()) {
    return fail(ErrorCode::InvalidArgument, "samples", "the two sets differ in number",
                "give both for the same samples");
  }
  if (dimensions == 0) {
    return fail(ErrorCode::InvalidArgument, "dimensions", "are 0", "give at least one");
  }
  if (!(ridge > 0) || !std::isfinite(ridge)) {
    return fail(ErrorCode::InvalidArgument, "ridge", "is not positive", "give a number above 0");
  }
  return cca_of_svds(thin_svd(x_samples, kAllModes), thin_svd(y_samples, kAllModes), dimensions, ridge);
}

Cca internal::cca_of_svds(const ThinSvd& x, const ThinSvd& y, Index dimensions, double ridge) {
  Cca result{x.mean, y.mean, MatrixXd(x.mean.size(), 0), MatrixXd(y.mean.size(), 0), VectorXd()};
  if (x.rank() == 0 || y.rank() == 0) return result;

  // In subspace coordinates scaled to unit (ridged) variance, the canonical pairs are the singular vectors of
  // the cross-covariance.
  const double degrees = static_cast<double>(x.scores.rows() - 1);
  const VectorXd x_scale = ridged_variances(x, degrees, ridge).cwiseSqrt().cwiseInverse();
  const VectorXd y_scale = ridged_variances(y, degrees, ridge).cwiseSqrt().cwiseInverse();
  const MatrixXd cross =
      y.values.asDiagonal() * (y.scores.transpose() * x.scores) * x.values.asDiagonal() / degrees;
  const Eigen::JacobiSVD<MatrixXd> svd(x_scale.asDiagonal() * cross.transpose() * y_scale.asDiagonal(),
                                       Eigen::ComputeThinU | Eigen::ComputeThinV);
  Eigen::Index kept = std::min<Eigen::Index>(dimensions, svd.singularValues().size());
  while (kept > 0 && svd.singularValues()[kept - 1] < 1e-12) --kept;

  const MatrixXd in_subspace = x_scale.asDiagonal() * svd.matrixU().leftCols(kept);
  result.weights = x.directions * in_subspace;
  result.loadings = y.directions * (cross * in_subspace);
  result.correlations = svd.singularValues().head(kept).cwiseMin(1);
  for (Eigen::Index k = 0; k < kept; ++k) {
    const double sign = sign_of(result.weights.col(k));
    result.weights.col(k) *= sign;
    result.loadings.col(k) *= sign;
  }
  return result;
}

}  // namespace foldproof
