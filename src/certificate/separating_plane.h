/// A plane between two patches for a whole step: Theorem 1 along any axis.
#pragma once

#include <array>

#include "bvh/kinetic_bvh.h"

namespace foldproof::inline internal {

/// The normal of a plane between two sets, towards the first; zero where none is known.
using PlaneNormal = std::array<float, 3>;

/// True: the convex hulls of two sets of vertices stay farther apart than `gap` during the step. `gap`: in
/// the frame of the vertices. False promises nothing. `normal` is tried first, then those near it; it is set
/// to one that separates. Precondition: the sets are not empty.
bool plane_separates(std::span<const MovingVertex> vertices_a, std::span<const Index> a,
                     std::span<const MovingVertex> vertices_b, std::span<const Index> b, double gap,
                     PlaneNormal* normal = nullptr);

}  // namespace foldproof::inline internal
