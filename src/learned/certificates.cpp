#include "learned/certificates.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <optional>

#include "base/try.h"
#include "statistics/thin_svd.h"
#include "statistics/training.h"

namespace foldproof {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Eigen::Index kFolds = 8;
// Of the CCA. With few poses everything correlates, so strong regularization is among them.
constexpr double kRidges[] = {0.01, 0.1, 1, 10};
// Poses of either class that a threshold needs.
constexpr Eigen::Index kMinPerClass = 3;

/// The poses that a fold of the cross-validation holds out. They are consecutive, because neighboring frames
/// of a motion nearly repeat each other.
struct Fold {
  Eigen::Index begin, end;
};

Fold fold_at(Eigen::Index k, Eigen::Index folds, Eigen::Index poses) {
  return {k * poses / folds, (k + 1) * poses / folds};
}

MatrixXd without(const MatrixXd& all, const Fold& fold) {
  MatrixXd rest(all.rows(), all.cols() - (fold.end - fold.begin));
  rest << all.leftCols(fold.begin), all.rightCols(all.cols() - fold.end);
  return rest;
}

/// Per node and pose, predictions from the other folds.
struct CrossValidation {
  double ridge = 0;
  MatrixXd predicted;  // margins
  MatrixXd majority;   // 1: proven in most of the other folds' poses
};

/// With the ridge of least error.
Result<CrossValidation> cross_validate(const MatrixXd& keys, const MatrixXd& margins) {
  for (const MatrixXd* samples : {&keys, &margins}) {
    FOLDPROOF_TRY(check_columns(*samples, "sample"));
  }
  std::vector<CrossValidation> candidates;
  const MatrixXd unset(margins.rows(), margins.cols());
  for (const double ridge : kRidges) candidates.push_back({ridge, unset, unset});
  const Eigen::Index folds = std::min(kFolds, keys.cols());
  for (Eigen::Index k = 0; k < folds; ++k) {
    const Fold fold = fold_at(k, folds, keys.cols());
    const MatrixXd training = without(margins, fold);
    const ThinSvd of_keys = thin_svd(without(keys, fold), kAllModes);
    const ThinSvd of_margins = thin_svd(training, kAllModes);
    const VectorXd proven_share = (training.array() > 0).cast<double>().rowwise().mean();
    for (CrossValidation& candidate : candidates) {
      const Cca map = cca_of_svds(of_keys, of_margins, static_cast<Index>(training.cols()), candidate.ridge);
      for (Eigen::Index pose = fold.begin; pose < fold.end; ++pose) {
        candidate.predicted.col(pose) = map.predict(keys.col(pose));
        candidate.majority.col(pose) = (proven_share.array() > 0.5).cast<double>();
      }
    }
  }
  return *std::min_element(
      candidates.begin(), candidates.end(), [&](const CrossValidation& a, const CrossValidation& b) {
        return (a.predicted - margins).squaredNorm() < (b.predicted - margins).squaredNorm();
      });
}

/// The LDA threshold between predicted margins of proven and unproven pairs of pose and node, over all poses
/// and these rows. None when there are too few pairs of one class, or the classes are not separable.
std::optional<double> threshold_of(const MatrixXd& predicted, const MatrixXd& margins,
                                   const std::vector<Eigen::Index>& rows) {
  MatrixXd points(1, static_cast<Eigen::Index>(rows.size()) * predicted.cols());
  std::vector<std::uint8_t> proven;
  proven.reserve(static_cast<std::size_t>(points.size()));
  Eigen::Index pair = 0;
  for (const Eigen::Index row : rows) {
    for (Eigen::Index pose = 0; pose < predicted.cols(); ++pose) {
      points(0, pair++) = predicted(row, pose);
      proven.push_back(margins(row, pose) > 0);
    }
  }
  const auto positives = std::count(proven.begin(), proven.end(), 1);
  if (positives < kMinPerClass || points.cols() - positives < kMinPerClass) return std::nullopt;
  const auto found = lda(points, proven);
  if (!found || !(found->direction[0] > 0)) return std::nullopt;
  return found->threshold / found->direction[0];
}

void find_thresholds(const Hierarchy& hierarchy, const MatrixXd& predicted, const MatrixXd& margins,
                     CertificateMap& map) {
  const std::vector<Index> depths = depths_of(hierarchy);
  std::vector<std::vector<Eigen::Index>> levels;
  for (std::size_t k = 0; k < map.nodes.size(); ++k) {
    const Index depth = depths[map.nodes[k]];
    if (levels.size() <= depth) levels.resize(depth + 1);
    levels[depth].push_back(static_cast<Eigen::Index>(k));
  }
  map.thresholds.assign(map.nodes.size(), 0);
  map.sources.assign(map.nodes.size(), CertificateMap::Source::None);
  for (const auto& level : levels) {
    const auto common = threshold_of(predicted, margins, level);
    for (const Eigen::Index row : level) {
      const auto own = threshold_of(predicted, margins, {row});
      const auto k = static_cast<std::size_t>(row);
      if (own) {
        map.thresholds[k] = *own;
        map.sources[k] = CertificateMap::Source::Node;
      } else if (common) {
        map.thresholds[k] = *common;
        map.sources[k] = CertificateMap::Source::Level;
      }
    }
  }
}

/// Counts of a binary classifier, per class.
class Confusion {
 public:
  void add(bool proven, bool predicted) {
    ++pairs_[proven];
    predicted_[proven] += predicted;
  }
  double balanced_accuracy() const {
    if (pairs_[0] == 0 || pairs_[1] == 0) return 1;
    return (share(pairs_[0] - predicted_[0], pairs_[0]) + share(predicted_[1], pairs_[1])) / 2;
  }
  double false_discovery_rate() const { return share(predicted_[0], predicted_[0] + predicted_[1]); }

