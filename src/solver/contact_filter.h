/// CollisionFilter, and a PairFilter beside it, on the pairs that the hierarchy finds.
#pragma once

#include "check/narrow_phase.h"
#include "check/node_labels.h"
#include "foldproof/solver.h"

namespace foldproof::inline internal {

class ContactFilter final : public PairFilter {
 public:
  /// `pairs`: null for none.
  ContactFilter(const CollisionMesh& mesh, std::shared_ptr<const PairFilter> pairs);

  bool allows_all() const { return filter_.allows_all() && pairs_ == nullptr; }
  /// Whether any pair of nodes may be ignored.
  bool ignores_nodes() const { return !nodes_.empty() || pairs_ != nullptr; }
  bool nodes(Index, Index node_a, Index, Index node_b) const override {
    return (nodes_.empty() || nodes_.any(node_a, node_b, filter_)) &&
           (pairs_ == nullptr || pairs_->nodes(0, node_a, 0, node_b));
  }

  bool vertex_face(Index, Index vertex, Index, Index triangle) const override {
    return filter_.allows_any(std::span(&vertex, 1), triangles_[triangle]) &&
           (pairs_ == nullptr || pairs_->vertex_face(0, vertex, 0, triangle));
  }
  bool edge_edge(Index, const Edge& a, Index, const Edge& b) const override {
    return filter_.allows_any(a, b) && (pairs_ == nullptr || pairs_->edge_edge(0, a, 0, b));
  }
  bool crossing(Index, Index triangle_a, Index, Index triangle_b) const override;

 private:
  const CollisionFilter& filter_;
  std::shared_ptr<const PairFilter> pairs_;
  std::span<const Triangle> triangles_;
  NodeLabels nodes_;  // per node, a vertex of each group; empty: the filter has no groups
};

}  // namespace foldproof::internal
