/// The curves in which crossing triangles of one contact meet.
#pragma once

#include "contacts/surfaces.h"

namespace foldproof::inline internal {

/// A pair of triangles that cross, and the sides of the contact that they belong to.
struct CrossingPair {
  TriangleCrossing triangles;
  bool reversed;  ///< triangle_b is on the first side.
  Index object(int side) const { return (side == 0) != reversed ? triangles.object_a : triangles.object_b; }
  Index triangle(int side) const {
    return (side == 0) != reversed ? triangles.triangle_a : triangles.triangle_b;
  }
};

/// Where an edge of one side passes through a triangle of the other.
struct Piercing {
  int side;      ///< That of the edge.
  Index object;  ///< Of the edge.
  Edge edge;     ///< The object's own ids; twice the same vertex for one that both triangles have.
  Index face;    ///< Global id; kNoIndex for a common vertex.
  double share;  ///< Where on the edge, from its first vertex, in [0,1].
  Vec3 position;
};

struct Curves {
  /// The pairs of faces that cross where they are displaced: those that were given, and what continues their
  /// curves. Lines and points have no curves.
  std::vector<CrossingPair> pairs;
  bool as_given = false;            ///< These are the pairs that were given.
  std::vector<Piercing> piercings;  ///< Each once, sorted by edge and face.
  struct Segment {
    Index pair;                   ///< Of `pairs`: where its triangles cross.
    std::array<Index, 2> ends{};  ///< Piercings.
  };
  std::vector<Segment> segments;
  std::vector<std::vector<Index>> lines;  ///< Piercings along each curve; a closed one repeats the first.
  bool closed = true;                     ///< All of them.
  bool at_borders = false;                ///< Some end at a border of a surface.
  double length = 0;                      ///< Mesh units.
  double rounding = 0;                    ///< What is not deeper may be so by displacement only; mesh units.
  std::vector<Vec3> pierced;              ///< Where lines go through faces.
};

/// Traces the curves. Which edges pierce which triangles is decided exactly, for positions that are displaced
/// by about 2^-40 of the largest coordinate, the same way whenever positions are the same: so nothing is
/// degenerate, and a curve ends only at borders and where a surface is folded along an edge: triangles with a
/// common edge have none. Triangles that only touch may have none.
void trace_curves(const Surfaces& surfaces, std::span<const CrossingPair> pairs, Positions x, Curves& out);

}  // namespace foldproof::inline internal
