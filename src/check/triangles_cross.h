/// Whether two triangles cross, in exact arithmetic (docs/soundness.md, E3).
#pragma once

#include "check/motion.h"
#include "foldproof/ccd.h"

namespace foldproof::inline internal {

/// The corners of a triangle. `x`: positions of its object.
inline std::array<Vec3, 3> corners(std::span<const double> x, const Triangle& t) {
  return {position(x, t[0]), position(x, t[1]), position(x, t[2])};
}

/// Whether the vertices of two triangles are the same, in any order.
bool have_same_vertices(Triangle a, Triangle b);

/// Whether two triangles with the same vertices cross: always, even without an area, because they cross as
/// soon as they have one. Not when they name a vertex twice: they are a shared edge or vertex.
bool copies_cross(const Triangle& t);

/// Whether two triangles of one object, in the pose `x`, meet beyond their common vertices and edges.
/// Triangles of two objects cross when they have a common point: triangles_intersect.
bool triangles_cross(std::span<const double> x, const Triangle& s, const Triangle& t);

}  // namespace foldproof::inline internal
