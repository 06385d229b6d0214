/// Filters that say what is meant: pairs that a StepChecker, ContactFinder or ContactChecker does not test
/// because they are sewn, neighbors, fixed, or touch anyway.
///
/// What a filter ignores is not found, however deep it goes: each says which pairs that are.
#pragma once

#include "foldproof/check.h"

namespace foldproof {

/// A vertex of an object, by its place in the list of objects.
struct ObjectVertex {
  Index object, vertex;
};

/// Ignores what meets at a seam: pairs of features or triangles that contain one each of two vertices that
/// are sewn to each other. In poses such triangles are ignored altogether, folds too. A vertex sewn to itself
/// changes nothing. Sew a vertex on an edge (a T-junction) to both ends of it, one in a
/// face to its three corners, three vertices at a place each to each. Error: an object or a vertex out of
/// range.
Result<std::shared_ptr<const PairFilter>> ignore_sewn(std::span<const Object> objects,
                                                      std::span<const std::array<ObjectVertex, 2>> seams);

/// Ignores neighbors: pairs within one object that contain one vertex each with a path of at most `rings`
/// edges between them; 0: a common vertex. For a thickness that is larger than an edge. Folds of this size
/// are not found in poses either. Memory: 8 bytes per vertex and vertex that near; cost: in proportion.
Result<std::shared_ptr<const PairFilter>> ignore_rings(std::span<const Object> objects, Index rings);

/// The same with paths along edges of at most this length in the pose x, mesh units. Error: a length that is
/// negative or not finite; positions of the wrong size or not finite.
Result<std::shared_ptr<const PairFilter>> ignore_length(std::span<const Object> objects, Positions x,
                                                        double length);

/// Ignores pairs that cannot move relative to each other: all of whose vertices are fixed. `fixed`: per
/// object a number per vertex, not 0 where it is fixed. Costs nothing where whole nodes are fixed. Error:
/// other sizes.
Result<std::shared_ptr<const PairFilter>> ignore_fixed(std::span<const Object> objects,
                                                       std::span<const std::vector<std::uint8_t>> fixed);

/// Ignores the pairs that are found in the pose x: features within `thickness` (as StepSettings has it) and
/// triangles that cross, and triangles around such features. Error: more than 10,000,000 pairs; those of
/// StepChecker. Memory: 24 bytes per pair.
Result<std::shared_ptr<const PairFilter>> ignore_touching(const std::vector<Object>& objects, Positions x,
                                                          double thickness = 0);

/// Ignores what any of the filters ignores; none of them is null.
std::shared_ptr<const PairFilter> ignore_all(std::vector<std::shared_ptr<const PairFilter>> filters);

}  // namespace foldproof
