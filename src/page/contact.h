/// Where two features meet.
#pragma once

#include <span>

#include "foldproof/check.h"

namespace foldproof {

/// The middle of what two crossing triangles have in common, mesh units; of both where rounding leaves
/// nothing of it.
Vec3 crossing_point(const std::array<Vec3, 3>& a, const std::array<Vec3, 3>& b);

/// The middle between the nearest points of the two features at the time of impact, mesh units. `x0`, `x1`:
/// the ends of the step that found the collision.
Vec3 contact_point(Positions x0, Positions x1, const VertexFaceCollision& collision,
                   std::span<const Triangle> triangles);
Vec3 contact_point(Positions x0, Positions x1, const EdgeEdgeCollision& collision);

}  // namespace foldproof
