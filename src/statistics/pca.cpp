#include "base/try.h"
#include "statistics/thin_svd.h"

namespace foldproof {

using Eigen::VectorXd;

VectorXd Pca::project(const VectorView& x) const {
  const VectorXd difference = x - mean;
  VectorXd p = basis.transpose() * difference;
  // Rounded columns are orthonormal only to 1e-7; one refinement step squares that error.
  p += basis.transpose() * (difference - basis * p);
  return p;
}

VectorXd Pca::reconstruct(const VectorView& p) const { return mean + basis * p; }

double Pca::mahalanobis(const VectorView& p) const { return p.cwiseQuotient(deviations).norm(); }

Result<Pca> pca(const MatrixView& samples, const SubspaceSize& size) {
  FOLDPROOF_TRY(check_columns(samples, "sample"));
  FOLDPROOF_TRY(check_size(size));
  return to_pca(thin_svd(samples, size));
}

}  // namespace foldproof
