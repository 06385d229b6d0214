#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/try.h"
#include "keypoints/choose.h"
#include "keypoints/least_squares.h"
#include "statistics/tall_skinny.h"
#include "statistics/thin_svd.h"

namespace foldproof::internal {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kResidualEnergy = 0.95;
constexpr Index kMaxModesPerRound = 16;
// Rounds use at most this many poses, evenly spaced, which bounds their cost.
constexpr Eigen::Index kMaxPoses = 128;
constexpr double kMinGain = 1e-3;  // Of the error: a smaller improvement counts as none.

class Chooser {
 public:
  Chooser(const MatrixView& samples, const Pca& subspace, std::size_t budget)
      : subspace_(subspace),
        samples_(samples),
        residual_(samples.rows(), std::min(samples.cols(), kMaxPoses)),
        budget_(budget),
        is_chosen_(samples.rows() / 3, 0) {}

  void add(Index vertex) {
    is_chosen_[vertex] = 1;
    chosen_.vertices.push_back(vertex);
  }

  // Adds two points for each vector, until the budget is spent.
  void add_for(const MatrixXd& vectors) {
    for (Eigen::Index k = 0; k < vectors.cols(); ++k) {
      const Eigen::Map<const MatrixXd> field(vectors.col(k).data(), 3, vectors.rows() / 3);
      const Index first = largest(field);
      if (first == kNoIndex || full()) return;
      add(first);
      const Index second = most_opposed(field, first);
      if (second != kNoIndex && !full()) add(second);
    }
  }

  // Ends a round: computes the residuals of the poses, reconstructed from the key points chosen so far.
  void end_round() {
    const MatrixXd inverse = least_squares(rows_of(subspace_.basis, chosen_.vertices),
                                           nearest_counts(subspace_.mean, chosen_.vertices))
                                 .inverse;
    MatrixXd at_keys(inverse.cols(), residual_.cols());
    const VectorXd mean_at_keys = rows_of(subspace_.mean, chosen_.vertices);
    for (Eigen::Index k = 0; k < at_keys.cols(); ++k)
      at_keys.col(k) = rows_of(pose(k), chosen_.vertices) - mean_at_keys;
    const MatrixXd p = inverse * at_keys;
    double squared_norm = 0;
    const Eigen::Index step = block_rows(p.cols());
    for (Eigen::Index first = 0; first < residual_.rows(); first += step) {
      const Eigen::Index rows = std::min(step, residual_.rows() - first);
      const MatrixXd reconstructed = tall_skinny_product(subspace_.basis.middleRows(first, rows), p);
      for (Eigen::Index k = 0; k < p.cols(); ++k) {
        auto residual = residual_.col(k).segment(first, rows);
        residual = pose(k).segment(first, rows) - subspace_.mean.segment(first, rows);
        squared_norm += residual.squaredNorm();
        residual -= reconstructed.col(k);
      }
    }
    pose_norm_ = std::sqrt(squared_norm);
    const double vertices = static_cast<double>(residual_.size()) / 3;
    chosen_.errors.push_back(std::sqrt(residual_.squaredNorm() / vertices));
    chosen_.round_ends.push_back(static_cast<Index>(chosen_.vertices.size()));
  }

  // Basis vectors of the residuals; none when they are only rounding.
  Result<MatrixXd> residual_basis() const {
    if (residual_.norm() <= 1e-7 * pose_norm_) return MatrixXd(residual_.rows(), 0);
    const Index max_modes = residual_.cols() > kMaxModesPerRound ? kMaxModesPerRound : 0;
    const Pca modes = FOLDPROOF_TRY(pca(residual_, {max_modes, 1.0}));
    Eigen::Index kept = 0;
    while (kept < modes.basis.cols() && (kept == 0 || modes.energy[kept - 1] < kResidualEnergy)) ++kept;
    return MatrixXd(modes.basis.leftCols(kept));
  }

  // Whether none of the last `patience` rounds improved on all before them.
  bool stalled(Index patience) const {
    const auto& errors = chosen_.errors;
    if (patience == 0 || errors.size() <= patience) return false;
    const auto recent = errors.end() - patience;
    return *std::min_element(recent, errors.end()) >
           (1 - kMinGain) * *std::min_element(errors.begin(), recent);
  }

  void discard_rounds_after_best() {
    const auto best = std::min_element(chosen_.errors.begin(), chosen_.errors.end()) - chosen_.errors.begin();
    chosen_.errors.resize(best + 1);
    chosen_.round_ends.resize(best + 1);
    chosen_.vertices.resize(chosen_.round_ends.back());
  }

