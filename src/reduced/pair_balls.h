/// The ball of a pair of nodes by every proof that fits it, without looking at what lies below them.
#pragma once

#include "foldproof/certificate.h"
#include "reduced/chart_ball.h"
#include "reduced/feature_ball.h"
#include "reduced/node_motion.h"
#include "reduced/plane_ball.h"

namespace foldproof {

/// Nodes of the hierarchy; the same one twice for a node with itself.
using NodePairIds = std::array<Index, 2>;

/// What all balls of a shape are made from. Immutable.
struct BallInput {
  const ReducedMotion& motion;
  const NodeMotions& nodes;
  const PatchSlots& slots;
  std::span<const CentrePose> poses;
  double gap;
  Index most_triangles;
};

/// Scratch: one per thread.
class PairBalls {
 public:
  explicit PairBalls(const BallInput& input)
      : input_(input),
        reader_(input.slots),
        hops_a_(input.motion.hierarchy()->leaf_count(), kFar),
        hops_b_(input.motion.hierarchy()->leaf_count(), kFar) {}

  /// The largest radius that one proof gives around a centre; `enough`: more need not be looked for.
  double radius(NodePairIds pair, Index centre, double enough);
  /// Of two leaves, or one with itself: what their features give one by one, 0 where triangles meet at the
  /// centre. At most `at_least`: no more than that was found.
  double feature_radius(NodePairIds pair, Index centre, double at_least, double enough);

 private:
  static constexpr std::uint8_t kFar = 255;
  bool read(NodePairIds pair);
  void count_hops(Index from, Index to, Index most, std::vector<std::uint8_t>& hops);
  bool find_bridge(NodePairIds pair, Index slack);
  double chart_radius(NodePairIds pair, Index centre);
  bool are_neighbours(NodePairIds pair) const;

  const BallInput& input_;
  PatchReader reader_;
  ChartMaker maker_;
  ChartBall chart_;
  PlaneBall plane_;
  FeatureBall features_;
  Patch patch_;
  Drawing drawing_;
  std::vector<std::array<float, 3>> positions_;
  std::vector<Index> vertices_a_, vertices_b_;
  std::vector<Index> bridge_;                  // leaves between two nodes
  std::vector<std::uint8_t> hops_a_, hops_b_;  // per leaf, from a node; kFar where not counted
  std::vector<Index> reached_, queue_;
};

}  // namespace foldproof
