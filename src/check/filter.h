/// A checker's filter, asked by ids of the hierarchies that its pipeline uses: those of distinct triangles.
#pragma once

#include "check/distinct.h"
#include "check/leaf_pairs.h"
#include "foldproof/check.h"

namespace foldproof::inline internal {

struct Filter {
  const PairFilter* pairs = nullptr;  ///< Null: all pairs are tested.
  DistinctObjects distinct = {};
  bool has_nodes = true;  ///< Whether `pairs` ignores any pair of nodes.

  bool asks_nodes() const { return pairs != nullptr && has_nodes; }
  bool nodes(Index object_a, Index node_a, Index object_b, Index node_b) const {
    return !asks_nodes() ||
           pairs->nodes(object_a, node_of(object_a, node_a), object_b, node_of(object_b, node_b));
  }
  bool vertex_face(Index vertex_object, Index vertex, Index face_object, Index face) const {
    return pairs == nullptr ||
           pairs->vertex_face(vertex_object, vertex, face_object, triangle_of(face_object, face));
  }
  bool edge_edge(Index object_a, const Edge& a, Index object_b, const Edge& b) const {
    return pairs == nullptr || pairs->edge_edge(object_a, a, object_b, b);
  }
  bool crossing(Index object_a, Index triangle_a, Index object_b, Index triangle_b) const {
    return pairs == nullptr || pairs->crossing(object_a, triangle_of(object_a, triangle_a), object_b,
                                               triangle_of(object_b, triangle_b));
  }

 private:
  bool has_copies(Index object) const { return !distinct.empty() && distinct[object]->has_copies(); }
  Index node_of(Index object, Index node) const {
    return has_copies(object) ? distinct[object]->node_id(node) : node;
  }
  // Copies are of one kind, so any of them tells.
  Index triangle_of(Index object, Index triangle) const {
    return has_copies(object) ? distinct[object]->copies(triangle).front() : triangle;
  }
};

/// A filter for the nodes of a traversal.
struct TaskFilter final : NodeFilter {
  TaskFilter(const Filter& of, Index a, Index b) : filter(of), object_a(a), object_b(b) {}
  bool visits(NodePair nodes) const override { return filter.nodes(object_a, nodes.a, object_b, nodes.b); }

  const Filter& filter;
  Index object_a, object_b;
};

}  // namespace foldproof::inline internal
