#include "solver/candidate_lists.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace foldproof::internal {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// V4: bounds and displacements are rounded outwards by these.
constexpr double kDown = 1 - 0x1p-50, kUp = 1 + 0x1p-50, kDisplacementRounding = 0x1p-51;
constexpr std::size_t kGrain = 64;

// Both hold minima and negated maxima.
void merge_bounds(double (&bounds)[2][4], const double (&other)[2][4]) {
  for (int corner = 0; corner < 2; ++corner) {
    for (int axis = 0; axis < 4; ++axis)
      bounds[corner][axis] = std::min(bounds[corner][axis], other[corner][axis]);
  }
}

template <std::size_t N, std::size_t M>
bool share_vertex(const std::array<Index, N>& a, const std::array<Index, M>& b) {
  bool any = false;
  for (const Index v : a) {
    for (const Index w : b) any |= v == w;
  }
  return any;
}

}  // namespace

template <int Ends>
CandidateLists<Ends>::CandidateLists(const CollisionMesh& mesh, const ContactFilter& filter)
    : mesh_(mesh),
      filter_(filter),
      hierarchy_(*mesh.hierarchy()),
      allows_all_(filter.allows_all()),
      operations_(box_operations<Ends>()),
      edges_begin_(static_cast<Index>(hierarchy_.vertex_ids().size())),
      triangles_begin_(edges_begin_ + static_cast<Index>(hierarchy_.edge_ids().size())),
      ids_(hierarchy_.vertex_ids().begin(), hierarchy_.vertex_ids().end()),
      leaf_vertices_(list_leaf_vertices(hierarchy_)),
      vertex_corners_(edges_begin_),
      leaf_nodes_(hierarchy_.leaf_count()),
      rows_(hierarchy_.leaf_count()) {
  for (Index v = 0; v < edges_begin_; ++v) vertex_corners_[v] = {v};
  std::vector<Index> edge_of_row(hierarchy_.edge_ids().size());
  for (Index e = 0; e < edge_of_row.size(); ++e) {
    ids_.push_back(mesh.edge_row(hierarchy_.edge_ids()[e]));
    edge_of_row[ids_.back()] = e;
  }
  for (Index t = 0; t < hierarchy_.triangles().size(); ++t) {
    const Index triangle = hierarchy_.triangle_ids()[t];
    ids_.push_back(triangle);
    switch (hierarchy_.topology().element(triangle)) {
      case Element::Face:
        elements_.push_back(triangles_begin_ + t);
        break;
      case Element::Line:
        elements_.push_back(edges_begin_ + edge_of_row[mesh.codim_edges()[triangle - mesh.faces().size()]]);
        break;
      case Element::Point:
        elements_.push_back(hierarchy_.triangles()[t][0]);
        break;
    }
  }
  for (Index node = 0; node < hierarchy_.nodes().size(); ++node) {
    if (hierarchy_.nodes()[node].is_leaf()) leaf_nodes_[hierarchy_.nodes()[node].leaf_begin] = node;
  }
}

// A lower bound of the separation of two nodes' boxes.
template <int Ends>
double CandidateLists<Ends>::box_separation(Index node_a, Index node_b) const {
  return std::min(separation(boxes_[node_a], boxes_[node_b]), std::numeric_limits<double>::max()) * kDown;
}

// An upper bound of how much closer features below two nodes came to each other since the last call.
template <int Ends>
double CandidateLists<Ends>::closing_distance(Index node_a, Index node_b) const {
  const auto &a = displacements_[node_a].x, &b = displacements_[node_b].x;
  double change = kInfinity;  // of the separation, the smallest along any axis and side
  for (int axis = 0; axis < 3; ++axis) {
    change = std::min(change, a[0][axis] + b[1][axis]);
    change = std::min(change, b[0][axis] + a[1][axis]);
  }
  return -change * kUp;
}

// What is left of a lower bound of the separation of features below two nodes after the last call.
template <int Ends>
double CandidateLists<Ends>::still_separated(double min_separation, Index node_a, Index node_b) const {
  return (min_separation - closing_distance(node_a, node_b)) * kDown;
}

