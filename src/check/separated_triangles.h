/// Pairs of triangles that a plane or an axis separates, so that they do not cross: eight at a time
/// (docs/soundness.md, E4).
#pragma once

#include "foldproof/mesh.h"
#include "foldproof/vec3.h"

namespace foldproof::inline internal {

/// Eight pairs of triangles, one per lane.
struct TrianglePairs {
  /// Two corners with the same number are a common vertex.
  void set(int lane, int side, int corner, const Vec3& x, double number) {
    Corner& c = corners[side][corner];
    for (int axis = 0; axis < 3; ++axis) c.x[axis][lane] = x[axis];
    c.number[lane] = number;
  }

  struct alignas(64) Corner {
    double x[3][8], number[8];
  };
  Corner corners[2][3];
};

/// Bit k is set where the triangles of lane k are proven not to cross (triangles_cross).
unsigned separated_triangles(const TrianglePairs& pairs);

}  // namespace foldproof::inline internal