 private:
  static double share(Index part, Index all) { return all ? static_cast<double>(part) / all : 0; }
  std::array<Index, 2> pairs_{};      // unproven, proven
  std::array<Index, 2> predicted_{};  // as proven, of each
};

/// The false positives ordered by their excess over the threshold; each point keeps 0.8 of those before it.
std::vector<CertificateMap::CalibrationPoint> calibrate(const MatrixXd& predicted, const MatrixXd& margins,
                                                        const std::vector<double>& thresholds) {
  constexpr double kKept = 0.8;
  std::vector<double> excesses;
  for (Eigen::Index node = 0; node < margins.rows(); ++node) {
    for (Eigen::Index pose = 0; pose < margins.cols(); ++pose) {
      const double excess = predicted(node, pose) - thresholds[static_cast<std::size_t>(node)];
      if (excess > 0 && !(margins(node, pose) > 0)) excesses.push_back(excess);
    }
  }
  std::sort(excesses.begin(), excesses.end());
  const auto unproven = static_cast<double>((margins.array() <= 0).count());
  const auto miss_rate = [&](std::size_t misses) {
    return (static_cast<double>(misses) + 1) / (unproven + 1);
  };
  std::vector<CertificateMap::CalibrationPoint> points{{0, miss_rate(excesses.size())}};
  for (std::size_t misses = excesses.size(); misses > 0;) {
    misses = static_cast<std::size_t>(kKept * static_cast<double>(misses));
    points.push_back({excesses[excesses.size() - misses - 1], miss_rate(misses)});
  }
  return points;
}

void evaluate(const CrossValidation& validation, const MatrixXd& margins, CertificateMap& map) {
  Confusion prediction, majority;
  for (Eigen::Index node = 0; node < margins.rows(); ++node) {
    const auto proven = (margins.row(node).array() > 0).eval();
    if (proven.all() || !proven.any()) continue;
    const double threshold = map.thresholds[static_cast<std::size_t>(node)];
    for (Eigen::Index pose = 0; pose < margins.cols(); ++pose) {
      prediction.add(proven[pose], validation.predicted(node, pose) > threshold);
      majority.add(proven[pose], validation.majority(node, pose) > 0);
    }
  }
  map.balanced_accuracy = prediction.balanced_accuracy();
  map.majority_accuracy = majority.balanced_accuracy();
  map.false_discovery_rate = prediction.false_discovery_rate();
  map.calibration = calibrate(validation.predicted, margins, map.thresholds);
}

}  // namespace

VectorXd CertificateMap::align(const VectorView& key_positions) const {
  const Eigen::Map<const Eigen::Matrix3Xd> target(anchor.data(), 3, anchor.size() / 3);
  const Eigen::Map<const Eigen::Matrix3Xd> given(key_positions.data(), 3, key_positions.size() / 3);
  const Eigen::Vector3d to = target.rowwise().mean(), from = given.rowwise().mean();
  const Eigen::Matrix3d moment = (target.colwise() - to) * (given.colwise() - from).transpose();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(moment, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d sign = Eigen::Vector3d::Ones();
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0) sign[2] = -1;
  const Eigen::Matrix3d rotation = svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
  const Eigen::Matrix3Xd aligned = (rotation * (given.colwise() - from)).colwise() + to;
  return Eigen::Map<const VectorXd>(aligned.data(), aligned.size());
}

std::optional<double> CertificateMap::excess_for(double miss_rate) const {
  for (const CalibrationPoint& point : calibration) {
    if (point.miss_rate <= miss_rate) return point.excess;
  }
  return std::nullopt;
}

Result<std::shared_ptr<const CertificateMap>> internal::make_certificate_map(const Hierarchy& hierarchy,
                                                                             const LearnInput& input,
                                                                             const MatrixXd& keys,
                                                                             const VectorXd& anchor) {
  if (input.nodes.empty()) return nullptr;
  CertificateMap map;
  map.nodes = input.nodes;
  map.anchor = anchor;
  MatrixXd aligned(keys.rows(), keys.cols());
  for (Eigen::Index k = 0; k < keys.cols(); ++k) aligned.col(k) = map.align(keys.col(k));
  const auto validation = FOLDPROOF_TRY(cross_validate(aligned, input.margins));
  map.cca = FOLDPROOF_TRY(cca(aligned, input.margins, static_cast<Index>(aligned.cols()), validation.ridge));
  find_thresholds(hierarchy, validation.predicted, input.margins, map);
  evaluate(validation, input.margins, map);
  return std::make_shared<const CertificateMap>(std::move(map));
}

}  // namespace foldproof
