/// A plane between two patches for a whole step: Theorem 1 along any axis.
#pragma once

#include <array>

#include "bvh/kinetic.h"

namespace foldproof {

/// A direction that may separate two sets: the normal of a plane between them, towards the first. Zero: none
/// is known.
using PlaneNormal = std::array<float, 3>;

/// True: during the step the convex hulls of the two sets of vertices stay farther apart than `gap` (in the
/// frame of the vertices). False promises nothing. The sets are not empty. `normal`, where given, is tried
/// first and set to what separates.
bool plane_separates(std::span<const MovingVertex> vertices_a, std::span<const Index> a,
                     std::span<const MovingVertex> vertices_b, std::span<const Index> b, double gap,
                     PlaneNormal* normal = nullptr);

}  // namespace foldproof
