/// CollisionFilter on the pairs that the hierarchy finds.
#pragma once

#include "check/narrow_phase.h"
#include "check/node_labels.h"
#include "foldproof/solver.h"

namespace foldproof::inline internal {

class ContactFilter final : public PairFilter {
 public:
  explicit ContactFilter(const CollisionMesh& mesh);

  /// Whether any pair of nodes is ignored: by the groups of CollisionFilter only.
  bool ignores_nodes() const { return !nodes_.empty(); }
  bool nodes(Index, Index node_a, Index, Index node_b) const override {
    return nodes_.empty() || nodes_.any(node_a, node_b, filter_);
  }

  bool vertex_face(Index, Index vertex, Index, Index triangle) const override {
    return filter_.allows_any(std::span(&vertex, 1), triangles_[triangle]);
  }
  bool edge_edge(Index, const Edge& a, Index, const Edge& b) const override {
    return filter_.allows_any(a, b);
  }
  bool crossing(Index, Index triangle_a, Index, Index triangle_b) const override;

 private:
  const CollisionFilter& filter_;
  std::span<const Triangle> triangles_;
  NodeLabels nodes_;  // per node, a vertex of each group; empty: the filter has no groups
};

}  // namespace foldproof::internal
