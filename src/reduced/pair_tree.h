/// The tree of pairs of nodes: which pairs get a ball, and each pair's ball with those below it counted in.
#pragma once

#include "reduced/pair_balls.h"

namespace foldproof::inline internal {

/// Stored flat: first the root (the hierarchy's root with itself), children after their parents.
struct PairTree {
  struct Node {
    Index a, b;       ///< Nodes of the hierarchy, a == b for one with itself.
    Index begin = 0;  ///< The first of its children, which are consecutive.
    Index count = 0;  ///< Of children: 0, 2 or 3.
  };
  Index centers = 0;
  std::vector<Node> nodes;
  /// [node][center]: the larger of the pair's own ball and the smallest of those below it (R4), without the
  /// pairs of leaves that no center proves; these are always tested.
  std::vector<float> balls;
};

/// A tree, and the pairs of leaves that it does not cover.
struct PairTreeResult {
  PairTree tree;
  std::vector<std::array<Index, 2>> never_certified;  ///< Pairs of leaves, ascending.
  struct AtCenter {
    double radius;                                  ///< ReducedShape::radius.
    std::vector<std::array<Index, 2>> uncertified;  ///< Pairs of leaves that this center does not prove.
  };
  std::vector<AtCenter> at_center;
};

/// Splits the pair with the smallest ball, again and again, until every ball has its center's max_radius or
/// there are `max_pairs`. Error: cancelled.
Result<PairTreeResult> build_pair_tree(const BallInput& input, std::span<const ReducedCenter> centers,
                                       std::size_t max_pairs, const ReducedHooks& hooks);

}  // namespace foldproof::internal
