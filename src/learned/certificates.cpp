#include "learned/certificates.h"

#include <Eigen/Dense>
#include <algorithm>

namespace foldproof {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Predictions of poses that the map has not seen come from so many trials, each without some poses.
constexpr Eigen::Index kTrials = 8;
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

Result<Cca> fit(const MatrixXd& keys, const MatrixXd& margins) {
  return cca(keys, margins, static_cast<Index>(keys.cols()));
}

/// Predictions for every pose from poses that are not beside it, and how often the more frequent answer of
/// those is right.
struct Unseen {
  MatrixXd predicted;
  double guessed = 0;
};

Result<Unseen> predict_unseen(const MatrixXd& keys, const MatrixXd& margins) {
  Unseen unseen{MatrixXd::Zero(margins.rows(), margins.cols())};
  const Eigen::Index trials = std::min(kTrials, keys.cols());
  Eigen::Index guessed = 0;
  for (Eigen::Index k = 0; k < trials; ++k) {
    const Trial trial = trial_of(k, trials, keys.cols());
    const MatrixXd seen = without(margins, trial);
    const auto map = fit(without(keys, trial), seen);
    if (!map) return tl::unexpected(map.error());
    const VectorXd usual = (seen.array() > 0).cast<double>().rowwise().mean();
    for (Eigen::Index pose = trial.begin; pose < trial.end; ++pose) {
      unseen.predicted.col(pose) = map->predict(keys.col(pose));
      guessed += ((margins.col(pose).array() > 0) == (usual.array() > 0.5)).count();
    }
  }
  unseen.guessed = static_cast<double>(guessed) / static_cast<double>(margins.size());
  return unseen;
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

void judge(const MatrixXd& predicted, const MatrixXd& margins, CertificateMap& map) {
  const Eigen::Map<const VectorXd> cuts(map.thresholds.data(),
                                        static_cast<Eigen::Index>(map.thresholds.size()));
  Eigen::Index right = 0, taken = 0, wrongly = 0;
  for (Eigen::Index pose = 0; pose < margins.cols(); ++pose) {
    const auto proven = (margins.col(pose).array() > 0).eval();
    const auto expected = (predicted.col(pose).array() > cuts.array()).eval();
    right += (proven == expected).count();
    taken += expected.count();
    wrongly += (expected && !proven).count();
  }
  map.right = static_cast<double>(right) / static_cast<double>(margins.size());
  map.believed = taken ? static_cast<double>(wrongly) / static_cast<double>(taken) : 0;
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
  auto made = fit(placed, input.margins);
  if (!made) return tl::unexpected(made.error());
  map.cca = std::move(*made);
  const auto unseen = predict_unseen(placed, input.margins);
  if (!unseen) return tl::unexpected(unseen.error());
  map.guessed = unseen->guessed;
  find_thresholds(hierarchy, unseen->predicted, input.margins, map);
  judge(unseen->predicted, input.margins, map);
  return std::make_shared<const CertificateMap>(std::move(map));
}

}  // namespace foldproof