// The skin that minimizes the cost of testing listed pairs, which grows with the skin relative to the size of
// features, plus that of rebuilding lists, which grows with how often the skin is used up.
template <int Ends>
double CandidateLists<Ends>::skin_for(Index node_a, Index node_b) const {
  constexpr double kFirst = 1.0 / 64, kMax = 1.0 / 8, kCostRatio = 1;
  double side = 0;
  for (const Index node : {node_a, node_b}) {
    const auto& x = boxes_[node].x[0];
    for (int axis = 0; axis < 3; ++axis) side = std::max(side, -x[0][axis] - x[1][axis]);
  }
  if (!reuse_) return side * kFirst;
  const double closing = closing_distance(node_a, node_b);
  if (!(closing < side * kMax / 2)) return 0;
  return std::min(side * kMax, std::max(2 * closing, std::sqrt(kCostRatio * closing * side)));
}

template <int Ends>
void CandidateLists<Ends>::fit_leaf(Index leaf) {
  DisplacementBounds& displacement = displacements_[leaf_nodes_[leaf]];
  const Index first = leaf_vertices_.begin[leaf], last = leaf_vertices_.begin[leaf + 1];
  operations_.fit_moving(points_.data(), last_points_.data(),
                         std::span(leaf_vertices_.vertices).subspan(first, last - first),
                         boxes_[leaf_nodes_[leaf]], displacement.x);
  // A displacement that overflows may be any, in both directions; so no sum of bounds is NaN.
  for (auto& corner : displacement.x) {
    for (double& d : corner) d = std::isfinite(d) ? d - std::abs(d) * kDisplacementRounding : -kInfinity;
  }
}

template <int Ends>
void CandidateLists<Ends>::fit_features() {
  const auto fit = [&](Index first, auto corners, auto fit_boxes) {
    parallel_for(IndexRange{0, corners.size()}, 64 * kGrain, [&](IndexRange range) {
      fit_boxes(points_.data(), corners.subspan(range.begin, range.size()),
                &feature_boxes_[first + range.begin]);
    });
  };
  fit(0, std::span<const std::array<Index, 1>>(vertex_corners_), operations_.fit_vertices);
  fit(edges_begin_, hierarchy_.edges(), operations_.fit_edges);
  fit(triangles_begin_, hierarchy_.triangles(), operations_.fit_triangles);
}

// Boxes and displacements of features and leaves, then of their ancestors.
template <int Ends>
void CandidateLists<Ends>::set_positions(const std::array<const double*, Ends>& x) {
  const auto nodes = hierarchy_.nodes();
  boxes_.resize(nodes.size());
  displacements_.resize(nodes.size());
  feature_boxes_.resize(ids_.size());
  points_.swap(last_points_);
  points_.resize(hierarchy_.vertex_ids().size());
  parallel_for(IndexRange{0, points_.size()}, 16 * kGrain, [&](IndexRange range) {
    for (std::size_t v = range.begin; v < range.end; ++v) {
      for (int end = 0; end < Ends; ++end)
        std::copy_n(x[end] + 3 * std::size_t{hierarchy_.vertex_ids()[v]}, 3, points_[v].x[end]);
    }
  });
  if (!reuse_) last_points_ = points_;
  parallel_for(IndexRange{0, leaf_nodes_.size()}, kGrain, [&](IndexRange range) {
    for (std::size_t leaf = range.begin; leaf < range.end; ++leaf) fit_leaf(static_cast<Index>(leaf));
  });
  fit_features();
  for (std::size_t node = nodes.size(); node-- > 0;) {
    if (nodes[node].is_leaf()) continue;
    boxes_[node] = boxes_[node + 1];
    displacements_[node] = displacements_[node + 1];
    for (int end = 0; end < Ends; ++end) merge_bounds(boxes_[node].x[end], boxes_[nodes[node].right].x[end]);
    merge_bounds(displacements_[node].x, displacements_[nodes[node].right].x);
  }
}

