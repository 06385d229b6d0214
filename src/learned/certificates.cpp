#include "learned/certificates.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <optional>

#include "statistics/span.h"

namespace foldproof {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Predictions of poses that the map has not seen come from so many trials, each without some poses.
constexpr Eigen::Index kTrials = 8;
// Of the margins' map: with few poses hardly anything is certain, so much has to be smoothed.
constexpr double kRidges[] = {0.01, 0.1, 1, 10};
// So many poses of either kind a node needs for a threshold of its own.
constexpr Eigen::Index kOfEachKind = 3;

/// Poses that stay out of a trial: consecutive ones, as neighbours in a motion all but repeat each other.
struct Trial {
  Eigen::Index begin, end;
};

Trial trial_of(Eigen::Index k, Eigen::Index trials, Eigen::Index poses) {
  return {k * poses / trials, (k + 1) * poses / trials};
}

MatrixXd without(const MatrixXd& all, const Trial& trial) {
  MatrixXd rest(all.rows(), all.cols() - (trial.end - trial.begin));
  rest << all.leftCols(trial.begin), all.rightCols(all.cols() - trial.end);
  return rest;
}

/// Predictions for every pose from poses that are not beside it, with the ridge that makes them best, and
/// what each node does more often in those other poses.
struct Unseen {
  double ridge = 0;
  MatrixXd predicted;
  MatrixXd usual;  // 1: proven more often than not
};

Result<Unseen> predict_unseen(const MatrixXd& keys, const MatrixXd& margins) {
  for (const MatrixXd* samples : {&keys, &margins}) {
    if (auto checked = check_columns(*samples, "sample"); !checked) return tl::unexpected(checked.error());
  }
  std::vector<Unseen> tried;
  const MatrixXd room(margins.rows(), margins.cols());
  for (const double ridge : kRidges) tried.push_back({ridge, room, room});
  const Eigen::Index trials = std::min(kTrials, keys.cols());
  for (Eigen::Index k = 0; k < trials; ++k) {
    const Trial trial = trial_of(k, trials, keys.cols());
    const MatrixXd seen = without(margins, trial);
    const Span of_keys = span_of(without(keys, trial), kAllModes), of_margins = span_of(seen, kAllModes);
    const VectorXd often = (seen.array() > 0).cast<double>().rowwise().mean();
    for (Unseen& unseen : tried) {
      const Cca map = cca_of_spans(of_keys, of_margins, static_cast<Index>(seen.cols()), unseen.ridge);
      for (Eigen::Index pose = trial.begin; pose < trial.end; ++pose) {
        unseen.predicted.col(pose) = map.predict(keys.col(pose));
        unseen.usual.col(pose) = (often.array() > 0.5).cast<double>();
      }
    }
  }
  return *std::min_element(tried.begin(), tried.end(), [&](const Unseen& a, const Unseen& b) {
    return (a.predicted - margins).squaredNorm() < (b.predicted - margins).squaredNorm();
  });
}

/// The cut between predicted margins of proven and of other pairs of pose and node; none when there is none.
std::optional<double> cut(const MatrixXd& predicted, const std::vector<std::uint8_t>& proven,
                          Eigen::Index of_each_kind) {
  const auto yes = std::count(proven.begin(), proven.end(), 1);
  if (yes < of_each_kind || predicted.cols() - yes < of_each_kind) return std::nullopt;
  const auto found = lda(predicted, proven);
  if (!found || !(found->direction[0] > 0)) return std::nullopt;
  return found->threshold / found->direction[0];
}

/// All pairs of pose and node of the nodes that `wanted` names, in one row.
std::optional<double> cut_of(const MatrixXd& predicted, const MatrixXd& margins,
                             const std::vector<Eigen::Index>& wanted, Eigen::Index of_each_kind) {
  MatrixXd row(1, static_cast<Eigen::Index>(wanted.size()) * predicted.cols());
  std::vector<std::uint8_t> proven;
  proven.reserve(static_cast<std::size_t>(row.size()));
  Eigen::Index at = 0;
  for (const Eigen::Index node : wanted) {
    for (Eigen::Index pose = 0; pose < predicted.cols(); ++pose) {
      row(0, at++) = predicted(node, pose);
      proven.push_back(margins(node, pose) > 0);
    }
  }
  return cut(row, proven, of_each_kind);
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
    const auto common = cut_of(predicted, margins, level, kOfEachKind);
    for (const Eigen::Index k : level) {
      const auto own = cut_of(predicted, margins, {k}, kOfEachKind);
      const auto at = static_cast<std::size_t>(k);
      if (own) {
        map.thresholds[at] = *own;
        map.sources[at] = CertificateMap::Source::Node;
      } else if (common) {
        map.thresholds[at] = *common;
        map.sources[at] = CertificateMap::Source::Level;
      }
    }
  }
}

