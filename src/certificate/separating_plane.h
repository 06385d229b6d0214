/// A plane between two patches for a whole step: Theorem 1 along any axis.
#pragma once

#include "bvh/kinetic.h"

namespace foldproof {

/// True: during the step the convex hulls of the two sets of vertices stay farther apart than `gap` (in the
/// frame of the vertices). False promises nothing. The sets are not empty.
bool plane_separates(std::span<const MovingVertex> vertices_a, std::span<const Index> a,
                     std::span<const MovingVertex> vertices_b, std::span<const Index> b, double gap);

}  // namespace foldproof
