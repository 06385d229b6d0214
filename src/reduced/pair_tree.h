/// The tree of pairs of nodes (ReducedBalls): which pairs get a ball, and each pair's ball with those below
/// it counted in.
#pragma once

#include "reduced/pair_balls.h"

namespace foldproof::inline internal {

/// What queries read of a tree of pairs, and the pairs of leaves that it does not cover.
struct PairTreeResult {
  /// [pair][center]: the larger of the pair's own ball and the smallest of those below it (R4), without the
  /// pairs of leaves that no center proves; these are always tested.
  std::vector<float> radii;
  std::vector<std::array<Index, 2>> never_certified;  ///< Pairs of leaves, ascending.
  struct AtCenter {
    double radius;                                  ///< ReducedShape::radius.
    std::vector<std::array<Index, 2>> uncertified;  ///< Pairs of leaves that this center does not prove.
  };
  std::vector<AtCenter> at_center;
};

/// Splits the pair with the smallest ball, again and again, until every ball has its center's max_radius or
/// there are `max_pairs`. The clearance of the result is input.gap. Error: cancelled.
Result<ReducedBalls> build_balls(const BallInput& input, std::span<const ReducedCenter> centers,
                                 std::size_t max_pairs, const ReducedHooks& hooks);

/// Whether the pairs are a tree as build_balls splits them, and the radii distances, one per pair and center.
bool are_balls_of(const Hierarchy& hierarchy, std::size_t centers, const ReducedBalls& balls);

/// Counts the balls below each pair in. Precondition: are_balls_of.
PairTreeResult make_pair_tree(const Hierarchy& hierarchy, std::span<const ReducedCenter> centers,
                              const ReducedBalls& balls);

}  // namespace foldproof::inline internal
