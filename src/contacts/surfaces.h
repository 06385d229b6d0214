/// The meshes of a check as one: ids over all objects, and the triangles around each vertex.
#pragma once

#include <algorithm>
#include <memory>

#include "contacts/shells.h"

namespace foldproof::inline internal {

/// Ids over all objects are called global; those of an object begin at its offset.
class Surfaces {
 public:
  explicit Surfaces(std::vector<const Topology*> topologies);

  Index object_count() const { return static_cast<Index>(topologies_.size()); }
  Index vertex_count() const { return vertex_offsets_.back(); }
  Index triangle_count() const { return triangle_offsets_.back(); }
  const Topology& topology(Index object) const { return *topologies_[object]; }

  Index vertex(Index object, Index local) const { return vertex_offsets_[object] + local; }
  Index triangle(Index object, Index local) const { return triangle_offsets_[object] + local; }
  /// The object and its own id of a triangle with a global one.
  std::array<Index, 2> local_triangle(Index global) const {
    const auto after = std::upper_bound(triangle_offsets_.begin(), triangle_offsets_.end(), global);
    return {static_cast<Index>(after - triangle_offsets_.begin() - 1), global - *(after - 1)};
  }
  const Shells& shells(Index object) const { return stars_[object]->shells; }
  /// Whether a triangle is a face: the contacts of others have no curves, regions and depth.
  bool is_face(Index object, Index triangle) const { return triangle < topologies_[object]->face_count(); }
  /// Whether a vertex or an edge, whose vertices are in any order, is one of a face.
  bool is_of_face(Index object, Index vertex) const {
    return is_face(object, triangles_at(object, vertex).front());
  }
  bool is_of_face(Index object, const Edge& edge) const;
  /// The corners of a triangle, as global ids.
  Triangle corners(Index object, Index triangle) const {
    Triangle t = topologies_[object]->triangles()[triangle];
    for (Index& v : t) v += vertex_offsets_[object];
    return t;
  }
  /// The triangles of the same object that name a vertex, ascending; all ids are the object's own.
  std::span<const Index> triangles_at(Index object, Index vertex) const {
    const Stars& s = *stars_[object];
    return std::span(s.triangles).subspan(s.begin[vertex], s.begin[vertex + 1] - s.begin[vertex]);
  }
  /// How many vertices have an edge with one; a global id.
  std::size_t neighbor_count(Index vertex) const {
    const auto [object, local] = local_vertex(vertex);
    const Stars& s = *stars_[object];
    return s.neighbors_begin[local + 1] - s.neighbors_begin[local];
  }
  /// Calls visit(neighbor) with the vertices that have an edge with one; global ids.
  template <class Visit>
  void for_each_neighbor(Index vertex, const Visit& visit) const {
    const auto [object, local] = local_vertex(vertex);
    for_each_neighbor(object, local, [&, first = vertex - local](Index v) { visit(first + v); });
  }
  /// The same by the object's own ids.
  template <class Visit>
  void for_each_neighbor(Index object, Index vertex, const Visit& visit) const {
    const Stars& s = *stars_[object];
    for (Index i = s.neighbors_begin[vertex]; i < s.neighbors_begin[vertex + 1]; ++i) visit(s.neighbors[i]);
  }
  /// The same for those neighbors only that have more edges, or as many and a larger id. A vertex of many
  /// edges has few of them: n edges give all vertices at most sqrt(2 n) each.
  template <class Visit>
  void for_each_higher_neighbor(Index vertex, const Visit& visit) const {
    const auto [object, local] = local_vertex(vertex);
    const Stars& s = *stars_[object];
    for (Index i = s.higher_begin[local]; i < s.neighbors_begin[local + 1]; ++i)
      visit(vertex - local + s.neighbors[i]);
  }
  /// The most triangles that an edge of an object has.
  Index most_at_edge(Index object) const { return stars_[object]->most_at_edge; }
  /// The triangles of an object that have an edge, ascending; all ids are the object's own.
  void triangles_with_edge(Index object, const Edge& edge, std::vector<Index>& out) const;

 private:
  struct Stars {
    explicit Stars(const Topology& topology);
    void list_neighbors(const Topology& topology);
    std::vector<Index> begin, triangles;
    std::vector<Index> neighbors_begin, neighbors, higher_begin;  // the higher ones are last
    Index most_at_edge = 0;
    Shells shells;
  };
  template <class Visit>
  void for_each_with_edge(Index object, const Edge& edge, const Visit& visit) const;
  std::array<Index, 2> local_vertex(Index global) const {
    if (vertex_offsets_.size() == 2) return {0, global};
    const auto after = std::upper_bound(vertex_offsets_.begin(), vertex_offsets_.end(), global);
    return {static_cast<Index>(after - vertex_offsets_.begin() - 1), global - *(after - 1)};
  }

  std::vector<const Topology*> topologies_;
  std::vector<std::shared_ptr<const Stars>> stars_;  // objects of one topology share them
  std::vector<Index> vertex_offsets_, triangle_offsets_;
};

}  // namespace foldproof::inline internal
