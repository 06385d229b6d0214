/// Hierarchy: connected surface patches at the leaves, built once per topology, refitted per step.
#pragma once

#include <vector>

#include "foldproof/mesh.h"

namespace foldproof {

struct HierarchySettings {
  Index leaf_triangles = 12;  ///< Triangles per leaf patch, approximately: up to a quarter more.
};

/// The tree over one topology. Immutable once built; any number of threads may use it.
///
/// Nodes are in depth-first order: the root first, a parent before its children. Leaves are numbered from
/// left to right and own consecutive runs of triangles, edges and vertices in *leaf order*; so a subtree owns
/// a consecutive run of each as well. Every triangle, every edge and every vertex that a triangle uses has
/// exactly one owner, so each feature pair appears once.
///
/// Faces, lines and points lie in leaves of their own, in this order. So a leaf of lines owns no vertex or
/// edge of a face, and a leaf of points only vertices of neither.
class Hierarchy {
 public:
  struct Node {
    Index right = 0;       ///< Right child; the left child is the next node. 0 for a leaf.
    Index leaf_begin = 0;  ///< Leaves below this node: [leaf_begin, leaf_end).
    Index leaf_end = 0;
    bool is_leaf() const { return right == 0; }
  };
  /// First owned triangle, edge and vertex of a leaf, as indices in leaf order. One extra entry at the end.
  struct Leaf {
    Index triangles, edges, vertices;
  };

  /// `positions`: vertex_count x 3, row-major; any pose, it decides how patches are split. Error: positions
  /// have the wrong size or are not finite. Cost: O(n log n), about a microsecond per triangle. Uses the
  /// caller's oneTBB arena; the tree is the same for any number of threads.
  static Result<Hierarchy> build(Topology topology, std::span<const double> positions,
                                 const HierarchySettings& settings = {});

  /// Restores a hierarchy from its stored parts: its triangle_ids(), and for every node in depth-first order
  /// the number of triangles that it owns as a leaf, 0 for an inner node. Error: they do not form a hierarchy
  /// of this topology, leaves of faces, lines and points are mixed, or there are more than 1,024 levels.
  static Result<Hierarchy> from_parts(Topology topology, std::vector<Index> triangle_ids,
                                      std::span<const Index> leaf_sizes);

  const Topology& topology() const { return topology_; }
  std::span<const Node> nodes() const { return nodes_; }
  std::span<const Leaf> leaves() const { return leaves_; }
  Index leaf_count() const { return leaves_.empty() ? 0 : static_cast<Index>(leaves_.size()) - 1; }
  /// What all triangles of a leaf are.
  Element element(Index leaf) const { return topology_.element(leaves_[leaf].triangles); }

  /// Leaf order -> the user's id.
  std::span<const Index> vertex_ids() const { return vertex_ids_; }
  std::span<const Index> edge_ids() const { return edge_ids_; }
  std::span<const Index> triangle_ids() const { return triangle_ids_; }

  /// Edges and triangles in leaf order, with vertices as indices in leaf order. An edge keeps the order of
  /// its ends in the topology, a triangle that of the user.
  std::span<const Edge> edges() const { return edges_; }
  std::span<const Triangle> triangles() const { return triangles_; }

 private:
  bool build_nodes(std::span<const Index> leaf_sizes);
  bool elements_are_apart() const;
  void compute_leaf_ranges();
  void assign_owners();

  Topology topology_;
  std::vector<Node> nodes_;
  std::vector<Leaf> leaves_;
  std::vector<Index> vertex_ids_, edge_ids_, triangle_ids_;
  std::vector<Edge> edges_;
  std::vector<Triangle> triangles_;
};

}  // namespace foldproof
