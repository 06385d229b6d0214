/// The nearest point of a set of triangles.
#pragma once

#include <functional>

#include "foldproof/mesh.h"

namespace foldproof::inline internal {

/// A tree of boxes over triangles of one pose. Buffers are kept.
class NearestTriangles {
 public:
  /// Replaces the triangles. Cost: O(n log n).
  void build(std::span<const std::array<Vec3, 3>> triangles);
  /// The nearest point to `p`; `known`, which is one of the triangles' points, if none is nearer.
  Vec3 nearest(const Vec3& p, const Vec3& known) const;
  /// Whether a point of the triangle that was given as the `i`-th counts; null: all do. Where the nearest
  /// point of a triangle does not, the triangle is left out.
  std::function<bool(std::size_t i, const Vec3& point)> counts;
  bool empty() const { return nodes_.empty(); }

 private:
  struct Node {
    Vec3 low, high;
    Index right = 0;  // child; the left one is the next node. 0: a leaf
    Index begin = 0, end = 0;
  };
  struct Center {
    Vec3 sum;  // of the corners
    Index triangle;
  };
  Index build_node(std::span<const std::array<Vec3, 3>> triangles, Index begin, Index end);

  std::vector<std::array<Vec3, 3>> triangles_;  // in the order of the leaves
  std::vector<Center> centers_;
  std::vector<Node> nodes_;
};

/// The nearest point of a triangle to `p` (Ericson, Real-Time Collision Detection, 5.1.5). Degenerate
/// triangles are fine.
Vec3 nearest_on_triangle(const Vec3& p, const std::array<Vec3, 3>& triangle);

}  // namespace foldproof::inline internal
