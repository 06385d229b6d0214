// Suggests poses to add to the training poses.
#include <fmt/format.h>

#include <algorithm>

#include "base/try.h"
#include "foldproof/learned.h"

namespace foldproof {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// A mode is one-sided when poses go at least this many times as far to one side as to the other.
constexpr double kOneSided = 2;
// Distances below this share of the size are rounding: bases are floats.
constexpr double kDistanceRounding = 1e-6;

std::vector<double> as_positions(const VectorXd& x) { return {x.begin(), x.end()}; }

// Per pose, the shape half way between it and its reconstruction from the other poses.
void add_single_examples(const Learned& learned, std::vector<Suggestion>& out) {
  const MatrixXd& p = learned.coordinates;
  for (Eigen::Index k = 0; k < p.cols(); ++k) {
    MatrixXd others(p.rows(), p.cols() - 1);
    others << p.leftCols(k), p.rightCols(p.cols() - 1 - k);
    const auto rest = pca(others, learned.settings.size);
    if (!rest) continue;
    const VectorXd known = rest->reconstruct(rest->project(p.col(k)));
    const VectorXd half = (known + p.col(k)) / 2;
    const VectorXd pose = learned.pca.reconstruct(half);
    out.push_back({Suggestion::Why::OneExample, learned.poses[static_cast<std::size_t>(k)].pose,
                   vertex_distance(learned.pca.reconstruct(known), pose), 0, as_positions(pose)});
  }
}

void add_other_sides(const Learned& learned, std::vector<Suggestion>& out) {
  for (Eigen::Index k = 0; k < learned.coordinates.rows(); ++k) {
    const double high = learned.coordinates.row(k).maxCoeff(), low = learned.coordinates.row(k).minCoeff();
    // Coordinates have mean 0, so the two ends have different signs.
    const double far = std::abs(high) > std::abs(low) ? high : low, near = far == high ? low : high;
    if (!(std::abs(far) >= kOneSided * std::abs(near))) continue;
    const VectorXd pose = learned.pca.mean - far * learned.pca.basis.col(k);
    const VectorXd known = learned.pca.mean + near * learned.pca.basis.col(k);
    out.push_back({Suggestion::Why::OneSided, static_cast<Index>(k), vertex_distance(known, pose), 0,
                   as_positions(pose)});
  }
}

/// The subspace, extended by directions.
class ExtendedSubspace {
 public:
  explicit ExtendedSubspace(const Pca& pca) : pca_(pca) {}

  /// The part of a pose that is orthogonal to the subspace.
  VectorXd residual(const VectorXd& x) const {
    VectorXd residual = x - pca_.mean;
    // Twice, because the basis is orthonormal only to float precision.
    for (int pass = 0; pass < 2; ++pass) {
      residual -= pca_.basis * (pca_.basis.transpose() * residual);
      if (added_.cols() > 0) residual -= added_ * (added_.transpose() * residual);
    }
    return residual;
  }
  void add(const VectorXd& direction) {
    added_.conservativeResize(direction.size(), added_.cols() + 1);
    added_.col(added_.cols() - 1) = direction.normalized();
  }

 private:
  const Pca& pca_;
  MatrixXd added_;
};

/// The frame farthest from a subspace.
struct FarthestFrame {
  Index frame = 0;
  VertexDistance distance;
  VectorXd x, residual;
  double mean = 0;  // distance of all frames
};

Result<FarthestFrame> find_farthest(const ExtendedSubspace& subspace, Motion& motion,
                                    std::span<const Index> frames, const LearnHooks& hooks) {
  FarthestFrame farthest;
  farthest.distance.mean = -1;
  VectorXd x(3 * Eigen::Index{motion.topology().vertex_count()});
  for (const Index frame : frames) {
    if (hooks.cancel && hooks.cancel->load(std::memory_order_relaxed)) {
      return fail(ErrorCode::Interrupted, "suggesting", "was stopped", "nothing was written");
    }
    const std::span out(x.data(), static_cast<std::size_t>(x.size()));
    FOLDPROOF_TRY(motion.read_frame(frame, out));
    const VectorXd residual = subspace.residual(x);
    const VertexDistance distance = vertex_distance(residual, VectorXd::Zero(residual.size()));
    farthest.mean += distance.mean / static_cast<double>(frames.size());
    if (distance.mean > farthest.distance.mean) {
      farthest = {frame, distance, x, residual, farthest.mean};
    }
  }
  return farthest;
}

}  // namespace

std::vector<Suggestion> suggest_poses(const Learned& learned, Index count) {
  std::vector<Suggestion> all;
  add_single_examples(learned, all);
  add_other_sides(learned, all);
  std::stable_sort(all.begin(), all.end(), [](const Suggestion& a, const Suggestion& b) {
    return a.distance.mean > b.distance.mean;
  });
  std::erase_if(all,
                [&](const Suggestion& s) { return !(s.distance.mean > kDistanceRounding * learned.size); });
  if (all.size() > count) all.erase(all.begin() + count, all.end());
  return all;
}

Result<std::vector<Suggestion>> suggest_frames(const Learned& learned, Motion& motion,
                                               std::span<const Index> frames, Index count,
                                               const LearnHooks& hooks) {
  const Eigen::Index vertices = motion.topology().vertex_count();
  if (3 * vertices != learned.pca.mean.size()) {
    return fail(ErrorCode::InvalidMesh, motion.name(),
                fmt::format("has {} vertices, and the model has {}", vertices, learned.pca.mean.size() / 3),
                "give a motion of the same mesh");
  }
  ExtendedSubspace subspace(learned.pca);
  std::vector<Suggestion> chosen;
  for (Index round = 0; round <= count && !frames.empty(); ++round) {
    const auto farthest = FOLDPROOF_TRY(find_farthest(subspace, motion, frames, hooks));
    if (hooks.progress) hooks.progress((round + 1.0) / (count + 1.0));
    if (!chosen.empty()) chosen.back().mean_after = farthest.mean;
    if (round == count || !(farthest.distance.mean > kDistanceRounding * learned.size)) break;
    subspace.add(farthest.residual);
    chosen.push_back(
        {Suggestion::Why::Frame, farthest.frame, farthest.distance, 0, as_positions(farthest.x)});
  }
  return chosen;
}

}  // namespace foldproof
