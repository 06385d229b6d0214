/// The answer to a step: what the settings may ask for, and what was found, sorted and cut to what is listed.
#pragma once

#include "check/narrow_phase.h"

namespace foldproof {

Result<void> check_settings(const StepSettings& settings);
/// The tolerance to use when everything lies in a box of this side.
double tolerance_for(const StepSettings& settings, double side);

void clear(StepResult& out);
/// Adds what a chunk found to the answer, and forgets it there.
void take_found(const NarrowStep& step, Chunk& chunk, StepResult& out);
/// Sorts by ids; with StepSettings::earliest_only, keeps the earliest.
void finish(const StepSettings& settings, StepResult& out);
/// What is said of the triangles that were looked at becomes what is said of all.
void spread(DistinctObjects distinct, Explanation& explanation);

}  // namespace foldproof
