/// Filters that look at nothing but the vertices of two features or triangles.
#pragma once

#include "foldproof/check.h"

namespace foldproof::inline internal {

class ByVertices : public PairFilter {
 public:
  explicit ByVertices(std::span<const Object> objects) {
    for (const Object& object : objects) hierarchies_.push_back(object.hierarchy());
  }
  bool vertex_face(Index vertex_object, Index vertex, Index face_object, Index face) const final {
    return tests(vertex_object, std::span(&vertex, 1), face_object, triangle(face_object, face));
  }
  bool edge_edge(Index object_a, const Edge& a, Index object_b, const Edge& b) const final {
    return tests(object_a, a, object_b, b);
  }
  bool crossing(Index object_a, Index triangle_a, Index object_b, Index triangle_b) const final {
    return tests(object_a, triangle(object_a, triangle_a), object_b, triangle(object_b, triangle_b));
  }
  Index kind(Index, Index) const final { return 0; }

 private:
  /// Whether features or triangles with these vertices are tested.
  virtual bool tests(Index object_a, std::span<const Index> a, Index object_b,
                     std::span<const Index> b) const = 0;
  const Triangle& triangle(Index object, Index triangle) const {
    return hierarchies_[object]->topology().triangles()[triangle];
  }
  std::vector<std::shared_ptr<const Hierarchy>> hierarchies_;
};

/// Ignores all pairs but those that ignore_fixed ignores. Precondition: its sizes.
std::shared_ptr<const PairFilter> ignore_all_but_fixed(std::span<const Object> objects,
                                                       std::span<const std::vector<std::uint8_t>> fixed);

}  // namespace foldproof::inline internal
