#include "solver/candidate_lists.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace foldproof {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// V4: what one rounding takes from a bound, and what it adds to how far something went.
constexpr double kDown = 1 - 0x1p-50, kUp = 1 + 0x1p-50, kDriftRounding = 0x1p-51;
constexpr std::size_t kGrain = 64;

void add_rows(double (&rows)[2][4], const double (&other)[2][4]) {
  for (int corner = 0; corner < 2; ++corner) {
    for (int axis = 0; axis < 4; ++axis)
      rows[corner][axis] = std::min(rows[corner][axis], other[corner][axis]);
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
      tree_(*mesh.hierarchy()),
      all_may_(mesh.filter().all_may()),
      operations_(box_operations<Ends>()),
      edges_begin_(static_cast<Index>(tree_.vertex_ids().size())),
      triangles_begin_(edges_begin_ + static_cast<Index>(tree_.edge_ids().size())),
      ids_(tree_.vertex_ids().begin(), tree_.vertex_ids().end()),
      leaf_vertices_(list_leaf_vertices(tree_)),
      vertex_places_(edges_begin_),
      leaf_nodes_(tree_.leaf_count()),
      rows_(tree_.leaf_count()) {
  for (Index place = 0; place < edges_begin_; ++place) vertex_places_[place] = {place};
  std::vector<Index> edge_places(tree_.edge_ids().size());
  for (Index place = 0; place < edge_places.size(); ++place) {
    ids_.push_back(mesh.edge_of(tree_.edge_ids()[place]));
    edge_places[ids_.back()] = place;
  }
  for (Index place = 0; place < tree_.triangles().size(); ++place) {
    const Index triangle = tree_.triangle_ids()[place];
    ids_.push_back(triangle);
    switch (filter.element(triangle)) {
      case Element::Face:
        elements_.push_back(triangles_begin_ + place);
        break;
      case Element::Edge:
        elements_.push_back(edges_begin_ + edge_places[filter.codim_edge(triangle)]);
        break;
      case Element::Point:
        elements_.push_back(tree_.triangles()[place][0]);
        break;
    }
  }
  for (Index node = 0; node < tree_.nodes().size(); ++node) {
    if (tree_.nodes()[node].is_leaf()) leaf_nodes_[tree_.nodes()[node].leaf_begin] = node;
  }
}

// What lies between two boxes at least.
template <int Ends>
double CandidateLists<Ends>::between(Index node_a, Index node_b) const {
  const double apart = separation(boxes_[node_a], boxes_[node_b]);
  return std::min(apart, std::numeric_limits<double>::max()) * kDown;
}

// By how much what lies below two nodes came nearer since the call before, at most.
template <int Ends>
double CandidateLists<Ends>::melted(Index node_a, Index node_b) const {
  const auto &a = drifts_[node_a].x, &b = drifts_[node_b].x;
  double least = kInfinity;
  for (int axis = 0; axis < 3; ++axis) {
    least = std::min(least, a[0][axis] + b[1][axis]);
    least = std::min(least, b[0][axis] + a[1][axis]);
  }
  return -least * kUp;
}

// As much room as makes testing what is listed and listing anew cost least together: the one grows with the
// room as a share of a feature's size, the other with the number of times that the room is used up.
template <int Ends>
double CandidateLists<Ends>::room_for(Index node_a, Index node_b) const {
  constexpr double kAtFirst = 1.0 / 64, kMost = 1.0 / 8, kCosts = 1;
  double side = 0;
  for (const Index node : {node_a, node_b}) {
    const auto& x = boxes_[node].x[0];
    for (int axis = 0; axis < 3; ++axis) side = std::max(side, -x[0][axis] - x[1][axis]);
  }
  if (!started_) return side * kAtFirst;
  const double melted = this->melted(node_a, node_b);
  if (!(melted < side * kMost / 2)) return 0;
  return std::min(side * kMost, std::max(2 * melted, std::sqrt(kCosts * melted * side)));
}

template <int Ends>
void CandidateLists<Ends>::fit_leaf(Index leaf) {
  Drift& drift = drifts_[leaf_nodes_[leaf]];
  const Index first = leaf_vertices_.begin[leaf], last = leaf_vertices_.begin[leaf + 1];
  operations_.fit_moving(points_.data(), before_.data(),
                         std::span(leaf_vertices_.places).subspan(first, last - first),
                         boxes_[leaf_nodes_[leaf]], drift.x);
  // Farther than numbers go is as far as can be, in both directions: then no sum is NaN.
  for (auto& corner : drift.x) {
    for (double& d : corner) d = std::isfinite(d) ? d - std::abs(d) * kDriftRounding : -kInfinity;
  }
}

template <int Ends>
void CandidateLists<Ends>::fit_features() {
  const auto fit = [&](Index begin, auto corners, auto fit_boxes) {
    parallel_for(IndexRange{0, corners.size()}, 64 * kGrain, [&](IndexRange range) {
      fit_boxes(points_.data(), corners.subspan(range.begin, range.size()),
                &feature_boxes_[begin + range.begin]);
    });
  };
  fit(0, std::span<const std::array<Index, 1>>(vertex_places_), operations_.fit_vertices);
  fit(edges_begin_, tree_.edges(), operations_.fit_edges);
  fit(triangles_begin_, tree_.triangles(), operations_.fit_triangles);
}

// Boxes and drifts, of all leaves and then upwards.
template <int Ends>
void CandidateLists<Ends>::move(const std::array<const double*, Ends>& x) {
  const auto nodes = tree_.nodes();
  boxes_.resize(nodes.size());
  drifts_.resize(nodes.size());
  feature_boxes_.resize(ids_.size());
  points_.swap(before_);
  points_.resize(tree_.vertex_ids().size());
  parallel_for(IndexRange{0, points_.size()}, 16 * kGrain, [&](IndexRange range) {
    for (std::size_t place = range.begin; place < range.end; ++place) {
      for (int end = 0; end < Ends; ++end)
        std::copy_n(x[end] + 3 * std::size_t{tree_.vertex_ids()[place]}, 3, points_[place].x[end]);
    }
  });
  if (!started_) before_ = points_;
  parallel_for(IndexRange{0, leaf_nodes_.size()}, kGrain, [&](IndexRange range) {
    for (std::size_t leaf = range.begin; leaf < range.end; ++leaf) fit_leaf(static_cast<Index>(leaf));
  });
  fit_features();
  for (std::size_t node = nodes.size(); node-- > 0;) {
    if (nodes[node].is_leaf()) continue;
    boxes_[node] = boxes_[node + 1];
    drifts_[node] = drifts_[node + 1];
    for (int end = 0; end < Ends; ++end) add_rows(boxes_[node].x[end], boxes_[nodes[node].right].x[end]);
    add_rows(drifts_[node].x, drifts_[nodes[node].right].x);
  }
}

// What no longer holds is looked at again, from there down.
template <int Ends>
void CandidateLists<Ends>::renew_front() {
  parallel_for(IndexRange{0, front_.size()}, 64 * kGrain, [&](IndexRange range) {
    for (std::size_t k = range.begin; k < range.end; ++k) {
      Apart& proof = front_[k];
      proof.covers = (proof.covers - melted(proof.a, proof.b)) * kDown;
      if (!(proof.covers >= needed_)) proof.covers = between(proof.a, proof.b);
    }
  });
  std::erase_if(front_, [&](const Apart& proof) {
    if (proof.covers >= needed_) return false;
    pending_.push_back({proof.a, proof.b});
    return true;
  });
  descend();
}

// From the root, as the front only ever gets finer, and neighbours stay; lists that are still needed do so
// too.
template <int Ends>
void CandidateLists<Ends>::renew_all() {
  front_.clear();
  for (Row& row : rows_) {
    for (Neighbour& neighbour : row.neighbours) neighbour.seen = false;
  }
  pending_.assign(tree_.nodes().empty() ? 0 : 1, {0, 0});
  descend();
  neighbours_ = 0;
  for (Row& row : rows_) {
    if (std::erase_if(row.neighbours, [](const Neighbour& neighbour) { return !neighbour.seen; }) > 0) {
      row.list.clear();
      for (Neighbour& neighbour : row.neighbours) neighbour = {neighbour.node, 0, -kInfinity, true};
    }
    neighbours_ += row.neighbours.size();
  }
}

template <int Ends>
void CandidateLists<Ends>::descend() {
  const auto nodes = tree_.nodes();
  while (!pending_.empty()) {
    const NodePair pair = pending_.back();
    pending_.pop_back();
    ++tests_;
    if (pair.a != pair.b) {
      const double apart = between(pair.a, pair.b);
      if (apart >= needed_) {
        front_.push_back({pair.a, pair.b, apart});
        continue;
      }
    }
    if (nodes[pair.a].is_leaf() && nodes[pair.b].is_leaf()) {
      add_neighbour(pair);
    } else if (pair.a == pair.b) {
      push_below_self(nodes, pair.a, pending_);
    } else {
      push_below(nodes, nodes, pair, pending_);
    }
  }
}

template <int Ends>
void CandidateLists<Ends>::add_neighbour(NodePair leaves) {
  auto& row = rows_[tree_.nodes()[leaves.a].leaf_begin].neighbours;
  const auto at =
      std::lower_bound(row.begin(), row.end(), leaves.b,
                       [](const Neighbour& neighbour, Index node) { return neighbour.node < node; });
  if (at != row.end() && at->node == leaves.b) {
    at->seen = true;
  } else {
    row.insert(at, {leaves.b, at == row.begin() ? 0 : std::prev(at)->end, -kInfinity, true});
    ++neighbours_;
  }
}

// The features of a leaf that are near a box.
template <int Ends>
void CandidateLists<Ends>::list_near(Index node, const Box& other, double reach, Near& near) const {
  const Index leaf = tree_.nodes()[node].leaf_begin;
  const Hierarchy::Leaf &from = tree_.leaves()[leaf], &to = tree_.leaves()[leaf + 1];
  const auto choose = [&](Index first, Index last, std::vector<Index>& chosen) {
    chosen.resize(last - first);
    chosen.resize(operations_.keep_near(feature_boxes_.data(), first, last, other, reach, chosen.data()));
  };
  choose(from.vertices, to.vertices, near.vertices);
  choose(edges_begin_ + from.edges, edges_begin_ + to.edges, near.edges);
  choose(triangles_begin_ + from.triangles, triangles_begin_ + to.triangles, near.triangles);
}

template <int Ends>
template <class Visit>
void CandidateLists<Ends>::each_near(double reach, std::vector<BoxPair>& pairs, Visit visit) const {
  pairs.resize(operations_.keep_near_pairs(feature_boxes_.data(), pairs, reach, pairs.data()));
  for (const auto [a, b] : pairs) visit(a, b);
  pairs.clear();
}

template <int Ends>
void CandidateLists<Ends>::list_vertices(double reach, const Near& with_vertices, const Near& with_triangles,
                                         Local& local) const {
  for (const Index v : with_vertices.vertices) {
    for (const Index t : with_triangles.triangles) local.pairs.push_back({v, t});
  }
  each_near(reach, local.pairs, [&](Index v, Index t) {
    const Index element = elements_[t - triangles_begin_];
    if (share_vertex(std::array{v}, tree_.triangles()[t - triangles_begin_])) return;
    if (!(all_may_ && element == t) && !filter_.vertex_face(ids_[v], ids_[t])) return;
    const bool edge = element >= edges_begin_ && element < triangles_begin_;
    local.list.push_back(edge ? BoxPair{element, v} : BoxPair{v, element});
  });
}

template <int Ends>
void CandidateLists<Ends>::list_edges(bool self, double reach, Local& local) const {
  const auto &a = local.near[0].edges, &b = local.near[self ? 0 : 1].edges;
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::size_t k = self ? i + 1 : 0; k < b.size(); ++k) local.pairs.push_back({a[i], b[k]});
  }
  each_near(reach, local.pairs, [&](Index e, Index g) {
    if (share_vertex(tree_.edges()[e - edges_begin_], tree_.edges()[g - edges_begin_])) return;
    if (all_may_ || filter_.edge_edge(mesh_.edges()[ids_[e]], mesh_.edges()[ids_[g]]))
      local.list.push_back({e, g});
  });
}

