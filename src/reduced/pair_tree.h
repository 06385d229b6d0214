/// The tree of pairs of nodes: which pairs get a ball, and what a pair's ball is when those below are
/// counted in.
#pragma once

#include "reduced/pair_balls.h"

namespace foldproof {

/// Stored flat, the root (the hierarchy's root with itself) first, children behind their parents.
struct PairTree {
  struct Node {
    Index a, b;       ///< Nodes of the hierarchy, a == b for one with itself.
    Index begin = 0;  ///< Of its children, which follow each other.
    Index count = 0;  ///< 0, 2 or 3. 0: nothing below it is known.
  };
  Index centres = 0;
  std::vector<Node> nodes;
  /// [node][centre]: the largest of the pair's own ball and the smallest of those below it (R4). Pairs of
  /// leaves that no centre proves are left out of it; they are always tested.
  std::vector<float> balls;
};

/// A tree and what it cannot speak for.
struct PairTreeResult {
  PairTree tree;
  std::vector<std::array<Index, 2>> always_open;  ///< Pairs of leaves, ascending.
  struct OfCentre {
    double radius;                               ///< ReducedShape::radius.
    std::vector<std::array<Index, 2>> left_out;  ///< Pairs of leaves that this centre does not prove.
  };
  std::vector<OfCentre> of_centre;
};

/// Splits the pair that limits most, again and again, until every pair reaches as far as its centres ask for
/// or the budget is used up. Error: cancelled.
Result<PairTreeResult> grow_pair_tree(const BallInput& input, std::span<const ReducedCentre> centres,
                                      std::size_t most_pairs, const ReducedHooks& hooks);

}  // namespace foldproof
