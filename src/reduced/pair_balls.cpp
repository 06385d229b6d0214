#include "reduced/pair_balls.h"

#include <algorithm>

#include "foldproof/eigen.h"
#include "reduced/touch_test.h"

namespace foldproof::internal {
namespace {

// Larger sets of vertices get no plane: it would cost more than it proves. Their children may get one.
constexpr std::size_t kMaxVerticesOfPlane = 100'000;

// A chart numbers its vertices in 16 bits.
constexpr std::size_t kMaxVerticesOfChart = 0xFFF0;

// No bridge joins nodes with more leaves than this between them: a plane does as well.
constexpr Index kMaxHops = 4;

}  // namespace

bool PairBalls::are_neighbors(NodePairIds pair) const {
  const auto nodes = input_.motion.hierarchy()->nodes();
  const auto size = [&](Index node) { return nodes[node].leaf_end - nodes[node].leaf_begin; };
  const auto [large, small] = size(pair[0]) >= size(pair[1]) ? pair : NodePairIds{pair[1], pair[0]};
  for (Index leaf = nodes[small].leaf_begin; leaf < nodes[small].leaf_end; ++leaf) {
    const auto around = input_.slots.neighbors(leaf);
    const auto at = std::lower_bound(around.begin(), around.end(), nodes[large].leaf_begin);
    if (at != around.end() && *at < nodes[large].leaf_end) return true;
  }
  return false;
}

// Breadth-first search from one node over neighboring leaves, not through `to`: their distances in `hops`.
void PairBalls::count_hops(Index from, Index to, std::vector<std::uint8_t>& hops) {
  const auto nodes = input_.motion.hierarchy()->nodes();
  queue_.clear();
  const auto visit = [&](Index leaf, Index hop) {
    if (hops[leaf] != kFar) return;
    hops[leaf] = static_cast<std::uint8_t>(hop);
    queue_.push_back(leaf);
    visited_.push_back(leaf);
  };
  for (Index leaf = nodes[from].leaf_begin; leaf < nodes[from].leaf_end; ++leaf) visit(leaf, 0);
  for (std::size_t i = 0; i < queue_.size(); ++i) {
    const Index leaf = queue_[i], hop = hops[leaf];
    if (hop == kMaxHops) break;
    // Leaves beyond the other node are no bridge.
    if (nodes[to].leaf_begin <= leaf && leaf < nodes[to].leaf_end) continue;
    for (const Index other : input_.slots.neighbors(leaf)) visit(other, hop + 1);
  }
}

// The leaves on paths between two nodes, at most `detour` hops longer than the shortest. False when there are
// none, or too many to be worth a chart.
bool PairBalls::find_bridge(NodePairIds pair, Index detour) {
  const auto nodes = input_.motion.hierarchy()->nodes();
  bridge_.clear();
  visited_.clear();
  count_hops(pair[0], pair[1], hops_a_);
  const std::size_t from_a = visited_.size();
  count_hops(pair[1], pair[0], hops_b_);
  Index shortest = kFar;
  for (Index leaf = nodes[pair[1]].leaf_begin; leaf < nodes[pair[1]].leaf_end; ++leaf)
    shortest = std::min<Index>(shortest, hops_a_[leaf]);
  for (std::size_t i = 0; i < from_a && shortest != kFar; ++i) {
    const Index leaf = visited_[i], a = hops_a_[leaf], b = hops_b_[leaf];
    if (a > 0 && b > 0 && b != kFar && a + b <= shortest + detour) bridge_.push_back(leaf);
  }
  for (const Index leaf : visited_) hops_a_[leaf] = hops_b_[leaf] = kFar;
  const auto size = [&](Index node) { return nodes[node].leaf_end - nodes[node].leaf_begin; };
  return !bridge_.empty() && bridge_.size() <= 8 + 2 * (size(pair[0]) + size(pair[1]));
}

// Reads the patch of both nodes and the bridge. False when it is too large.
bool PairBalls::read(NodePairIds pair) {
  const Hierarchy& h = *input_.motion.hierarchy();
  std::size_t triangles = 0, vertices = 0;
  const auto count = [&](const Hierarchy::Node& node) {
    const auto &begin = h.leaves()[node.leaf_begin], &end = h.leaves()[node.leaf_end];
    triangles += end.triangles - begin.triangles;
    vertices += end.vertices - begin.vertices;
  };
  count(h.nodes()[pair[0]]);
  if (pair[1] != pair[0]) count(h.nodes()[pair[1]]);
  for (const Index leaf : bridge_) triangles += h.leaves()[leaf + 1].triangles - h.leaves()[leaf].triangles;
  // Tested before reading, as the reader cannot number more vertices than a chart can.
  if (triangles > input_.max_triangles || vertices > kMaxVerticesOfChart) return false;
  reader_.read(input_.slots.of_node(pair[0]), patch_);
  if (pair[1] != pair[0]) {
    const Hierarchy::Node& node = h.nodes()[pair[1]];
    for (Index leaf = node.leaf_begin; leaf < node.leaf_end; ++leaf) reader_.add_leaf(leaf, patch_);
  }
  for (const Index leaf : bridge_) reader_.add_leaf(leaf, patch_);
  return patch_.vertices.size() <= kMaxVerticesOfChart;
}

double PairBalls::chart_radius(NodePairIds pair, Index center) {
  if (!read(pair)) return 0;
  const CenterPose& pose = input_.poses[center];
  const Vec3 first = pose.at(patch_.vertices[0]);
  positions_.clear();
  for (const Index v : patch_.vertices) {
    const Vec3 x = pose.at(v) - first;
    positions_.push_back({static_cast<float>(x.x()), static_cast<float>(x.y()), static_cast<float>(x.z())});
  }
  const Vec3 facing = parametrizer_.facing(patch_, positions_);
  if (facing == Vec3::Zero() ||
      parametrizer_.build(patch_, positions_, facing, uv_map_) != ChartOutcome::Made)
    return 0;
  return chart_.radius(input_.motion, pose, patch_, uv_map_, to_eigen(facing).cast<float>(), input_.gap);
}

double PairBalls::radius(NodePairIds pair, Index center, double max_radius) {
  bridge_.clear();
  if (pair[0] == pair[1]) return chart_radius(pair, center);
  double best = radius_by_spheres(input_.nodes, pair[0], pair[1], center, input_.poses[center].p,
                                  input_.motion.deviations(), input_.gap, 1e6);
  if (best >= max_radius) return best;
  if (are_neighbors(pair)) {
    best = std::max(best, chart_radius(pair, center));
  } else {
    const auto nodes = input_.motion.hierarchy()->nodes();
    node_vertices(input_.motion, nodes[pair[0]], vertices_a_);
    node_vertices(input_.motion, nodes[pair[1]], vertices_b_);
    if (vertices_a_.size() + vertices_b_.size() <= kMaxVerticesOfPlane) {
      best = std::max(best, plane_.radius(input_.motion, input_.poses[center], {vertices_a_, vertices_b_},
                                          input_.gap, max_radius));
    }
  }
  for (Index detour = 0; detour < 2 && best < max_radius; ++detour) {
    if (find_bridge(pair, detour)) best = std::max(best, chart_radius(pair, center));
  }
  return best;
}

double PairBalls::feature_radius(NodePairIds pair, Index center, double known, double max_radius) {
  const auto nodes = input_.motion.hierarchy()->nodes();
  const std::array<Index, 2> leaves{nodes[pair[0]].leaf_begin, nodes[pair[1]].leaf_begin};
  // An edge may pierce a face without meeting its corners or edges (R7). Features alone would miss that.
  const TouchTest test(*input_.motion.hierarchy(), input_.poses[center]);
  if (test.leaves_touch(leaves[0], leaves[1])) return 0;
  return features_.radius(input_.motion, input_.poses[center], leaves, input_.gap, known, max_radius);
}

}  // namespace foldproof::internal