// Appends to the local list what is to be listed of two leaves, or of one with itself.
template <int Ends>
void CandidateLists<Ends>::renew(Index node, Neighbour& neighbour, Local& local) const {
  const bool self = neighbour.node == node;
  if (!self) {
    neighbour.covers = between(node, neighbour.node);
    if (neighbour.covers >= needed_) return;
  }
  const double reach = needed_ + room_for(node, neighbour.node);
  ++local.listed;
  const Near &a = local.near[0], &b = local.near[self ? 0 : 1];
  list_near(node, boxes_[neighbour.node], reach, local.near[0]);
  if (!self) list_near(neighbour.node, boxes_[node], reach, local.near[1]);
  list_vertices(reach, a, b, local);
  if (!self) list_vertices(reach, b, a, local);
  list_edges(self, reach, local);
  neighbour.covers = reach;
}

template <int Ends>
void CandidateLists<Ends>::renew_row(Index leaf, Local& local) {
  Row& row = rows_[leaf];
  bool holds = true;
  for (Neighbour& neighbour : row.neighbours) {
    if (started_) neighbour.covers = (neighbour.covers - melted(leaf_nodes_[leaf], neighbour.node)) * kDown;
    holds &= neighbour.covers >= needed_;
  }
  if (holds) return;
  local.list.clear();
  Index begin = 0;
  for (Neighbour& neighbour : row.neighbours) {
    const Index end = neighbour.end;
    if (neighbour.covers >= needed_) {
      local.list.insert(local.list.end(), row.list.begin() + begin, row.list.begin() + end);
    } else {
      renew(leaf_nodes_[leaf], neighbour, local);
    }
    neighbour.end = static_cast<Index>(local.list.size());
    begin = end;
  }
  row.list.assign(local.list.begin(), local.list.end());
}

