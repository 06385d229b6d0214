#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/try.h"
#include "keypoints/choose.h"
#include "keypoints/least_squares.h"
#include "keypoints/leave_one_out.h"
#include "learned/certificates.h"
#include "statistics/tall_skinny.h"
#include "statistics/training.h"

namespace foldproof {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// No more than a person can look through.
constexpr std::size_t kMaxRegions = 64;

class Learner {
 public:
  Learner(const Hierarchy& hierarchy, const LearnInput& input, const LearnSettings& settings,
          const LearnHooks& hooks)
      : hierarchy_(hierarchy), input_(input), settings_(settings), hooks_(hooks) {}

  Result<Learned> run() {
    learned_.settings = settings_;
    const auto steps = {&Learner::find_subspace,
                        &Learner::find_kernel,
                        &Learner::find_key_points,
                        &Learner::find_clusters,
                        &Learner::find_certificates,
                        &Learner::find_errors,
                        &Learner::find_leave_one_out_errors};
    std::size_t done = 0;
    for (const auto step : steps) {
      if (hooks_.cancel && hooks_.cancel->load(std::memory_order_relaxed)) {
        return fail(ErrorCode::Interrupted, "training", "was stopped", "there is no model");
      }
      FOLDPROOF_TRY((this->*step)());
      if (hooks_.progress) {
        hooks_.progress(static_cast<double>(++done) / static_cast<double>(steps.size()));
      }
    }
    return std::move(learned_);
  }

 private:
  Result<void> find_subspace() {
    const auto first = input_.samples.col(0);
    for (int axis = 0; axis < 3; ++axis) {
      const auto along =
          Eigen::Map<const VectorXd, 0, Eigen::InnerStride<3>>(first.data() + axis, first.size() / 3);
      learned_.size = std::max(learned_.size, along.maxCoeff() - along.minCoeff());
    }
    FOLDPROOF_TRY(check_columns(input_.samples, "sample"));
    FOLDPROOF_TRY(check_size(settings_.size));
    svd_ = thin_svd(input_.samples, kAllModes);
    learned_.pca = to_pca(truncate(svd_, settings_.size));
    if (learned_.pca.modes() == 0) {
      return fail(ErrorCode::NotLearned, "poses", "are all the same, so there is nothing to learn from them",
                  "give poses that differ, or train without learning");
    }
    learned_.coordinates = project_all(learned_.pca, input_.samples);
    return {};
  }

  Result<void> find_kernel() {
    if (settings_.subspace != SubspaceKind::KernelPca) return {};
    learned_.kernel = FOLDPROOF_TRY(kernel_pca(input_.samples, settings_.size));
    return {};
  }

  Result<void> find_key_points() {
    const std::span first(input_.samples.data(), static_cast<std::size_t>(input_.samples.rows()));
    learned_.key_points =
        FOLDPROOF_TRY(choose_key_points(first, input_.samples, learned_.pca, settings_.key_points));
    return {};
  }

  Result<void> find_clusters() {
    learned_.clusters =
        FOLDPROOF_TRY(cluster(learned_.coordinates, std::max<Index>(settings_.max_clusters, 1)));
    return {};
  }

  Result<void> find_certificates() {
    const KeyPointMap map(learned_.pca, learned_.key_points.vertices);
    const VectorXd anchor = map.gather(learned_.pca.mean);
    MatrixXd keys(anchor.size(), input_.samples.cols());
    for (Eigen::Index k = 0; k < keys.cols(); ++k) keys.col(k) = map.gather(input_.samples.col(k));
    learned_.certificates = FOLDPROOF_TRY(make_certificate_map(hierarchy_, input_, keys, anchor));
    return {};
  }

  Result<void> find_errors() {
    for (const Index pose : input_.poses) learned_.poses.push_back({pose, {}, {}});
    const KeyPointMap map(learned_.pca, learned_.key_points.vertices);
    MatrixXd from_keys(learned_.coordinates.rows(), learned_.coordinates.cols());
    for (Eigen::Index k = 0; k < from_keys.cols(); ++k) {
      from_keys.col(k) = map.coordinates(map.gather(input_.samples.col(k)));
    }
    if (learned_.kernel) {
      // Not an owner: learned_ outlives the predictor.
      const Predictor predictor(std::shared_ptr<const Learned>(std::shared_ptr<void>(), &learned_));
      for (std::size_t k = 0; k < learned_.poses.size(); ++k)
        learned_.poses[k].trained = predictor.error(input_.samples.col(static_cast<Eigen::Index>(k)));
      return {};
    }
    const MatrixXd cueing = learned_.coordinates - from_keys;
    std::vector<PoseErrorSum> errors(learned_.poses.size());
    const Eigen::Index step = 3 * block_rows(6 * input_.samples.cols());
    for (Eigen::Index first = 0; first < input_.samples.rows(); first += step) {
      const Eigen::Index rows = std::min(step, input_.samples.rows() - first);
      const auto basis = learned_.pca.basis.middleRows(first, rows);
      const MatrixXd best = tall_skinny_product(basis, learned_.coordinates);
      const MatrixXd added = tall_skinny_product(basis, cueing);
      const auto mean = learned_.pca.mean.segment(first, rows);
      for (std::size_t k = 0; k < errors.size(); ++k) {
        const auto pose = static_cast<Eigen::Index>(k);
        const VectorXd projection = input_.samples.col(pose).segment(first, rows) - mean - best.col(pose);
        errors[k].add(static_cast<Index>(first / 3), projection, added.col(pose));
      }
    }
    for (std::size_t k = 0; k < errors.size(); ++k) learned_.poses[k].trained = errors[k].result();
    return {};
  }