// Traverses again below the nodes that are no longer separated.
template <int Ends>
void CandidateLists<Ends>::update_front() {
  parallel_for(IndexRange{0, front_.size()}, 64 * kGrain, [&](IndexRange range) {
    for (std::size_t k = range.begin; k < range.end; ++k) {
      SeparatedNodes& pair = front_[k];
      pair.min_separation = still_separated(pair.min_separation, pair.nodes.a, pair.nodes.b);
      if (!(pair.min_separation >= required_))
        pair.min_separation = box_separation(pair.nodes.a, pair.nodes.b);
    }
  });
  std::erase_if(front_, [&](const SeparatedNodes& pair) {
    if (pair.min_separation >= required_) return false;
    pending_.push_back(pair.nodes);
    return true;
  });
  traverse_pending();
}

// Traverses from the root, as updates only refine the front and add neighbors. Rows whose neighbors are all
// found again keep their lists.
template <int Ends>
void CandidateLists<Ends>::rebuild_front() {
  front_.clear();
  for (Row& row : rows_) {
    for (Neighbor& neighbor : row.neighbors) neighbor.found = false;
  }
  pending_.resize(hierarchy_.nodes().empty() ? 0 : 1);
  traverse_pending();
  neighbor_count_ = 0;
  for (Row& row : rows_) {
    if (std::erase_if(row.neighbors, [](const Neighbor& neighbor) { return !neighbor.found; }) > 0) {
      row.list.clear();
      for (Neighbor& neighbor : row.neighbors) neighbor = {neighbor.node, 0, -kInfinity, true};
    }
    neighbor_count_ += row.neighbors.size();
  }
}

template <int Ends>
void CandidateLists<Ends>::traverse_pending() {
  const NodePairs nodes{hierarchy_.nodes(), hierarchy_.nodes(), true};
  traverse_pairs(nodes, pending_, [&](NodePair pair) {
    ++node_tests_;
    if (!filter_.nodes(0, pair.a, 0, pair.b)) return false;
    if (pair.a != pair.b) {
      const double separation = box_separation(pair.a, pair.b);
      if (separation >= required_) {
        front_.push_back({pair, separation});
        return false;
      }
    }
    if (!nodes.are_leaves(pair)) return true;
    add_neighbor(pair);
    return false;
  });
}

template <int Ends>
void CandidateLists<Ends>::add_neighbor(NodePair leaves) {
  auto& row = rows_[hierarchy_.nodes()[leaves.a].leaf_begin].neighbors;
  const auto at = std::lower_bound(row.begin(), row.end(), leaves.b,
                                   [](const Neighbor& neighbor, Index node) { return neighbor.node < node; });
  if (at != row.end() && at->node == leaves.b) {
    at->found = true;
  } else {
    row.insert(at, {leaves.b, at == row.begin() ? 0 : std::prev(at)->end, -kInfinity, true});
    ++neighbor_count_;
  }
}

// The features of a leaf within a distance of a box.
template <int Ends>
void CandidateLists<Ends>::find_near(Index node, const Box& other, double distance, Near& near) const {
  const Index leaf = hierarchy_.nodes()[node].leaf_begin;
  const Hierarchy::Leaf &from = hierarchy_.leaves()[leaf], &to = hierarchy_.leaves()[leaf + 1];
  const auto choose = [&](Index first, Index last, std::vector<Index>& chosen) {
    chosen.resize(last - first);
    chosen.resize(operations_.keep_near(feature_boxes_.data(), first, last, other, distance, chosen.data()));
  };
  choose(from.vertices, to.vertices, near.vertices);
  choose(edges_begin_ + from.edges, edges_begin_ + to.edges, near.edges);
  choose(triangles_begin_ + from.triangles, triangles_begin_ + to.triangles, near.triangles);
}

template <int Ends>
template <class Visit>
void CandidateLists<Ends>::visit_near_pairs(double distance, std::vector<BoxPair>& pairs, Visit visit) const {
  pairs.resize(operations_.keep_near_pairs(feature_boxes_.data(), pairs, distance, pairs.data()));
  for (const auto [a, b] : pairs) visit(a, b);
  pairs.clear();
}

