/// Which of the pairs that the hierarchy finds are relevant, and as what.
#pragma once

#include "check/narrow_phase.h"
#include "check/node_labels.h"
#include "foldproof/solver.h"

namespace foldproof::inline internal {

/// What a triangle of CollisionMesh::hierarchy() represents.
enum class Element : std::uint8_t { Face, Edge, Point };

class ContactFilter final : public PairFilter {
 public:
  explicit ContactFilter(const CollisionMesh& mesh);

  Element element(Index triangle) const {
    if (triangle < faces_) return Element::Face;
    return triangle < faces_and_edges_ ? Element::Edge : Element::Point;
  }

  /// Whether any pair of nodes is ignored: by the groups of CollisionFilter only.
  bool ignores_nodes() const { return !nodes_.empty(); }
  bool nodes(Index, Index node_a, Index, Index node_b) const override {
    return nodes_.empty() || nodes_.any(node_a, node_b, mesh_.filter());
  }

  bool vertex_face(Index, Index vertex, Index, Index triangle) const override {
    switch (element(triangle)) {
      case Element::Face:
        break;
      case Element::Edge:
        // Other vertices need no such pair: they have pairs of edges, and of vertices and faces (V2).
        if (!mesh_.is_codim_point(vertex)) return false;
        break;
      case Element::Point:
        // Two points come as each other's vertex; one of both pairs is enough.
        if (!mesh_.is_codim_point(vertex) || vertex > triangles_[triangle][0]) return false;
        break;
    }
    return mesh_.filter().allows_any(std::span(&vertex, 1), triangles_[triangle]);
  }

  bool edge_edge(Index, const Edge& a, Index, const Edge& b) const override {
    return mesh_.filter().allows_any(a, b);
  }

  /// Whether two triangles that intersect count as an intersection.
  bool crossing(Index, Index triangle_a, Index, Index triangle_b) const override;

  /// The row of the codimensional edge that a triangle represents.
  Index codim_edge(Index triangle) const { return mesh_.codim_edges()[triangle - faces_]; }

 private:
  const CollisionMesh& mesh_;
  std::span<const Triangle> triangles_;
  Index faces_, faces_and_edges_;
  NodeLabels nodes_;  // per node, a vertex of each group; empty: the filter has no groups
};

}  // namespace foldproof::internal
