/// The answer of a step: validates its settings; collects, sorts and limits its collisions.
#pragma once

#include "check/narrow_phase.h"

namespace foldproof::inline internal {

/// Error: a setting is out of its range, or nothing is asked.
Result<void> check_settings(const StepSettings& settings, std::size_t objects);
/// The tolerance to use in a scene whose bounding box has this largest side.
double tolerance_for(const StepSettings& settings, double extent);

void clear(StepResult& out);
/// Adds the collisions of a chunk to the answer.
void add_collisions(const NarrowStep& step, const Hits& hits, StepResult& out);
/// Sorts by ids. With StepSettings::earliest_only, keeps only the earliest.
void finish(const StepSettings& settings, StepResult& out);
/// Copies the explanation of distinct triangles to all their copies.
void explain_copies(DistinctObjects distinct, Explanation& explanation);

}  // namespace foldproof::inline internal