  bool full() const { return chosen_.vertices.size() >= budget_; }
  const KeyPoints& chosen() const { return chosen_; }
  KeyPoints release() { return std::move(chosen_); }

 private:
  VectorView pose(Eigen::Index k) const { return samples_.col(k * samples_.cols() / residual_.cols()); }

  // Eq. 6, among the vertices that are not key points yet; none when the field is 0 on all of them.
  Index largest(const Eigen::Map<const MatrixXd>& field) const {
    Index best = kNoIndex;
    double max_squared = 0;
    for (Index v = 0; v < is_chosen_.size(); ++v) {
      const double squared = field.col(v).squaredNorm();
      if (!is_chosen_[v] && squared > max_squared) best = v, max_squared = squared;
    }
    return best;
  }

  // Eq. 7; none when no vertex moves against `first`.
  Index most_opposed(const Eigen::Map<const MatrixXd>& field, Index first) const {
    Index best = kNoIndex;
    double min_product = 0;
    for (Index v = 0; v < is_chosen_.size(); ++v) {
      const double product = field.col(v).dot(field.col(first));
      if (!is_chosen_[v] && product < min_product) best = v, min_product = product;
    }
    return best;
  }

  const Pca& subspace_;
  const MatrixView& samples_;
  MatrixXd residual_;
  double pose_norm_ = 0;  // of all poses, without the mean
  std::size_t budget_;
  std::vector<char> is_chosen_;  // per vertex
  KeyPoints chosen_;
};

bool is_share(double value) { return value > 0 && value <= 1; }

Result<void> check(std::span<const double> positions, const MatrixView& samples, const Pca& subspace,
                   const KeyPointSettings& settings) {
  if (!is_share(settings.first_share) || !is_share(settings.max_share) ||
      settings.first_share > settings.max_share) {
    return fail(ErrorCode::InvalidArgument, "key points",
                fmt::format("{} and {} are not shares of the vertices, the smaller first",
                            settings.first_share, settings.max_share),
                "give numbers above 0 and at most 1");
  }
  if (!(settings.tolerance >= 0)) {
    return fail(ErrorCode::InvalidArgument, "tolerance", "is negative or not a number", "give 0 or more");
  }
  const auto size = static_cast<Eigen::Index>(positions.size());
  if (size == 0 || size % 3 != 0 || samples.rows() != size || subspace.mean.size() != size ||
      subspace.basis.rows() != size) {
    return fail(ErrorCode::InvalidArgument, "key points",
                fmt::format("{} numbers in the pose, {} in a sample, {} in the subspace", size,
                            samples.rows(), subspace.mean.size()),
                "give all for the same vertices");
  }
  if (!std::all_of(positions.begin(), positions.end(), [](double x) { return std::isfinite(x); })) {
    return fail(ErrorCode::NonFinite, "pose", "a number is not finite", "give another pose");
  }
  return check_columns(samples, "sample");
}

}  // namespace

Result<KeyPoints> choose_key_points(std::span<const double> positions, const MatrixView& samples,
                                    const Pca& subspace, const KeyPointSettings& settings) {
  FOLDPROOF_TRY(check(positions, samples, subspace, settings));
  const Eigen::Map<const MatrixXd> points(positions.data(), 3,
                                          static_cast<Eigen::Index>(positions.size() / 3));
  const double vertices = static_cast<double>(points.cols());
  const double size = (points.rowwise().maxCoeff() - points.rowwise().minCoeff()).maxCoeff();
  const auto count = [&](double share) { return std::max<Index>(1, static_cast<Index>(share * vertices)); };

  Chooser chooser(samples, subspace, count(settings.max_share));
  for (const Index v : poisson_disk_sample(positions, count(settings.first_share))) chooser.add(v);
  chooser.end_round();
  const auto done = [&] {
    return chooser.full() || chooser.chosen().errors.back() <= settings.tolerance * size ||
           chooser.stalled(settings.patience);
  };
  for (Index round = 0; round < settings.max_rounds && !done(); ++round) {
    const std::size_t before = chooser.chosen().vertices.size();
    if (round == 0) {
      chooser.add_for(subspace.basis);
    } else {
      chooser.add_for(FOLDPROOF_TRY(chooser.residual_basis()));
    }
    if (chooser.chosen().vertices.size() == before) {
      if (round > 0) break;
      continue;
    }
    chooser.end_round();
  }
  if (settings.patience > 0) chooser.discard_rounds_after_best();
  return chooser.release();
}

}  // namespace foldproof::internal
