#include "statistics/thin_svd.h"

#include <fmt/format.h>

#include <Spectra/SymEigsSolver.h>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "statistics/tall_skinny.h"

namespace foldproof::internal {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// A mode's value is larger than this share of the largest one.
constexpr double kMinValue = 1e-7;
// Below this share of the largest value, columns that come from a Gram matrix are orthogonalized again.
constexpr double kNearlyDependent = 1e-3;

// The samples minus their mean, computed block by block: no second copy of all samples.
class Centered {
 public:
  explicit Centered(const MatrixView& samples) : samples_(samples) {
    // Relative to the first sample, so that the mean of equal samples is exact.
    mean_ = samples.col(0);
    VectorXd sum = VectorXd::Zero(samples.rows());
    for (Eigen::Index k = 1; k < samples.cols(); ++k) sum += samples.col(k) - mean_;
    mean_ += sum / static_cast<double>(samples.cols());
  }

  const VectorXd& mean() const { return mean_; }
  Eigen::Index size() const { return samples_.rows(); }
  Eigen::Index count() const { return samples_.cols(); }

  // visit(first row, rows of the centered samples)
  template <class Visit>
  void for_rows(Visit&& visit) const {
    const Eigen::Index step = block_rows(count());
    MatrixXd block;
    for (Eigen::Index first = 0; first < size(); first += step) {
      const Eigen::Index rows = std::min(step, size() - first);
      block = samples_.middleRows(first, rows).colwise() - mean_.segment(first, rows);
      visit(first, std::as_const(block));
    }
  }

  // visit(first column, columns of the centered samples)
  template <class Visit>
  void for_columns(Visit&& visit) const {
    const Eigen::Index step = block_rows(size());
    MatrixXd block;
    for (Eigen::Index first = 0; first < count(); first += step) {
      const Eigen::Index columns = std::min(step, count() - first);
      block = samples_.middleCols(first, columns).colwise() - mean_;
      visit(first, std::as_const(block));
    }
  }

  double total() const {
    double total = 0;
    for_rows([&](Eigen::Index, const MatrixXd& rows) { total += rows.squaredNorm(); });
    return total;
  }

  MatrixXd gram() const {
    MatrixXd gram = MatrixXd::Zero(count(), count());
    for_rows([&](Eigen::Index, const MatrixXd& rows) { gram += tall_skinny_inner(rows, rows); });
    return gram;
  }

  MatrixXd scatter() const {
    MatrixXd lower = MatrixXd::Zero(size(), size());
    for_columns([&](Eigen::Index, const MatrixXd& columns) {
      lower.selfadjointView<Eigen::Lower>().rankUpdate(columns);
    });
    return lower.selfadjointView<Eigen::Lower>();
  }

  MatrixXd times(const MatrixXd& v) const {
    MatrixXd out(size(), v.cols());
    for_rows([&](Eigen::Index first, const MatrixXd& rows) {
      out.middleRows(first, rows.rows()) = tall_skinny_product(rows, v);
    });
    return out;
  }

  MatrixXd transposed_times(const MatrixXd& u) const {
    MatrixXd out(count(), u.cols());
    for_columns([&](Eigen::Index first, const MatrixXd& columns) {
      out.middleRows(first, columns.cols()).noalias() = columns.transpose() * u;
    });
    return out;
  }

  // out = gram() v, without forming the matrix.
  void gram_times(const Eigen::Map<const VectorXd>& v, Eigen::Map<VectorXd>& out) const {
    out.setZero();
    VectorXd part;
    for_rows([&](Eigen::Index, const MatrixXd& rows) {
      part.noalias() = rows * v;
      out.noalias() += rows.transpose() * part;
    });
  }