template <int Ends>
void CandidateLists<Ends>::renew_rows() {
  parallel_for(IndexRange{0, rows_.size()}, kGrain, [&](IndexRange range) {
    Local& local = locals_.local();
    for (std::size_t leaf = range.begin; leaf < range.end; ++leaf) renew_row(static_cast<Index>(leaf), local);
  });
}

template <int Ends>
void CandidateLists<Ends>::clear() {
  pending_.clear();
  for (Row& row : rows_) row = {};
  for (Local& local : locals_) local = {};
  neighbours_ = 0;
}

template <int Ends>
void CandidateLists<Ends>::update(const std::array<const double*, Ends>& x, double inflation, Work& work) {
  constexpr std::size_t kMore = 2;
  started_ = std::exchange(complete_, false);
  if (!started_) clear();
  inflation_ = inflation;
  needed_ = inflation * (1 + 0x1p-40) + std::numeric_limits<double>::min();
  tests_ = front_.size();
  move(x);
  if (!started_ || front_.size() + neighbours_ > kMore * proofs_at_first_ + kGrain) {
    renew_all();
    proofs_at_first_ = front_.size() + neighbours_;
  } else {
    renew_front();
  }
  renew_rows();
  complete_ = true;
  work.node_tests += tests_;
  for (Local& local : locals_) work.leaf_pairs += std::exchange(local.listed, 0);
}

template <int Ends>
void CandidateLists<Ends>::find(IndexRange rows, std::vector<BoxPair>& scratch, Candidates& out) const {
  for (std::size_t k = rows.begin; k < rows.end; ++k) {
    scratch.resize(rows_[k].list.size());
    scratch.resize(
        operations_.keep_near_pairs(feature_boxes_.data(), rows_[k].list, inflation_, scratch.data()));
    for (const auto [a, b] : scratch) {
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
}

template class CandidateLists<1>;
template class CandidateLists<2>;

}  // namespace foldproof
