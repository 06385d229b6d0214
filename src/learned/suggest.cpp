// Which further pose would teach most.
#include <fmt/format.h>

#include <algorithm>

#include "foldproof/learned.h"

namespace foldproof {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// A mode is one-sided when poses show it this many times as far to one side as to the other.
constexpr double kOneSided = 2;
// What is nearer than this share of the size is rounding: bases are floats.
constexpr double kRounding = 1e-6;

std::vector<double> as_positions(const VectorXd& x) { return {x.begin(), x.end()}; }

// What one pose alone shows, half of it: between the pose and what the others make of it.
void add_single_examples(const Learned& learned, std::vector<Suggestion>& out) {
  const MatrixXd& p = learned.coordinates;
  for (Eigen::Index k = 0; k < p.cols(); ++k) {
    MatrixXd others(p.rows(), p.cols() - 1);
    others << p.leftCols(k), p.rightCols(p.cols() - 1 - k);
    const auto rest = pca(others, learned.settings.size);
    if (!rest) continue;
    const VectorXd known = rest->rebuild(rest->project(p.col(k)));
    const VectorXd half = (known + p.col(k)) / 2;
    const VectorXd pose = learned.pca.rebuild(half);
    out.push_back({Suggestion::Why::OneExample, learned.poses[static_cast<std::size_t>(k)].pose,
                   vertex_distance(learned.pca.rebuild(known), pose), 0, as_positions(pose)});
  }
}

void add_other_sides(const Learned& learned, std::vector<Suggestion>& out) {
  for (Eigen::Index k = 0; k < learned.coordinates.rows(); ++k) {
    const double high = learned.coordinates.row(k).maxCoeff(), low = learned.coordinates.row(k).minCoeff();
    const double far = std::abs(high) > std::abs(low) ? high : low, near = far == high ? low : high;
    // Coordinates have mean 0, so the far and the near end have different signs.
    if (!(std::abs(far) >= kOneSided * std::abs(near))) continue;
    const VectorXd pose = learned.pca.mean - far * learned.pca.basis.col(k);
    const VectorXd known = learned.pca.mean + near * learned.pca.basis.col(k);
    out.push_back({Suggestion::Why::OneSided, static_cast<Index>(k), vertex_distance(known, pose), 0,
                   as_positions(pose)});
  }
}

/// Keeps what is left of a pose when the model, and directions added to it, have told what they can.
class Remainder {
 public:
  explicit Remainder(const Pca& pca) : pca_(pca) {}

  VectorXd of(const VectorXd& x) const {
    VectorXd left = x - pca_.mean;
    // Twice: bases are orthonormal only as far as floats go.
    for (int pass = 0; pass < 2; ++pass) {
      left -= pca_.basis * (pca_.basis.transpose() * left);
      if (added_.cols() > 0) left -= added_ * (added_.transpose() * left);
    }
    return left;
  }
  void add(const VectorXd& direction) {
    added_.conservativeResize(direction.size(), added_.cols() + 1);
    added_.col(added_.cols() - 1) = direction.normalized();
  }

 private:
  const Pca& pca_;
  MatrixXd added_;
};

/// One reading of the motion.
struct Reading {
  Index frame = 0;  // the farthest
  VertexDistance distance;
  VectorXd x, left;
  double mean = 0;  // distance over all frames
};

Result<Reading> read_motion(const Remainder& remainder, Motion& motion, std::span<const Index> frames,
                            const LearnHooks& hooks) {
  Reading farthest;
  farthest.distance.mean = -1;
  VectorXd x(3 * Eigen::Index{motion.topology().vertex_count()});
  for (const Index frame : frames) {
    if (hooks.cancel && hooks.cancel->load(std::memory_order_relaxed)) {
      return fail("suggesting", "was stopped", "nothing was written");
    }
    const std::span out(x.data(), static_cast<std::size_t>(x.size()));
    if (auto read = motion.read_frame(frame, out); !read) return tl::unexpected(read.error());
    const VectorXd left = remainder.of(x);
    const VertexDistance distance = vertex_distance(left, VectorXd::Zero(left.size()));
    farthest.mean += distance.mean / static_cast<double>(frames.size());
    if (distance.mean > farthest.distance.mean) {
      farthest = {frame, distance, x, left, farthest.mean};
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
  std::erase_if(all, [&](const Suggestion& s) { return !(s.distance.mean > kRounding * learned.size); });
  if (all.size() > count) all.erase(all.begin() + count, all.end());
  return all;
}

Result<std::vector<Suggestion>> suggest_frames(const Learned& learned, Motion& motion,
                                               std::span<const Index> frames, Index count,
                                               const LearnHooks& hooks) {
  const Eigen::Index vertices = motion.topology().vertex_count();
  if (3 * vertices != learned.pca.mean.size()) {
    return fail(motion.name(),
                fmt::format("has {} vertices, and the model has {}", vertices, learned.pca.mean.size() / 3),
                "give a motion of the same mesh");
  }
  Remainder remainder(learned.pca);
  std::vector<Suggestion> chosen;
  for (Index round = 0; round <= count && !frames.empty(); ++round) {
    auto reading = read_motion(remainder, motion, frames, hooks);
    if (!reading) return tl::unexpected(reading.error());
    if (hooks.progress) hooks.progress((round + 1.0) / (count + 1.0));
    if (!chosen.empty()) chosen.back().left = reading->mean;
    if (round == count || !(reading->distance.mean > kRounding * learned.size)) break;
    remainder.add(reading->left);
    chosen.push_back(
        {Suggestion::Why::Frame, reading->frame, reading->distance, 0, as_positions(reading->x)});
  }
  return chosen;
}

}  // namespace foldproof
