/// Steps and poses, from positions to the answer.
#pragma once

#include "check/look_ahead.h"

namespace foldproof {

/// What is asked about, and what it takes.
struct Query {
  Pipeline& pipeline;
  LookAhead* look_ahead = nullptr;     ///< Without it every step is searched for itself.
  const PairFilter* filter = nullptr;  ///< Which pairs count; all when it is null.
  DistinctObjects distinct = {};  ///< Of whose hierarchies the pipeline is; empty where nothing was left out.
};

/// StepChecker::check.
Result<void> check_step(const Query& query, Positions x0, Positions x1, const StepSettings& settings,
                        StepResult& out);

/// StepChecker::check_static.
Result<void> check_pose(const Query& query, Positions x, const StepSettings& settings, StaticResult& out);

struct StepChecker::Impl {
  std::vector<std::shared_ptr<const DistinctTriangles>> distinct;
  Pipeline pipeline;
  LookAhead look_ahead;
};

}  // namespace foldproof
