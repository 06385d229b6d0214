/// Which triangles cross at the end of a step, from those that cross at its begin and the step's answer.
#pragma once

#include "contacts/surfaces.h"

namespace foldproof::inline internal {

/// Whether the smaller ids come first, by (object_a, triangle_a, object_b, triangle_b).
bool is_before(const TriangleCrossing& a, const TriangleCrossing& b);

/// Replaces `crossings`, those at the begin of a step, sorted, by those at its end, sorted. Only pairs of
/// triangles with a colliding pair of features are tested, exactly; others cross at the end if and only if
/// they do at the begin (docs/soundness.md, corollary of Theorem 3). `step` lists all of its pairs; pairs of
/// triangles that `filter` ignores, unless it is null, are left out. `tested` is scratch.
void follow_crossings(const Surfaces& surfaces, const PairFilter* filter, const StepResult& step,
                      Positions x1, std::vector<TriangleCrossing>& tested,
                      std::vector<TriangleCrossing>& crossings);

}  // namespace foldproof::inline internal