 private:
  const MatrixView& samples_;
  VectorXd mean_;
};

// Makes columns orthonormal that are orthogonal except for the precision lost in a Gram matrix. Returns their
// lengths; drops columns not above `floor`, and their partners.
VectorXd orthonormalize(MatrixXd& columns, MatrixXd& partners, double floor) {
  VectorXd values(columns.cols());
  Eigen::Index kept = 0;
  for (Eigen::Index k = 0; k < columns.cols(); ++k) {
    VectorXd column = columns.col(k);
    const double largest = kept > 0 ? values[0] : column.norm();
    if (kept > 0 && column.norm() < kNearlyDependent * largest) {
      column -= columns.leftCols(kept) * (columns.leftCols(kept).transpose() * column);
    }
    const double length = column.norm();
    if (!(length > std::max(floor, kMinValue * largest))) continue;
    columns.col(kept) = column / length;
    partners.col(kept) = partners.col(k);
    values[kept++] = length;
  }
  columns.conservativeResize(Eigen::NoChange, kept);
  partners.conservativeResize(Eigen::NoChange, kept);
  values.conservativeResize(kept);
  return values;
}

// A bound on the Frobenius norm of the samples' rounding errors.
double rounding_floor(const MatrixView& samples) {
  const double largest = samples.cwiseAbs().maxCoeff();
  return 4 * std::numeric_limits<double>::epsilon() * largest *
         std::sqrt(static_cast<double>(samples.size()));
}

// A product as Spectra reads it. The shift keeps its relative convergence test meaningful at eigenvalue 0.
struct ShiftedProduct {
  using Scalar = double;
  static constexpr double kShift = 1e-3;

  Eigen::Index n;
  const Product* product;
  double trace;

  Eigen::Index rows() const { return n; }
  Eigen::Index cols() const { return n; }
  void perform_op(const double* in, double* out) const {
    const Eigen::Map<const VectorXd> v(in, n);
    Eigen::Map<VectorXd> result(out, n);
    (*product)(v, result);
    result = result / trace + kShift * v;
  }
};

}  // namespace

Eigenpairs dense_eigenpairs(const MatrixXd& symmetric) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(symmetric);
  return {solver.eigenvalues().reverse(), solver.eigenvectors().rowwise().reverse()};
}

std::optional<Eigenpairs> leading_eigenpairs(Eigen::Index n, const Product& product, double trace,
                                             const SubspaceSize& size) {
  if (!(trace > 0)) return std::nullopt;
  const bool fixed_count = size.modes > 0;
  Eigen::Index count = fixed_count ? size.modes : size.energy < 1 ? 16 : n;
  for (; 2 * count < n; count *= 2) {
    ShiftedProduct operation{n, &product, trace};
    Spectra::SymEigsSolver<ShiftedProduct> solver(
        operation, count, std::min<Eigen::Index>(n, std::max<Eigen::Index>(2 * count + 1, 20)));
    solver.init();
    solver.compute(Spectra::SortRule::LargestAlge, 200, 1e-11);
    if (solver.info() != Spectra::CompInfo::Successful) return std::nullopt;
    Eigenpairs pairs{(solver.eigenvalues().array() - ShiftedProduct::kShift).max(0.0) * trace,
                     solver.eigenvectors()};
    if (fixed_count || pairs.values.sum() >= size.energy * trace) return pairs;
  }
  return std::nullopt;
}

VectorXd cumulative_share(const VectorXd& variances, double total) {
  VectorXd share(variances.size());
  double sum = 0;
  for (Eigen::Index k = 0; k < variances.size(); ++k) share[k] = std::min(1.0, (sum += variances[k]) / total);
  return share;
}

Eigen::Index mode_count(const VectorXd& variances, double total, const SubspaceSize& size) {
  if (size.modes > 0) return std::min<Eigen::Index>(size.modes, variances.size());
  if (size.energy >= 1) return variances.size();
  double sum = 0;
  Eigen::Index modes = 0;
  while (modes < variances.size() && sum < size.energy * total) sum += variances[modes++];
  return modes;
}

double sign_of(const VectorView& direction) {
  Eigen::Index largest = 0;
  direction.cwiseAbs().maxCoeff(&largest);
  return direction[largest] < 0 ? -1 : 1;
}

