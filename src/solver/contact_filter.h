/// Which of the pairs that the hierarchy finds are relevant, and as what.
#pragma once

#include "check/narrow_phase.h"
#include "foldproof/solver.h"

namespace foldproof::inline internal {

/// What a triangle of CollisionMesh::hierarchy() represents.
enum class Element : std::uint8_t { Face, Edge, Point };

class ContactFilter final : public PairFilter {
 public:
  explicit ContactFilter(const CollisionMesh& mesh)
      : mesh_(mesh),
        triangles_(mesh.hierarchy()->topology().triangles()),
        faces_(static_cast<Index>(mesh.faces().size())),
        faces_and_edges_(faces_ + static_cast<Index>(mesh.codim_edges().size())) {}

  Element element(Index triangle) const {
    if (triangle < faces_) return Element::Face;
    return triangle < faces_and_edges_ ? Element::Edge : Element::Point;
  }

  bool vertex_face(Index vertex, Index triangle) const override {
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

  bool edge_edge(const Edge& a, const Edge& b) const override { return mesh_.filter().allows_any(a, b); }

  /// Whether two triangles that intersect count as an intersection.
  bool crossing(Index triangle_a, Index triangle_b) const override;

  /// The row of the codimensional edge that a triangle represents.
  Index codim_edge(Index triangle) const { return mesh_.codim_edges()[triangle - faces_]; }

 private:
  const CollisionMesh& mesh_;
  std::span<const Triangle> triangles_;
  Index faces_, faces_and_edges_;
};

}  // namespace foldproof::internal
