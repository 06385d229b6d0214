/// Long steps, cut in time.
#pragma once

#include "check/step.h"

namespace foldproof::inline internal {

/// Whether leaves move so far in a step that most of the space that they sweep is not theirs, after an update
/// of the motion.
bool is_long(const StepMotion& motion);

/// Answers for a long step, after an update of the motion, which it overwrites: searches one stretch of the
/// time after the other, each as a step of its own; with `earliest_only` as far as the first collision. Where
/// `any_will_do` of the query, ends with the first stretch in which something collides, early or late. Adds
/// to `out`. Error: as StepMotion::update and Pipeline::find_leaf_pairs.
Result<void> check_in_stretches(const Query& query, Positions x0, Positions x1, const StepSettings& settings,
                                StepResult& out);

}  // namespace foldproof::inline internal
