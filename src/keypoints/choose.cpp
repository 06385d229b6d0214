#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "keypoints/least_squares.h"
#include "statistics/tall.h"

namespace foldproof {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr SubspaceSize kResidualEnergy{0, 0.95};
constexpr SubspaceSize kMostPerRound{16, 1.0};
// Rounds look at no more poses than that, evenly taken, so that the cost of one stays bounded.
constexpr Eigen::Index kMostPoses = 128;
constexpr double kGain = 1e-3;  // Of the error: what a round must gain to count as one.

class Chooser {
 public:
  Chooser(const MatrixView& samples, const Pca& subspace, std::size_t budget)
      : subspace_(subspace),
        samples_(samples),
        residual_(samples.rows(), std::min(samples.cols(), kMostPoses)),
        budget_(budget),
        taken_(samples.rows() / 3, 0) {}

  void add(Index vertex) {
    taken_[vertex] = 1;
    chosen_.vertices.push_back(vertex);
  }

  // Two points for each vector, until the budget is spent.
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

  // Ends a round: what is left of the poses when they are rebuilt from the key points chosen so far.
  void end_round() {
    const MatrixXd inverse = least_squares(rows_of(subspace_.basis, chosen_.vertices),
                                           shares_of_vertices(subspace_.mean, chosen_.vertices))
                                 .inverse;
    MatrixXd at_keys(inverse.cols(), residual_.cols());
    const VectorXd mean_at_keys = rows_of(subspace_.mean, chosen_.vertices);
    for (Eigen::Index k = 0; k < at_keys.cols(); ++k)
      at_keys.col(k) = rows_of(pose(k), chosen_.vertices) - mean_at_keys;
    const MatrixXd p = inverse * at_keys;
    double squared_size = 0;
    const Eigen::Index step = rows_at_a_time(p.cols());
    for (Eigen::Index first = 0; first < residual_.rows(); first += step) {
      const Eigen::Index rows = std::min(step, residual_.rows() - first);
      const MatrixXd rebuilt = tall_product(subspace_.basis.middleRows(first, rows), p);
      for (Eigen::Index k = 0; k < p.cols(); ++k) {
        auto rest = residual_.col(k).segment(first, rows);
        rest = pose(k).segment(first, rows) - subspace_.mean.segment(first, rows);
        squared_size += rest.squaredNorm();
        rest -= rebuilt.col(k);
      }
    }
    size_of_poses_ = std::sqrt(squared_size);
    const double numbers = static_cast<double>(residual_.size()) / 3;
    chosen_.errors.push_back(std::sqrt(residual_.squaredNorm() / numbers));
    chosen_.round_ends.push_back(static_cast<Index>(chosen_.vertices.size()));
  }

  // The basis vectors of what is left; none when it is rounding.
  Result<MatrixXd> residual_basis() const {
    if (residual_.norm() <= 1e-7 * size_of_poses_) return MatrixXd(residual_.rows(), 0);
    auto modes =
        pca(residual_, residual_.cols() > kMostPerRound.modes ? kMostPerRound : SubspaceSize{0, 1.0});
    if (!modes) return tl::unexpected(modes.error());
    Eigen::Index kept = 0;
    while (kept < modes->basis.cols() && (kept == 0 || modes->energy[kept - 1] < kResidualEnergy.energy))
      ++kept;
    return MatrixXd(modes->basis.leftCols(kept));
  }

  // True when none of the last `patience` rounds was better than all before them by more than a thousandth.
  bool stuck(Index patience) const {
    const auto& errors = chosen_.errors;
    if (patience == 0 || errors.size() <= patience) return false;
    const auto recent = errors.end() - patience;
    return *std::min_element(recent, errors.end()) > (1 - kGain) * *std::min_element(errors.begin(), recent);
  }

  // Takes back what came after the round of least error.
  void take_back() {
    const auto best = std::min_element(chosen_.errors.begin(), chosen_.errors.end()) - chosen_.errors.begin();
    chosen_.errors.resize(best + 1);
    chosen_.round_ends.resize(best + 1);
    chosen_.vertices.resize(chosen_.round_ends.back());
  }

  bool full() const { return chosen_.vertices.size() >= budget_; }
  const KeyPoints& chosen() const { return chosen_; }
  KeyPoints take() { return std::move(chosen_); }