template <int Ends>
void CandidateLists<Ends>::list_vertices(double distance, const Near& with_vertices,
                                         const Near& with_triangles, Scratch& scratch) const {
  for (const Index v : with_vertices.vertices) {
    for (const Index t : with_triangles.triangles) scratch.pairs.push_back({v, t});
  }
  visit_near_pairs(distance, scratch.pairs, [&](Index v, Index t) {
    const Index element = elements_[t - triangles_begin_];
    if (share_vertex(std::array{v}, hierarchy_.triangles()[t - triangles_begin_])) return;
    // Two points come as each other's vertex and triangle.
    if (element < edges_begin_ && ids_[v] > ids_[element]) return;
    if (!allows_all_ && !filter_.vertex_face(0, ids_[v], 0, ids_[t])) return;
    const bool edge = element >= edges_begin_ && element < triangles_begin_;
    scratch.list.push_back(edge ? BoxPair{element, v} : BoxPair{v, element});
  });
}

template <int Ends>
void CandidateLists<Ends>::list_edges(bool self, double distance, Scratch& scratch) const {
  const auto &a = scratch.near[0].edges, &b = scratch.near[self ? 0 : 1].edges;
  const auto topology_edge = [&](Index edge) {
    return hierarchy_.topology().edges()[hierarchy_.edge_ids()[edge - edges_begin_]];
  };
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::size_t k = self ? i + 1 : 0; k < b.size(); ++k) scratch.pairs.push_back({a[i], b[k]});
  }
  visit_near_pairs(distance, scratch.pairs, [&](Index e, Index g) {
    if (share_vertex(hierarchy_.edges()[e - edges_begin_], hierarchy_.edges()[g - edges_begin_])) return;
    if (allows_all_ || filter_.edge_edge(0, topology_edge(e), 0, topology_edge(g)))
      scratch.list.push_back({e, g});
  });
}

// Appends the pairs of features of two leaves, or of one with itself, within a distance to the scratch; those
// of two edges come last. Returns where they begin.
template <int Ends>
std::size_t CandidateLists<Ends>::list_pairs(Index node_a, Index node_b, double distance,
                                             Scratch& scratch) const {
  const bool self = node_a == node_b;
  const Near &a = scratch.near[0], &b = scratch.near[self ? 0 : 1];
  find_near(node_a, boxes_[node_b], distance, scratch.near[0]);
  if (!self) find_near(node_b, boxes_[node_a], distance, scratch.near[1]);
  const Element of_a = hierarchy_.element(hierarchy_.nodes()[node_a].leaf_begin);
  const Element of_b = hierarchy_.element(hierarchy_.nodes()[node_b].leaf_begin);
  if (tests_vertices(of_a, of_b)) list_vertices(distance, a, b, scratch);
  if (!self && tests_vertices(of_b, of_a)) list_vertices(distance, b, a, scratch);
  const std::size_t edges = scratch.list.size();
  list_edges(self, distance, scratch);
  return edges;
}

template <int Ends>
void CandidateLists<Ends>::rebuild_list(Index node, Neighbor& neighbor, Scratch& scratch) const {
  if (neighbor.node != node) {
    neighbor.min_separation = box_separation(node, neighbor.node);
    if (neighbor.min_separation >= required_) return;
  }
  const double distance = required_ + skin_for(node, neighbor.node);
  ++scratch.lists_built;
  list_pairs(node, neighbor.node, distance, scratch);
  neighbor.min_separation = distance;
}