ThinSvd thin_svd(const MatrixView& samples, const SubspaceSize& size) {
  const Centered centered(samples);
  ThinSvd svd;
  svd.mean = centered.mean();
  const double floor = rounding_floor(samples);

  // Dense solvers compute all modes, the iterative one only those it needs.
  const auto leading = [&](Eigenpairs pairs) {
    const Eigen::Index modes = mode_count(pairs.values.cwiseMax(0), svd.total, size);
    return MatrixXd(pairs.vectors.leftCols(modes));
  };
  const bool iterate = std::min(centered.count(), centered.size()) > kMaxDenseSize;
  MatrixXd gram;
  if (!iterate && centered.count() <= centered.size()) gram = centered.gram();
  svd.total = gram.size() > 0 ? gram.trace() : centered.total();
  std::optional<Eigenpairs> of_gram;
  if (iterate) {
    const auto product = [&](const auto& v, auto& out) { centered.gram_times(v, out); };
    of_gram = leading_eigenpairs(centered.count(), product, svd.total, size);
  }
  if (!of_gram && centered.count() <= centered.size())
    of_gram = dense_eigenpairs(gram.size() > 0 ? gram : centered.gram());
  if (of_gram) {
    svd.scores = leading(*std::move(of_gram));
    svd.directions = centered.times(svd.scores);
    svd.values = orthonormalize(svd.directions, svd.scores, floor);
  } else {
    svd.directions = leading(dense_eigenpairs(centered.scatter()));
    svd.scores = centered.transposed_times(svd.directions);
    svd.values = orthonormalize(svd.scores, svd.directions, floor);
  }
  for (Eigen::Index k = 0; k < svd.rank(); ++k) {
    const double sign = sign_of(svd.directions.col(k));
    svd.directions.col(k) *= sign;
    svd.scores.col(k) *= sign;
  }
  return svd;
}

Pca to_pca(ThinSvd svd) {
  Pca result;
  const double degrees = static_cast<double>(std::max<Eigen::Index>(1, svd.scores.rows() - 1));
  result.mean = std::move(svd.mean);
  result.basis = svd.directions.cast<float>().cast<double>();
  result.deviations = svd.values / std::sqrt(degrees);
  result.energy = cumulative_share(svd.values.cwiseAbs2(), svd.total);
  return result;
}

ThinSvd truncate(const ThinSvd& all, const SubspaceSize& size) {
  const Eigen::Index modes = mode_count(all.values.cwiseAbs2(), all.total, size);
  return {all.mean, all.directions.leftCols(modes), all.values.head(modes), all.scores.leftCols(modes),
          all.total};
}

MatrixXd project_all(const Pca& subspace, const MatrixView& samples) {
  const MatrixXd& basis = subspace.basis;
  MatrixXd p = MatrixXd::Zero(basis.cols(), samples.cols());
  MatrixXd gram = MatrixXd::Zero(basis.cols(), basis.cols());
  const Eigen::Index step = block_rows(samples.cols());
  for (Eigen::Index first = 0; first < samples.rows(); first += step) {
    const Eigen::Index rows = std::min(step, samples.rows() - first);
    const auto part = basis.middleRows(first, rows);
    const MatrixXd differences =
        samples.middleRows(first, rows).colwise() - subspace.mean.segment(first, rows);
    p += tall_skinny_inner(part, differences);
    gram += tall_skinny_inner(part, part);
  }
  // The same refinement step as in Pca::project.
  return p + (p - gram * p);
}

Result<void> check_columns(const MatrixView& columns, const char* what) {
  if (columns.cols() == 0 || columns.rows() == 0) {
    return fail(ErrorCode::InvalidArgument, fmt::format("{}s", what), "there are none",
                fmt::format("give at least one {}", what));
  }
  for (Eigen::Index k = 0; k < columns.cols(); ++k) {
    if (columns.col(k).allFinite()) continue;
    Eigen::Index row = 0;
    while (std::isfinite(columns(row, k))) ++row;
    return fail(ErrorCode::NonFinite, fmt::format("{} {}", what, k),
                fmt::format("number {} is not finite", row),
                fmt::format("leave this {} out or repair it", what));
  }
  return {};
}

Result<void> check_size(const SubspaceSize& size) {
  if (size.modes > 0 || (size.energy > 0 && size.energy <= 1)) return {};
  return fail(ErrorCode::InvalidArgument, "energy",
              fmt::format("{} is not a share of the variance", size.energy),
              "give a number above 0 and at most 1");
}

}  // namespace foldproof::internal