 private:
  VectorView pose(Eigen::Index k) const { return samples_.col(k * samples_.cols() / residual_.cols()); }

  // Eq. 6, of the vertices that are not key points yet; none when all are, or the vector is 0 there.
  Index largest(const Eigen::Map<const MatrixXd>& field) const {
    Index best = kNoIndex;
    double most = 0;
    for (Index v = 0; v < taken_.size(); ++v) {
      const double squared = field.col(v).squaredNorm();
      if (!taken_[v] && squared > most) best = v, most = squared;
    }
    return best;
  }

  // Eq. 7; none when nothing moves against `first`.
  Index most_opposed(const Eigen::Map<const MatrixXd>& field, Index first) const {
    Index best = kNoIndex;
    double least = 0;
    for (Index v = 0; v < taken_.size(); ++v) {
      const double product = field.col(v).dot(field.col(first));
      if (!taken_[v] && product < least) best = v, least = product;
    }
    return best;
  }

  const Pca& subspace_;
  const MatrixView& samples_;
  MatrixXd residual_;
  double size_of_poses_ = 0;
  std::size_t budget_;
  std::vector<char> taken_;
  KeyPoints chosen_;
};

bool is_share(double value) { return value > 0 && value <= 1; }

Result<void> check(std::span<const double> positions, const MatrixView& samples, const Pca& subspace,
                   const KeyPointSettings& settings) {
  if (!is_share(settings.first_share) || !is_share(settings.most_share) ||
      settings.first_share > settings.most_share) {
    return fail("key points",
                fmt::format("{} and {} are not shares of the vertices, the smaller first",
                            settings.first_share, settings.most_share),
                "give numbers above 0 and at most 1");
  }
  if (!(settings.tolerance >= 0)) return fail("tolerance", "is negative or not a number", "give 0 or more");
  const auto size = static_cast<Eigen::Index>(positions.size());
  if (size == 0 || size % 3 != 0 || samples.rows() != size || subspace.mean.size() != size ||
      subspace.basis.rows() != size) {
    return fail("key points",
                fmt::format("{} numbers in the pose, {} in a sample, {} in the subspace", size,
                            samples.rows(), subspace.mean.size()),
                "give all for the same vertices");
  }
  if (samples.cols() == 0) return fail("samples", "there are none", "give at least one sample");
  for (Eigen::Index k = 0; k < samples.cols(); ++k) {
    if (!samples.col(k).allFinite()) {
      return fail(fmt::format("sample {}", k), "a number is not finite",
                  "leave this sample out or repair it");
    }
  }
  if (!std::all_of(positions.begin(), positions.end(), [](double x) { return std::isfinite(x); })) {
    return fail("pose", "a number is not finite", "give another pose");
  }
  return {};
}

}  // namespace

Result<KeyPoints> choose_key_points(std::span<const double> positions, const MatrixView& samples,
                                    const Pca& subspace, const KeyPointSettings& settings) {
  if (auto checked = check(positions, samples, subspace, settings); !checked) {
    return tl::unexpected(checked.error());
  }
  const Eigen::Map<const MatrixXd> points(positions.data(), 3,
                                          static_cast<Eigen::Index>(positions.size() / 3));
  const double vertices = static_cast<double>(points.cols());
  const double size = (points.rowwise().maxCoeff() - points.rowwise().minCoeff()).maxCoeff();
  const auto count = [&](double share) { return std::max<Index>(1, static_cast<Index>(share * vertices)); };

  Chooser chooser(samples, subspace, count(settings.most_share));
  for (const Index v : thin_by_radius(positions, count(settings.first_share))) chooser.add(v);
  chooser.end_round();
  const auto done = [&] {
    return chooser.full() || chooser.chosen().errors.back() <= settings.tolerance * size ||
           chooser.stuck(settings.patience);
  };
  for (Index round = 0; round < settings.most_rounds && !done(); ++round) {
    const std::size_t before = chooser.chosen().vertices.size();
    if (round == 0) {
      chooser.add_for(subspace.basis);
    } else {
      auto basis = chooser.residual_basis();
      if (!basis) return tl::unexpected(basis.error());
      chooser.add_for(*basis);
    }
    if (chooser.chosen().vertices.size() == before) {
      if (round > 0) break;
      continue;
    }
    chooser.end_round();
  }
  if (settings.patience > 0) chooser.take_back();
  return chooser.take();
}

}  // namespace foldproof
