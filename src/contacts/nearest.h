/// The nearest point of a set of triangles.
#pragma once

#include <functional>

#include "foldproof/mesh.h"

namespace foldproof::inline internal {

/// Triangles of one pose: a list at first, a tree of boxes where many points are asked for. Buffers are kept.
class NearestTriangles {
 public:
  /// Replaces the triangles.
  void set(std::span<const std::array<Vec3, 3>> triangles);
  /// The nearest point to `p`; `known`, which is one of the triangles' points, if none is nearer.
  Vec3 nearest(const Vec3& p, const Vec3& known);
  /// Whether a point of the triangle that was given as the `i`-th counts; null: all do. Where the nearest
  /// point of a triangle does not, the triangle is left out.
  std::function<bool(std::size_t i, const Vec3& point)> counts;

 private:
  struct Node {
    Vec3 low, high;
    Index right = 0;  // child; the left one is the next node. 0: a leaf
    Index begin = 0, end = 0;
  };
  struct Ball {
    Vec3 center;
    double radius;
    Index triangle;
  };
  Index build_node(Index begin, Index end);

  std::vector<std::array<Vec3, 3>> triangles_;
  std::vector<Ball> balls_;  // around the triangles, in the order of the leaves
  std::vector<Node> nodes_;  // none: one leaf has all
  std::size_t asked_ = 0;
};

/// The nearest point of a triangle to `p` (Ericson, Real-Time Collision Detection, 5.1.5). Degenerate
/// triangles are fine.
Vec3 nearest_on_triangle(const Vec3& p, const std::array<Vec3, 3>& triangle);

}  // namespace foldproof::inline internal
