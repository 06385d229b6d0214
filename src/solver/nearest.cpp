// The smallest distance in a pose: pairs of nodes, those with the closest boxes first, until no pair that is
// left can be nearer than the nearest one so far.

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "solver/candidate_lists.h"

namespace foldproof::internal {
namespace {

// A lower bound of the distance of two boxes. Four roundings and a root are off by less than 4 units in the
// last place; where squares under- or overflow, the largest gap along an axis stands for all.
double box_distance(const BoxAtEnds<1>& a, const BoxAtEnds<1>& b) {
  double square = 0, largest = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double gap = std::max({0.0, a.x[0][0][axis] + b.x[0][1][axis], a.x[0][1][axis] + b.x[0][0][axis]});
    square += gap * gap;
    largest = std::max(largest, gap);
  }
  const bool exact = largest > 1e-140 && largest < 1e140;
  return std::min(exact ? std::sqrt(square) : largest, std::numeric_limits<double>::max()) * (1 - 0x1p-50);
}

}  // namespace

// At most `bound`, else infinity.
template <int Ends>
double CandidateLists<Ends>::nearest_of_leaves(NodePair leaves, double bound, Scratch& scratch) const
    requires(Ends == 1) {
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
void CandidateLists<Ends>::open_pair(NodePair pair, double bound) requires(Ends == 1) {
  const double distance = pair.a == pair.b ? 0 : box_distance(boxes_[pair.a], boxes_[pair.b]);
  if (distance > bound || !filter_.nodes(0, pair.a, 0, pair.b)) return;
  open_pairs_.push_back({distance, opened_++, pair});
  std::push_heap(open_pairs_.begin(), open_pairs_.end());
}

// Moves the next pairs of leaves, those with the closest boxes, from the open pairs to leaves_.
template <int Ends>
void CandidateLists<Ends>::take_leaves(std::size_t most, double bound) requires(Ends == 1) {
  const NodePairs nodes{hierarchy_.nodes(), hierarchy_.nodes(), true};
  leaves_.clear();
  while (!open_pairs_.empty() && leaves_.size() < most) {
    std::pop_heap(open_pairs_.begin(), open_pairs_.end());
    const auto [distance, number, pair] = open_pairs_.back();
    open_pairs_.pop_back();
    if (distance > bound) {
      open_pairs_.clear();
      return;
    }
    ++node_tests_;
    if (nodes.are_leaves(pair)) {
      leaves_.push_back(pair);
      continue;
    }
    pending_.clear();
    push_children(nodes, pair, pending_);
    for (const NodePair child : pending_) open_pair(child, bound);
  }
  pending_.clear();
}

template <int Ends>
double CandidateLists<Ends>::nearest(const double* x, double bound, Work& work) requires(Ends == 1) {
  // Leaves are measured in parallel, with the bound that the round before found; so the first rounds are
  // short.
  constexpr std::size_t kMaxLeaves = 64;
  reuse_ = std::exchange(complete_, false);
  if (!reuse_) clear();
  set_positions({x});
  if (reuse_) expire_lists();
  node_tests_ = opened_ = 0;
  open_pairs_.clear();
  if (!hierarchy_.nodes().empty()) open_pair({}, bound);
  double smallest = std::numeric_limits<double>::infinity();
  for (std::size_t most = 1; !open_pairs_.empty(); most = std::min(2 * most, kMaxLeaves)) {
    take_leaves(most, std::min(bound, smallest));
    distances_.resize(leaves_.size());
    parallel_for(IndexRange{0, leaves_.size()}, 1, [&](IndexRange range) {
      Scratch& scratch = scratch_.local();
      isolated([&] {  // filters are the user's
        for (std::size_t k = range.begin; k < range.end; ++k)
          distances_[k] = nearest_of_leaves(leaves_[k], std::min(bound, smallest), scratch);
      });
    });
    work.leaf_pairs += leaves_.size();
    for (const double distance : distances_) smallest = std::min(smallest, distance);
  }
  complete_ = reuse_;
  ++work.refits;
  work.node_tests += node_tests_;
  for (Scratch& scratch : scratch_) {
    work.candidates_vf += std::exchange(scratch.vertex_pairs, 0);
    work.candidates_ee += std::exchange(scratch.edge_pairs, 0);
  }
  return smallest;
}

template double CandidateLists<1>::nearest(const double*, double, Work&);

}  // namespace foldproof::internal
