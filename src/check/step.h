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
  /// Not null: a pair's tolerance is its own, and that of the settings is the least, 0 for none. It is at
  /// most that of the scene.
  const PairSettings* pairs = nullptr;

  /// How far apart pairs need not be tested.
  double search_distance(const StepSettings& settings, const StepResult& out) const {
    return settings.thickness + out.tolerance + (pairs != nullptr ? pairs->max_gap : 0);
  }
  /// Tells the narrow phase what else the query says about pairs.
  void set_pairs(const StepSettings& settings, NarrowStep& step) const {
    step.filter = pipeline.filter;
    if (pairs == nullptr) return;
    step.ccd.tolerance = settings.tolerance;
    step.pairs = *pairs;
  }
};

/// StepChecker::check.
Result<void> check_step(const Query& query, Positions x0, Positions x1, const StepSettings& settings,
                        StepResult& out);

/// StepChecker::check_static.
Result<void> check_pose(const Query& query, Positions x, const StepSettings& settings, StaticResult& out);

}  // namespace foldproof::inline internal
