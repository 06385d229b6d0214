/// The thin singular value decomposition under everything in this room, and checks of what comes in.
#pragma once

#include <functional>
#include <optional>

#include "foldproof/statistics.h"

namespace foldproof {

/// Up to so many samples (or numbers per sample) everything is dense.
inline constexpr Eigen::Index kDenseSide = 256;

/// Samples = mean + directions * diag(values) * scores^T, values descending. Directions and scores have
/// orthonormal columns; a direction's entry of largest magnitude is positive. Values no larger than 1e-7 of
/// the first, or than what rounding of the samples can leave, are not there.
struct Span {
  Eigen::VectorXd mean;
  Eigen::MatrixXd directions;
  Eigen::VectorXd values;
  Eigen::MatrixXd scores;
  double total = 0;  ///< Sum of squares of the centred samples, of all directions.

  Eigen::Index rank() const { return values.size(); }
};

/// Everything that has spread.
inline constexpr SubspaceSize kAllModes{0, 1.0};

/// Of finite samples, at least one. Cost and memory as foldproof::pca.
Span span_of(const MatrixView& samples, const SubspaceSize& size);

/// The same as a subspace of rounded columns.
Pca to_pca(Span span);
/// span_of(samples, size) from span_of(samples, kAllModes).
Span leading_part(const Span& all, const SubspaceSize& size);

/// cca of samples with these spans, all modes; what it refuses must not be asked.
Cca cca_of_spans(const Span& x, const Span& y, Index dimensions, double ridge);

/// Pca::project of every sample.
Eigen::MatrixXd project_all(const Pca& subspace, const MatrixView& samples);

/// The share of a total that the first of these variances have, up to and with each.
Eigen::VectorXd cumulative_share(const Eigen::VectorXd& variances, double total);

/// The first modes of descending variances that `size` asks for.
Eigen::Index modes_wanted(const Eigen::VectorXd& variances, double total, const SubspaceSize& size);

struct Eigenpairs {
  Eigen::VectorXd values;   ///< Descending.
  Eigen::MatrixXd vectors;  ///< Columns, orthonormal.
};

Eigenpairs dense_eigenpairs(const Eigen::MatrixXd& symmetric);

/// The leading eigenpairs of a positive semidefinite matrix of n rows that is known by its products only,
/// enough for `size`; nothing when so many are asked for that a dense computation is the better one, or no
/// convergence came.
using Product =
    std::function<void(const Eigen::Map<const Eigen::VectorXd>& v, Eigen::Map<Eigen::VectorXd>& out)>;
std::optional<Eigenpairs> leading_eigenpairs(Eigen::Index n, const Product& product, double trace,
                                             const SubspaceSize& size);

/// 1 when the entry of largest magnitude (the first of them) is positive, else -1.
double sign_of(const VectorView& direction);

/// Columns are there and all numbers are finite. `what`: "sample" or "point".
Result<void> check_columns(const MatrixView& columns, const char* what);
Result<void> check_size(const SubspaceSize& size);

}  // namespace foldproof
