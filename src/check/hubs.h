/// Hubs: vertices with many triangles. The boxes of their leaves all overlap there; planes separate them.
#pragma once

#include <span>
#include <vector>

#include "bvh/traverse.h"

namespace foldproof::inline internal {

/// Which nodes are around a hub: one that all leaves below them have. Immutable.
class Hubs {
 public:
  static constexpr Index kMinTriangles = 128;  ///< Of a hub. With fewer there are few pairs of leaves.
  explicit Hubs(const Hierarchy& hierarchy);

  bool empty() const { return nodes_.empty(); }
  bool is_around_hub(NodeIndex node) const { return !empty() && row_[node] != kNoIndex; }
  /// Whether all leaves below both nodes have a hub in common, where their boxes overlap.
  bool have_common_hub(NodePair nodes) const;
  /// The vertices of all triangles below a node around a hub, in leaf order, ascending.
  void list_vertices(NodeIndex node, std::vector<Index>& out) const;

 private:
  struct Node {
    std::vector<Index> hubs;              // ascending
    std::vector<Index> before;            // vertices that earlier leaves own, ascending
    Index first_vertex, end_of_vertices;  // those that its own leaves own
  };

  std::vector<Index> row_;  // per node: in nodes_, or kNoIndex
  std::vector<Node> nodes_;
};

/// Separates nodes around hubs by planes (docs/soundness.md, B3h). Scratch of one thread.
class HubPlanes final : public NodeCertificate {
 public:
  /// `gap`: in the frame of the vertices. Both must outlive the tests.
  void begin(const Hubs& hubs, std::span<const MovingVertex> vertices, double gap);
  bool separates(NodePair nodes) override;

  std::uint64_t tests = 0, passes = 0;

 private:
  static constexpr std::size_t kMaxCommon = 2;
  bool find_sides(NodePair nodes);
  std::span<const Index> part(const std::vector<Index>& side, unsigned given) const;

  const Hubs* hubs_ = nullptr;
  std::span<const MovingVertex> vertices_;
  double gap_ = 0;
  std::vector<Index> all_a_, all_b_, common_;
  std::vector<Index> side_a_, side_b_;  // common vertices at the ends, those of one node only in between
};

}  // namespace foldproof::inline internal
