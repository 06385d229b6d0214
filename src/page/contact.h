/// Points at which features meet.
#pragma once

#include <span>

#include "foldproof/check.h"

namespace foldproof {

/// The midpoint of the segment that two crossing triangles share, mesh units. The mean of their corners if
/// rounding leaves no such segment.
Vec3 crossing_point(const std::array<Vec3, 3>& a, const std::array<Vec3, 3>& b);

/// The midpoint between the nearest points of the two features at the time of impact, mesh units. `x0`, `x1`:
/// positions at the start and the end of the step.
Vec3 contact_point(Positions x0, Positions x1, const VertexFaceCollision& collision,
                   std::span<const Triangle> triangles);
Vec3 contact_point(Positions x0, Positions x1, const EdgeEdgeCollision& collision);

}  // namespace foldproof
