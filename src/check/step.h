/// The queries, from positions to the answer: steps and poses.
#pragma once

#include "check/look_ahead.h"

namespace foldproof::inline internal {

/// The objects of a query and its scratch.
struct Query {
  Pipeline& pipeline;
  LookAhead* look_ahead = nullptr;       ///< Null: every step has a search of its own.
  std::span<const Object> objects = {};  ///< The pipeline's. Empty: none is layered.
  /// Whether there is a collision or crossing is all that matters; the answer may have any.
  bool any_will_do = false;
};

/// StepChecker::check.
Result<void> check_step(const Query& query, Positions x0, Positions x1, const StepSettings& settings,
                        StepResult& out);

/// StepChecker::check_static.
Result<void> check_pose(const Query& query, Positions x, const StepSettings& settings, StaticResult& out);

}  // namespace foldproof::inline internal
