/// The ball of a pair of nodes by every proof that applies to it, whatever lies below the pair in the tree.
#pragma once

#include "certificate/library.h"
#include "reduced/chart_ball.h"
#include "reduced/feature_ball.h"
#include "reduced/node_motion.h"
#include "reduced/plane_ball.h"

namespace foldproof::inline internal {

/// Nodes of the hierarchy; the same one twice for a node with itself.
using NodePairIds = std::array<Index, 2>;

/// What all balls of a shape are computed from. Immutable.
struct BallInput {
  const ReducedMotion& motion;
  const NodeMotions& nodes;
  const PatchSlots& slots;
  std::span<const CenterPose> poses;
  double gap;
  Index max_triangles;
};

/// Scratch: one per thread.
class PairBalls {
 public:
  explicit PairBalls(const BallInput& input)
      : input_(input),
        reader_(input.slots),
        hops_a_(input.motion.hierarchy()->leaf_count(), kFar),
        hops_b_(input.motion.hierarchy()->leaf_count(), kFar) {}

  /// The largest radius around a center that one of the proofs gives. The search stops at `max_radius`.
  double radius(NodePairIds pair, Index center, double max_radius);
  /// Of two leaves, or one with itself: the smallest radius of their pairs of features, at most `max_radius`,
  /// and 0 where triangles meet at the center. The search stops at `known` or below; such a result proves
  /// nothing.
  double feature_radius(NodePairIds pair, Index center, double known, double max_radius);

 private:
  static constexpr std::uint8_t kFar = 255;
  bool read(NodePairIds pair);
  void count_hops(Index from, Index to, std::vector<std::uint8_t>& hops);
  bool find_bridge(NodePairIds pair, Index detour);
  double chart_radius(NodePairIds pair, Index center);
  bool are_neighbors(NodePairIds pair) const;

  const BallInput& input_;
  PatchReader reader_;
  Parametrizer parametrizer_;
  ChartBall chart_;
  PlaneBall plane_;
  FeatureBall features_;
  Patch patch_;
  UvMap uv_map_;
  std::vector<std::array<float, 3>> positions_;
  std::vector<Index> vertices_a_, vertices_b_;
  std::vector<Index> bridge_;                  // leaves between two nodes
  std::vector<std::uint8_t> hops_a_, hops_b_;  // per leaf, from a node; kFar where not visited
  std::vector<Index> visited_, queue_;
};

}  // namespace foldproof::internal