/// How often answers are right, proven pairs and others counting alike.
class Tally {
 public:
  void add(bool proven, bool expected) {
    ++pairs_[proven];
    right_[proven] += proven == expected;
    wrongly_ += expected && !proven;
    taken_ += expected;
  }
  double right() const {
    if (pairs_[0] == 0 || pairs_[1] == 0) return 1;
    return (share(right_[0], pairs_[0]) + share(right_[1], pairs_[1])) / 2;
  }
  double believed() const { return share(wrongly_, taken_); }

 private:
  static double share(Index part, Index all) { return all ? static_cast<double>(part) / all : 0; }
  std::array<Index, 2> pairs_{}, right_{};
  Index wrongly_ = 0, taken_ = 0;
};

/// Excesses at which ever fewer of the unproven pairs are taken for proven.
std::vector<CertificateMap::Trust> trust_of(const Unseen& unseen, const MatrixXd& margins,
                                            const std::vector<double>& thresholds) {
  constexpr double kFewer = 0.8;
  std::vector<double> wrong;  // how far unproven pairs were above their thresholds
  for (Eigen::Index node = 0; node < margins.rows(); ++node) {
    for (Eigen::Index pose = 0; pose < margins.cols(); ++pose) {
      const double excess = unseen.predicted(node, pose) - thresholds[static_cast<std::size_t>(node)];
      if (excess > 0 && !(margins(node, pose) > 0)) wrong.push_back(excess);
    }
  }
  std::sort(wrong.begin(), wrong.end());
  const auto unproven = static_cast<double>((margins.array() <= 0).count());
  const auto missed_by = [&](std::size_t count) { return (static_cast<double>(count) + 1) / (unproven + 1); };
  std::vector<CertificateMap::Trust> trust{{0, missed_by(wrong.size())}};
  for (std::size_t left = wrong.size(); left > 0;) {
    left = static_cast<std::size_t>(kFewer * static_cast<double>(left));
    trust.push_back({wrong[wrong.size() - left - 1], missed_by(left)});
  }
  return trust;
}

void judge(const Unseen& unseen, const MatrixXd& margins, CertificateMap& map) {
  Tally told, usual;
  for (Eigen::Index node = 0; node < margins.rows(); ++node) {
    const auto proven = (margins.row(node).array() > 0).eval();
    if (proven.all() || !proven.any()) continue;
    for (Eigen::Index pose = 0; pose < margins.cols(); ++pose) {
      told.add(proven[pose], unseen.predicted(node, pose) > map.thresholds[static_cast<std::size_t>(node)]);
      usual.add(proven[pose], unseen.usual(node, pose) > 0);
    }
  }
  map.right = told.right();
  map.guessed = usual.right();
  map.believed = told.believed();
  map.trust = trust_of(unseen, margins, map.thresholds);
}

}  // namespace

VectorXd CertificateMap::place(const VectorView& key_positions) const {
  const Eigen::Map<const Eigen::Matrix3Xd> target(anchor.data(), 3, anchor.size() / 3);
  const Eigen::Map<const Eigen::Matrix3Xd> given(key_positions.data(), 3, key_positions.size() / 3);
  const Vec3 to = target.rowwise().mean(), from = given.rowwise().mean();
  const Eigen::Matrix3d moment = (target.colwise() - to) * (given.colwise() - from).transpose();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(moment, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Vec3 sign = Vec3::Ones();
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0) sign[2] = -1;
  const Eigen::Matrix3d turn = svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
  const Eigen::Matrix3Xd placed = (turn * (given.colwise() - from)).colwise() + to;
  return Eigen::Map<const VectorXd>(placed.data(), placed.size());
}

std::optional<double> CertificateMap::excess_for(double miss_rate) const {
  for (const Trust& t : trust) {
    if (t.missed <= miss_rate) return t.excess;
  }
  return std::nullopt;
}

Result<std::shared_ptr<const CertificateMap>> make_certificate_map(const Hierarchy& hierarchy,
                                                                   const LearnInput& input,
                                                                   const MatrixXd& keys,
                                                                   const VectorXd& anchor) {
  if (input.nodes.empty()) return nullptr;
  CertificateMap map;
  map.nodes = input.nodes;
  map.anchor = anchor;
  MatrixXd placed(keys.rows(), keys.cols());
  for (Eigen::Index k = 0; k < keys.cols(); ++k) placed.col(k) = map.place(keys.col(k));
  const auto unseen = predict_unseen(placed, input.margins);
  if (!unseen) return tl::unexpected(unseen.error());
  auto made = cca(placed, input.margins, static_cast<Index>(placed.cols()), unseen->ridge);
  if (!made) return tl::unexpected(made.error());
  map.cca = std::move(*made);
  find_thresholds(hierarchy, unseen->predicted, input.margins, map);
  judge(*unseen, input.margins, map);
  return std::make_shared<const CertificateMap>(std::move(map));
}

}  // namespace foldproof
