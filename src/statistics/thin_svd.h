/// The thin singular value decomposition that this module builds on, and checks of its inputs.
#pragma once

#include <functional>
#include <optional>

#include "foldproof/statistics.h"

namespace foldproof::inline internal {

/// Up to this many samples (or numbers per sample), solvers are dense.
inline constexpr Eigen::Index kMaxDenseSize = 256;

/// Samples = mean + directions * diag(values) * scores^T, values descending. Directions and scores have
/// orthonormal columns; a direction's entry of largest magnitude is positive. Values that are at most 1e-7 of
/// the first, or that rounding of the samples explains, are dropped.
struct ThinSvd {
  Eigen::VectorXd mean;
  Eigen::MatrixXd directions;
  Eigen::VectorXd values;
  Eigen::MatrixXd scores;
  double total = 0;  ///< Sum of squares of the centered samples, over all directions.

  Eigen::Index rank() const { return values.size(); }
};

/// Every direction that has variance.
inline constexpr SubspaceSize kAllModes{0, 1.0};

/// `samples`: finite, at least one. Cost and memory as foldproof::pca.
ThinSvd thin_svd(const MatrixView& samples, const SubspaceSize& size);

/// As a subspace, with its basis rounded to floats.
Pca to_pca(ThinSvd svd);
/// thin_svd(samples, size) from thin_svd(samples, kAllModes).
ThinSvd truncate(const ThinSvd& all, const SubspaceSize& size);

/// cca of samples that have these decompositions (all modes). Precondition: cca accepts them.
Cca cca_of_svds(const ThinSvd& x, const ThinSvd& y, Index dimensions, double ridge);

/// Pca::project of every sample.
Eigen::MatrixXd project_all(const Pca& subspace, const MatrixView& samples);

/// The running sums of the variances as shares of `total`.
Eigen::VectorXd cumulative_share(const Eigen::VectorXd& variances, double total);

/// How many leading modes `size` keeps. `variances`: descending.
Eigen::Index mode_count(const Eigen::VectorXd& variances, double total, const SubspaceSize& size);

struct Eigenpairs {
  Eigen::VectorXd values;   ///< Descending.
  Eigen::MatrixXd vectors;  ///< Columns, orthonormal.
};

Eigenpairs dense_eigenpairs(const Eigen::MatrixXd& symmetric);

/// out = matrix v.
using Product =
    std::function<void(const Eigen::Map<const Eigen::VectorXd>& v, Eigen::Map<Eigen::VectorXd>& out)>;

/// The leading eigenpairs of a positive semidefinite n x n matrix given by its products, as many as `size`
/// needs. None when it needs so many that a dense solver is faster, or when the iteration does not converge.
std::optional<Eigenpairs> leading_eigenpairs(Eigen::Index n, const Product& product, double trace,
                                             const SubspaceSize& size);

/// 1 when the entry of largest magnitude (the first of them) is positive, else -1.
double sign_of(const VectorView& direction);

/// Error when there are no columns or a number is not finite. `what`: "sample" or "point".
Result<void> check_columns(const MatrixView& columns, const char* what);
Result<void> check_size(const SubspaceSize& size);

}  // namespace foldproof::inline internal