template <int Ends>
void CandidateLists<Ends>::update_row(Index leaf, Scratch& scratch) {
  Row& row = rows_[leaf];
  bool complete = true;
  for (Neighbor& neighbor : row.neighbors) {
    if (reuse_)
      neighbor.min_separation = still_separated(neighbor.min_separation, leaf_nodes_[leaf], neighbor.node);
    complete &= neighbor.min_separation >= required_;
  }
  if (complete) return;
  scratch.list.clear();
  Index begin = 0;
  for (Neighbor& neighbor : row.neighbors) {
    const Index end = neighbor.end;
    if (neighbor.min_separation >= required_) {
      scratch.list.insert(scratch.list.end(), row.list.begin() + begin, row.list.begin() + end);
    } else {
      rebuild_list(leaf_nodes_[leaf], neighbor, scratch);
    }
    neighbor.end = static_cast<Index>(scratch.list.size());
    begin = end;
  }
  row.list.assign(scratch.list.begin(), scratch.list.end());
}

// Lists and separated nodes hold for the positions of the last call; afterwards for the present ones.
template <int Ends>
void CandidateLists<Ends>::expire_lists() {
  for (SeparatedNodes& pair : front_)
    pair.min_separation = still_separated(pair.min_separation, pair.nodes.a, pair.nodes.b);
  for (std::size_t leaf = 0; leaf < rows_.size(); ++leaf) {
    for (Neighbor& neighbor : rows_[leaf].neighbors)
      neighbor.min_separation = still_separated(neighbor.min_separation, leaf_nodes_[leaf], neighbor.node);
  }
}

template <int Ends>
void CandidateLists<Ends>::update_rows() {
  parallel_for(IndexRange{0, rows_.size()}, kGrain, [&](IndexRange range) {
    Scratch& scratch = scratch_.local();
    isolated([&] {  // filters are the user's
      for (std::size_t leaf = range.begin; leaf < range.end; ++leaf)
        update_row(static_cast<Index>(leaf), scratch);
    });
  });
}

template <int Ends>
void CandidateLists<Ends>::clear() {
  pending_.clear();
  for (Row& row : rows_) row = {};
  for (Scratch& scratch : scratch_) scratch = {};
  neighbor_count_ = 0;
}

template <int Ends>
void CandidateLists<Ends>::update(const std::array<const double*, Ends>& x, double inflation, Work& work) {
  constexpr std::size_t kMaxGrowth = 2;
  reuse_ = std::exchange(complete_, false);
  if (!reuse_) clear();
  inflation_ = inflation;
  required_ = inflation * (1 + 0x1p-40) + std::numeric_limits<double>::min();
  node_tests_ = front_.size();
  set_positions(x);
  ++work.refits;
  if (!reuse_ || front_.size() + neighbor_count_ > kMaxGrowth * rebuilt_size_ + kGrain) {
    rebuild_front();
    rebuilt_size_ = front_.size() + neighbor_count_;
  } else {
    update_front();
  }
  update_rows();
  complete_ = std::isfinite(inflation);  // lists of all pairs would slow down all later calls
  work.node_tests += node_tests_;
  for (Scratch& scratch : scratch_) work.leaf_pairs += std::exchange(scratch.lists_built, 0);
}

template <int Ends>
void CandidateLists<Ends>::find(IndexRange rows, std::vector<BoxPair>& out) const {
  for (std::size_t k = rows.begin; k < rows.end; ++k) {
    const std::size_t before = out.size();
    out.resize(before + rows_[k].list.size());
    out.resize(before + operations_.keep_near_pairs(feature_boxes_.data(), rows_[k].list, inflation_,
                                                    out.data() + before));
  }
}

template <int Ends>
void CandidateLists<Ends>::append(std::span<const BoxPair> pairs, Candidates& out) const {
  for (const auto [a, b] : pairs) {
    const Index id_a = ids_[a], id_b = ids_[b];
    if (a < edges_begin_) {
      if (b < edges_begin_) {
        out.vertex_vertex.push_back({id_a, id_b});
      } else {
        out.vertex_face.push_back({id_a, id_b});
      }
    } else if (b < edges_begin_) {
      out.edge_vertex.push_back({id_a, id_b});
    } else {
      out.edge_edge.push_back({std::min(id_a, id_b), std::max(id_a, id_b)});
    }
  }
}

template class CandidateLists<1>;
template class CandidateLists<2>;

}  // namespace foldproof::internal
