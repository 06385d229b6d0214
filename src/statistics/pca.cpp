#include "statistics/span.h"

namespace foldproof {

using Eigen::VectorXd;

VectorXd Pca::project(const VectorView& x) const {
  const VectorXd difference = x - mean;
  VectorXd p = basis.transpose() * difference;
  // Rounded columns are orthonormal to 1e-7 only; one step of refinement squares that error.
  p += basis.transpose() * (difference - basis * p);
  return p;
}

VectorXd Pca::rebuild(const VectorView& p) const { return mean + basis * p; }

double Pca::mahalanobis(const VectorView& p) const { return p.cwiseQuotient(deviations).norm(); }

Result<Pca> pca(const MatrixView& samples, const SubspaceSize& size) {
  if (auto checked = check_columns(samples, "sample"); !checked) return tl::unexpected(checked.error());
  if (auto checked = check_size(size); !checked) return tl::unexpected(checked.error());
  return to_pca(span_of(samples, size));
}

}  // namespace foldproof
