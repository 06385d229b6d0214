#include "reduced/pair_balls.h"

#include <algorithm>

#include "reduced/touch_test.h"

namespace foldproof {
namespace {

// Sets of vertices larger than this are left to their children when they need a plane: it costs more than it
// proves.
constexpr std::size_t kMostVerticesOfPlane = 100'000;

// A chart numbers its vertices in 16 bits; a patch has at most three per triangle, and mostly half of one.
constexpr std::size_t kMostVerticesOfChart = 0xFFF0;

// Nodes that are more leaves apart than this are not joined by a bridge: a plane does as well.
constexpr Index kMostHops = 4;

}  // namespace

bool PairBalls::are_neighbours(NodePairIds pair) const {
  const auto nodes = input_.motion.hierarchy()->nodes();
  const auto size = [&](Index node) { return nodes[node].leaf_end - nodes[node].leaf_begin; };
  const auto [large, small] = size(pair[0]) >= size(pair[1]) ? pair : NodePairIds{pair[1], pair[0]};
  for (Index leaf = nodes[small].leaf_begin; leaf < nodes[small].leaf_end; ++leaf) {
    const auto around = input_.slots.neighbours(leaf);
    const auto at = std::lower_bound(around.begin(), around.end(), nodes[large].leaf_begin);
    if (at != around.end() && *at < nodes[large].leaf_end) return true;
  }
  return false;
}

// How many leaves away the leaves around a node are, until `to` is met or `most` hops are done.
void PairBalls::count_hops(Index from, Index to, Index most, std::vector<std::uint8_t>& hops) {
  const auto nodes = input_.motion.hierarchy()->nodes();
  queue_.clear();
  const auto reach = [&](Index leaf, Index hop) {
    if (hops[leaf] != kFar) return;
    hops[leaf] = static_cast<std::uint8_t>(hop);
    queue_.push_back(leaf);
    reached_.push_back(leaf);
  };
  for (Index leaf = nodes[from].leaf_begin; leaf < nodes[from].leaf_end; ++leaf) reach(leaf, 0);
  for (std::size_t i = 0; i < queue_.size(); ++i) {
    const Index leaf = queue_[i], hop = hops[leaf];
    if (hop == most) break;
    // What lies behind the other node is no bridge.
    if (nodes[to].leaf_begin <= leaf && leaf < nodes[to].leaf_end) continue;
    for (const Index other : input_.slots.neighbours(leaf)) reach(other, hop + 1);
  }
}

// The leaves on ways between two nodes that are at most `slack` hops longer than the shortest. False when
// there are none, or too many to be worth it.
bool PairBalls::find_bridge(NodePairIds pair, Index slack) {
  const auto nodes = input_.motion.hierarchy()->nodes();
  bridge_.clear();
  reached_.clear();
  count_hops(pair[0], pair[1], kMostHops, hops_a_);
  const std::size_t from_a = reached_.size();
  count_hops(pair[1], pair[0], kMostHops, hops_b_);
  Index shortest = kFar;
  for (Index leaf = nodes[pair[1]].leaf_begin; leaf < nodes[pair[1]].leaf_end; ++leaf)
    shortest = std::min<Index>(shortest, hops_a_[leaf]);
  for (std::size_t i = 0; i < from_a && shortest != kFar; ++i) {
    const Index leaf = reached_[i], a = hops_a_[leaf], b = hops_b_[leaf];
    if (a > 0 && b > 0 && b != kFar && a + b <= shortest + slack) bridge_.push_back(leaf);
  }
  for (const Index leaf : reached_) hops_a_[leaf] = hops_b_[leaf] = kFar;
  const auto size = [&](Index node) { return nodes[node].leaf_end - nodes[node].leaf_begin; };
  return !bridge_.empty() && bridge_.size() <= 8 + 2 * (size(pair[0]) + size(pair[1]));
}

// The patch of both nodes and the bridge. False when it is too large.
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
  triangles += bridge_.size() * (h.triangles().size() / h.leaf_count());
  // Vertices on the rim belong to others; the reader cannot number more than a chart holds.
  if (triangles > input_.most_triangles || vertices > kMostVerticesOfChart) return false;
  reader_.read(input_.slots.of_node(pair[0]), patch_);
  if (pair[1] != pair[0]) {
    const Hierarchy::Node& node = h.nodes()[pair[1]];
    for (Index leaf = node.leaf_begin; leaf < node.leaf_end; ++leaf) reader_.add_leaf(leaf, patch_);
  }
  for (const Index leaf : bridge_) reader_.add_leaf(leaf, patch_);
  return patch_.vertices.size() <= kMostVerticesOfChart;
}

double PairBalls::chart_radius(NodePairIds pair, Index centre) {
  if (!read(pair)) return 0;
  const CentrePose& pose = input_.poses[centre];
  const Vec3 first = pose.at(patch_.vertices[0]);
  positions_.clear();
  for (const Index v : patch_.vertices) {
    const Eigen::Vector3f x = (pose.at(v) - first).cast<float>();
    positions_.push_back({x.x(), x.y(), x.z()});
  }
  const Eigen::Vector3f facing = maker_.facing(patch_, positions_);
  if (facing.isZero() || maker_.draw(patch_, positions_, facing, drawing_) != ChartOutcome::Made) return 0;
  return chart_.radius(input_.motion, pose, patch_, drawing_, facing, input_.gap);
}

double PairBalls::radius(NodePairIds pair, Index centre, double enough) {
  bridge_.clear();
  if (pair[0] == pair[1]) return chart_radius(pair, centre);
  double best = balls_apart_radius(input_.nodes, pair[0], pair[1], centre, input_.poses[centre].p,
                                   input_.motion.deviations(), input_.gap, 1e6);
  if (best >= enough) return best;
  if (are_neighbours(pair)) {
    best = std::max(best, chart_radius(pair, centre));
  } else {
    const auto nodes = input_.motion.hierarchy()->nodes();
    node_vertices(input_.motion, nodes[pair[0]], vertices_a_);
    node_vertices(input_.motion, nodes[pair[1]], vertices_b_);
    if (vertices_a_.size() + vertices_b_.size() <= kMostVerticesOfPlane) {
      best = std::max(best, plane_.radius(input_.motion, input_.poses[centre], {vertices_a_, vertices_b_},
                                          input_.gap, enough));
    }
  }
  for (Index slack = 0; slack < 2 && best < enough; ++slack) {
    if (find_bridge(pair, slack)) best = std::max(best, chart_radius(pair, centre));
  }
  return best;
}

double PairBalls::feature_radius(NodePairIds pair, Index centre, double at_least, double enough) {
  const auto nodes = input_.motion.hierarchy()->nodes();
  const std::array<Index, 2> leaves{nodes[pair[0]].leaf_begin, nodes[pair[1]].leaf_begin};
  // An edge that pierces a face meets neither its corners nor its sides: features alone would not tell.
  const TouchTest test(*input_.motion.hierarchy(), input_.poses[centre]);
  if (test.leaves_touch(leaves[0], leaves[1])) return 0;
  return features_.radius(input_.motion, input_.poses[centre], leaves, input_.gap, at_least, enough);
}

}  // namespace foldproof
