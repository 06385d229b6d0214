/// Every pair of features, one after the other: slow, and too simple to be wrong.
#pragma once

#include <vector>

#include "oracle/families.h"
#include "oracle/meshes.h"
#include "oracle/same_answers.h"

namespace foldproof::oracle {

/// A feature pair of a scene by the user's ids, vertex and face or two edges, with its place in the library's
/// answer.
struct PairPoints {
  FourPoints x0, x1;
};
PairPoints points_of(const VertexFaceCollision& pair, const Scene& scene);
PairPoints points_of(const EdgeEdgeCollision& pair, const Scene& scene);

/// What StepChecker::check should answer when its narrow phase uses `tolerance`: the narrow phase called on
/// every pair that has no vertex in common and whose swept boxes are not clearly apart. Vertices in no
/// triangle take no part.
StepResult brute_force_step(const Scene& scene, const StepSettings& settings, double tolerance);

/// What StepChecker::check_static should answer at the start of the step, by exact integer arithmetic.
StaticResult brute_force_static(const Scene& scene, const StepSettings& settings);

/// Exactly: do two triangles, given by vertex ids, have a point in common beyond their common vertices and
/// edges?
bool triangles_cross(const Triangle& a, const Triangle& b, std::span<const double> positions);

}  // namespace foldproof::oracle
