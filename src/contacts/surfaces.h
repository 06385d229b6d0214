/// The meshes of a check as one: ids over all objects, and the triangles around each vertex.
#pragma once

#include <memory>

#include "foldproof/check.h"

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
  /// Whether a triangle is a face: the contacts of others have no curves, regions and depth.
  bool is_face(Index object, Index triangle) const { return triangle < topologies_[object]->face_count(); }
  /// Whether a vertex or an edge is one of a face.
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
  /// The triangles of an object that have an edge, ascending; all ids are the object's own.
  void triangles_with_edge(Index object, const Edge& edge, std::vector<Index>& out) const;

 private:
  struct Stars {
    std::vector<Index> begin, triangles;
  };
  static std::shared_ptr<const Stars> stars_of(const Topology& topology);

  std::vector<const Topology*> topologies_;
  std::vector<std::shared_ptr<const Stars>> stars_;  // objects of one topology share them
  std::vector<Index> vertex_offsets_, triangle_offsets_;
};

}  // namespace foldproof::inline internal
