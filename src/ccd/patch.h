/// The Minkowski difference of two features: a triangle (vertex-face) or a parallelogram (edge-edge).
#pragma once

#include "foldproof/ccd.h"

namespace foldproof {

/// Corners 0,1,2 (and 3 for a parallelogram, opposite to corner 0). Sides run 0-1 and 0-2.
using PatchCorners = std::array<Vec3, 4>;

inline PatchCorners vertex_face_corners(const FourPoints& x, double scale) {
  const Vec3 v = x[0] * scale;
  return {v - x[1] * scale, v - x[2] * scale, v - x[3] * scale, Vec3::Zero()};
}

inline PatchCorners edge_edge_corners(const FourPoints& x, double scale) {
  const Vec3 a0 = x[0] * scale, a1 = x[1] * scale, b0 = x[2] * scale, b1 = x[3] * scale;
  return {a0 - b0, a1 - b0, a0 - b1, a1 - b1};
}

struct PatchClosest {
  double distance;  ///< Length of `difference`.
  Vec3 difference;  ///< A point of the patch, nearest to the origin as far as doubles can tell.
  Vec3 normal;      ///< Direction, of length one, along which the patch lies farthest from the origin (N6).
};

/// `corners` is 3 or 4.
PatchClosest closest_to_origin(const PatchCorners& d, int corners);

}  // namespace foldproof
