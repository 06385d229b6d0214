// The smallest distance in a pose: pairs of nodes, those with the closest boxes first, until no pair that is
// left can be nearer than the nearest one so far.

#include <algorithm>
#include <limits>
#include <utility>

#include "solver/candidate_lists.h"

namespace foldproof::internal {

// At most `bound`, else infinity.
template <int Ends>
double CandidateLists<Ends>::nearest_of_leaves(NodePair leaves, double bound, Scratch& scratch) const {
  double smallest = std::numeric_limits<double>::infinity();
  scratch.list.clear();
  const std::size_t edges = list_pairs(leaves.a, leaves.b, bound, scratch);
  const std::span<const BoxPair> all = scratch.list;
  scratch.vertex_pairs += edges;
  scratch.edge_pairs += all.size() - edges;
  for (const auto pairs : {all.first(edges), all.subspan(edges)}) {
    visit_distances(
        PosedFeatures{mesh_, points_}, pairs, [&] { return std::min(bound, smallest); },
        [&](BoxPair, const NearestBatch& found, int lane) {
          smallest = std::min(smallest, found.distance[lane]);
        });
  }
  return smallest <= bound ? smallest : std::numeric_limits<double>::infinity();
}

template <int Ends>
double CandidateLists<Ends>::nearest(const double* x, double bound, Work& work) requires(Ends == 1) {
  struct Pair {
    double min_separation;
    std::size_t number;  // in the order of discovery
    NodePair nodes;
    // Where boxes overlap, the pair that was found last goes first: it is the smallest.
    bool operator<(const Pair& p) const {
      return min_separation != p.min_separation ? min_separation > p.min_separation : number < p.number;
    }
  };
  // Leaves are measured in parallel, with the bound that the round before found; so first rounds are short.
  constexpr std::size_t kMaxLeaves = 64;
  const auto nodes = hierarchy_.nodes();
  reuse_ = std::exchange(complete_, false);
  if (!reuse_) clear();
  set_positions({x});
  if (reuse_) expire_lists();
  std::vector<Pair> heap;
  std::size_t number = 0;
  const auto push = [&](NodePair pair) {
    const double separation = pair.a == pair.b ? 0 : std::max(0.0, box_separation(pair.a, pair.b));
    if (separation > bound || !filter_.nodes(0, pair.a, 0, pair.b)) return;
    heap.push_back({separation, number++, pair});
    std::push_heap(heap.begin(), heap.end());
  };
  if (!nodes.empty()) push({0, 0});
  double smallest = std::numeric_limits<double>::infinity();
  std::vector<NodePair> leaves;
  std::vector<double> distances;
  for (std::size_t most = 1; !heap.empty(); most = std::min(2 * most, kMaxLeaves)) {
    leaves.clear();
    while (!heap.empty() && leaves.size() < most) {
      std::pop_heap(heap.begin(), heap.end());
      const auto [separation, _, pair] = heap.back();
      heap.pop_back();
      if (separation > bound) {
        heap.clear();
        break;
      }
      ++work.node_tests;
      if (nodes[pair.a].is_leaf() && nodes[pair.b].is_leaf()) {
        leaves.push_back(pair);
        continue;
      }
      if (pair.a == pair.b)
        push_self_children(nodes, pair.a, pending_);
      else
        push_children(nodes, nodes, pair, pending_);
      for (const NodePair child : pending_) push(child);
      pending_.clear();
    }
    distances.resize(leaves.size());
    parallel_for(IndexRange{0, leaves.size()}, 1, [&](IndexRange range) {
      Scratch& scratch = scratch_.local();
      isolated([&] {  // filters are the user's
        for (std::size_t k = range.begin; k < range.end; ++k)
          distances[k] = nearest_of_leaves(leaves[k], bound, scratch);
      });
    });
    work.leaf_pairs += leaves.size();
    for (const double distance : distances) smallest = std::min(smallest, distance);
    bound = std::min(bound, smallest);
  }
  complete_ = reuse_;
  ++work.refits;
  for (Scratch& scratch : scratch_) {
    work.candidates_vf += std::exchange(scratch.vertex_pairs, 0);
    work.candidates_ee += std::exchange(scratch.edge_pairs, 0);
  }
  return smallest;
}

template double CandidateLists<1>::nearest(const double*, double, Work&);

}  // namespace foldproof::internal
