/// Inside of StepChecker: what continuous and static queries share.
#pragma once

#include "query/forecast.h"

namespace foldproof {

/// StepChecker::check on the pairs that count; all when `choice` is null. Without a forecast every step is
/// searched for itself.
Result<void> check_step(Scene& scene, std::vector<Chunk>& chunks, Forecast* forecast, Positions x0,
                        Positions x1, const StepSettings& settings, const PairChoice* choice,
                        StepResult& out);

/// StepChecker::check_static.
Result<void> check_pose(Scene& scene, std::vector<Chunk>& chunks, Positions x, const StepSettings& settings,
                        StaticResult& out);

struct StepChecker::Impl {
  Scene scene;
  std::vector<Chunk> chunks;
  Forecast forecast;
};

}  // namespace foldproof