  /// Nodes that partition the mesh: those of one level, and the leaves above it.
  std::vector<Index> region_nodes() const {
    const auto nodes = hierarchy_.nodes();
    std::vector<Index> regions{0}, below;
    while (true) {
      below.clear();
      for (const Index n : regions) {
        if (nodes[n].is_leaf()) {
          below.push_back(n);
        } else {
          below.insert(below.end(), {n + 1, nodes[n].right});
        }
      }
      if (below.size() > kMaxRegions || below.size() == regions.size()) return regions;
      regions.swap(below);
    }
  }

  Result<void> find_leave_one_out_errors() {
    std::vector<Index> region_of(hierarchy_.topology().vertex_count(), kNoIndex);
    std::vector<Index> vertex_counts;  // per region
    for (const Index node : region_nodes()) {
      const Hierarchy::Node& n = hierarchy_.nodes()[node];
      const Index begin = hierarchy_.leaves()[n.leaf_begin].vertices,
                  end = hierarchy_.leaves()[n.leaf_end].vertices;
      for (const Index v : hierarchy_.vertex_ids().subspan(begin, end - begin)) {
        region_of[v] = static_cast<Index>(learned_.regions.size());
      }
      learned_.regions.push_back({.node = node});
      vertex_counts.push_back(end - begin);
    }
    const auto add_to_regions = [&](Eigen::Index pose, Index first, const VectorView& distances) {
      for (Index k = 0; k < distances.size(); ++k) {
        if (region_of[first + k] == kNoIndex) continue;
        LearnedRegion& region = learned_.regions[region_of[first + k]];
        region.mean += distances[k];
        if (distances[k] < region.worst || (distances[k] == region.worst && region.worst > 0)) continue;
        region.worst = distances[k];
        region.worst_vertex = first + k;
        region.worst_pose = input_.poses[static_cast<std::size_t>(pose)];
      }
    };
    const auto errors =
        leave_one_out(input_.samples, svd_, settings_.size, learned_.key_points.vertices, add_to_regions);
    for (std::size_t k = 0; k < errors.size(); ++k) learned_.poses[k].leave_one_out = errors[k];
    for (std::size_t k = 0; k < vertex_counts.size(); ++k) {
      if (vertex_counts[k] == 0) continue;
      learned_.regions[k].mean /= static_cast<double>(vertex_counts[k]) * static_cast<double>(errors.size());
    }
    return {};
  }

  const Hierarchy& hierarchy_;
  const LearnInput& input_;
  const LearnSettings& settings_;
  const LearnHooks& hooks_;
  ThinSvd svd_;  // of the samples, all modes
  Learned learned_;
};

std::vector<Index> far_above_median(const std::vector<double>& distances) {
  if (distances.empty()) return {};
  std::vector<double> sorted = distances;
  std::ranges::sort(sorted);
  const double twice_median = sorted[(sorted.size() - 1) / 2] + sorted[sorted.size() / 2];
  std::vector<Index> far;
  for (Index k = 0; k < distances.size(); ++k) {
    if (distances[k] > twice_median) far.push_back(k);
  }
  std::stable_sort(far.begin(), far.end(), [&](Index a, Index b) { return distances[a] > distances[b]; });
  return far;
}

}  // namespace

std::vector<Index> badly_represented_poses(const Learned& learned) {
  std::vector<double> distances;
  for (const LearnedPose& pose : learned.poses) distances.push_back(pose.leave_one_out.projection.mean);
  return far_above_median(distances);
}

std::vector<Index> badly_represented_regions(const Learned& learned) {
  std::vector<double> distances;
  for (const LearnedRegion& region : learned.regions) distances.push_back(region.mean);
  return far_above_median(distances);
}

Result<Learned> internal::learn(const Hierarchy& hierarchy, const LearnInput& input,
                                const LearnSettings& settings, const LearnHooks& hooks) {
  if (input.poses.size() < 3) {
    return fail(ErrorCode::NotLearned, "poses",
                fmt::format("are {}, too few to learn from", input.poses.size()),
                "give at least 3, or train without learning");
  }
  return Learner(hierarchy, input, settings, hooks).run();
}

}  // namespace foldproof
