#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "learned/certificates.h"

namespace foldproof {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// As many regions as a person may look through.
constexpr std::size_t kRegions = 64;

/// Learning that is under way.
class Learner {
 public:
  Learner(const Hierarchy& hierarchy, const LearnInput& input, const LearnSettings& settings,
          const LearnHooks& hooks)
      : hierarchy_(hierarchy), input_(input), settings_(settings), hooks_(hooks) {}

  Result<Learned> run() {
    learned_.settings = settings_;
    const auto steps = {&Learner::find_subspace, &Learner::find_kernel,       &Learner::find_key_points,
                        &Learner::find_clusters, &Learner::find_certificates, &Learner::find_errors,
                        &Learner::find_regions};
    std::size_t done = 0;
    for (const auto step : steps) {
      if (hooks_.cancel && hooks_.cancel->load(std::memory_order_relaxed)) {
        return fail("training", "was stopped", "there is no model");
      }
      if (auto ok = (this->*step)(); !ok) return tl::unexpected(ok.error());
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
    auto found = pca(input_.samples, settings_.size);
    if (!found) return tl::unexpected(found.error());
    if (found->modes() == 0) {
      return fail("poses", "are all the same, so there is nothing to learn from them",
                  "give poses that differ, or train without learning");
    }
    learned_.pca = std::move(*found);
    learned_.coordinates.resize(learned_.pca.modes(), input_.samples.cols());
    for (Eigen::Index k = 0; k < input_.samples.cols(); ++k) {
      learned_.coordinates.col(k) = learned_.pca.project(input_.samples.col(k));
    }
    return {};
  }

  Result<void> find_kernel() {
    if (settings_.subspace != SubspaceKind::KernelPca) return {};
    auto found = kernel_pca(input_.samples, settings_.size);
    if (!found) return tl::unexpected(found.error());
    learned_.kernel = std::move(*found);
    return {};
  }

  Result<void> find_key_points() {
    const std::span first(input_.samples.data(), static_cast<std::size_t>(input_.samples.rows()));
    auto found = choose_key_points(first, input_.samples, learned_.pca, settings_.key_points);
    if (!found) return tl::unexpected(found.error());
    learned_.key_points = std::move(*found);
    return {};
  }

  Result<void> find_clusters() {
    const auto most = std::min<Index>(settings_.most_clusters, static_cast<Index>(input_.samples.cols()));
    auto found = cluster(learned_.coordinates, std::max<Index>(most, 1));
    if (!found) return tl::unexpected(found.error());
    learned_.clusters = std::move(*found);
    return {};
  }

  Result<void> find_certificates() {
    const KeyPointMap map(learned_.pca, learned_.key_points.vertices);
    const VectorXd anchor = map.gather(learned_.pca.mean);
    MatrixXd keys(anchor.size(), input_.samples.cols());
    for (Eigen::Index k = 0; k < keys.cols(); ++k) keys.col(k) = map.gather(input_.samples.col(k));
    auto found = make_certificate_map(hierarchy_, input_, keys, anchor);
    if (!found) return tl::unexpected(found.error());
    learned_.certificates = std::move(*found);
    return {};
  }

  Result<void> find_errors() {
    const auto left_out = leave_one_out(input_.samples, settings_.size, learned_.key_points.vertices);
    if (!left_out) return tl::unexpected(left_out.error());
    // The predictor reads what has been learned so far, which does not change while it does.
    const Predictor predictor(std::shared_ptr<const Learned>(std::shared_ptr<void>(), &learned_));
    for (std::size_t k = 0; k < input_.poses.size(); ++k) {
      learned_.poses.push_back({input_.poses[k],
                                predictor.error(input_.samples.col(static_cast<Eigen::Index>(k))),
                                (*left_out)[k]});
    }
    return {};
  }

  /// Nodes that make up the mesh: a whole level, or leaves above it.
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
      if (below.size() > kRegions || below.size() == regions.size()) return regions;
      regions.swap(below);
    }
  }

  // What the other poses make of each pose, vertex by vertex. All poses lie in their span, so subspaces of
  // some of them are found in coordinates of the span.
  Result<void> find_regions() {
    const auto span = pca(input_.samples, {.modes = 0, .energy = 1});
    if (!span) return tl::unexpected(span.error());
    const Eigen::Index poses = input_.samples.cols();
    const MatrixXd in_span = span->basis.transpose() * (input_.samples.colwise() - span->mean);
    for (const Index node : region_nodes()) learned_.regions.push_back({.node = node});
    for (Eigen::Index k = 0; k < poses; ++k) {
      MatrixXd others(in_span.rows(), poses - 1);
      others << in_span.leftCols(k), in_span.rightCols(poses - 1 - k);
      const auto rest = pca(others, settings_.size);
      if (!rest) return tl::unexpected(rest.error());
      const VectorXd missed = in_span.col(k) - rest->rebuild(rest->project(in_span.col(k)));
      add_to_regions(span->basis * missed, input_.poses[static_cast<std::size_t>(k)]);
    }
    for (LearnedRegion& region : learned_.regions) region.mean /= static_cast<double>(poses);
    return {};
  }

  void add_to_regions(const VectorXd& missed, Index pose) {
    for (LearnedRegion& region : learned_.regions) {
      const Hierarchy::Node& node = hierarchy_.nodes()[region.node];
      const Index begin = hierarchy_.leaves()[node.leaf_begin].vertices,
                  end = hierarchy_.leaves()[node.leaf_end].vertices;
      double sum = 0;
      for (Index place = begin; place < end; ++place) {
        const Index v = hierarchy_.vertex_ids()[place];
        const double distance = missed.segment<3>(3 * Eigen::Index{v}).norm();
        sum += distance;
        if (distance > region.worst || (place == begin && region.worst == 0)) {
          region.worst = distance;
          region.worst_vertex = v;
          region.worst_pose = pose;
        }
      }
      if (end > begin) region.mean += sum / (end - begin);
    }
  }

  const Hierarchy& hierarchy_;
  const LearnInput& input_;
  const LearnSettings& settings_;
  const LearnHooks& hooks_;
  Learned learned_;
};

std::vector<Index> far_above_median(const std::vector<double>& distances) {
  if (distances.empty()) return {};
  std::vector<double> sorted = distances;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  std::vector<Index> far;
  for (Index k = 0; k < distances.size(); ++k) {
    if (distances[k] > 2 * *middle) far.push_back(k);
  }
  std::stable_sort(far.begin(), far.end(), [&](Index a, Index b) { return distances[a] > distances[b]; });
  return far;
}

}  // namespace

std::vector<Index> badly_represented_poses(const Learned& learned) {
  std::vector<double> distances;
  for (const LearnedPose& pose : learned.poses) distances.push_back(pose.left_out.projection.mean);
  return far_above_median(distances);
}

std::vector<Index> badly_represented_regions(const Learned& learned) {
  std::vector<double> distances;
  for (const LearnedRegion& region : learned.regions) distances.push_back(region.mean);
  return far_above_median(distances);
}

Result<Learned> learn(const Hierarchy& hierarchy, const LearnInput& input, const LearnSettings& settings,
                      const LearnHooks& hooks) {
  if (input.poses.size() < 3) {
    return fail("poses", fmt::format("are {}, too few to learn from", input.poses.size()),
                "give at least 3, or train without learning");
  }
  return Learner(hierarchy, input, settings, hooks).run();
}

}  // namespace foldproof
