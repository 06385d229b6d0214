/// Inside of StepChecker: what continuous and static queries share.
#pragma once

#include "query/narrow.h"
#include "query/scene.h"

namespace foldproof {

/// StepChecker::check on the pairs that count; all when `choice` is null.
Result<void> check_step(Scene& scene, std::vector<Chunk>& chunks, Positions x0, Positions x1,
                        const StepSettings& settings, const PairChoice* choice, StepResult& out);

/// StepChecker::check_static.
Result<void> check_pose(Scene& scene, std::vector<Chunk>& chunks, Positions x, const StepSettings& settings,
                        StaticResult& out);

struct StepChecker::Impl {
  Scene scene;
  std::vector<Chunk> chunks;
};

}  // namespace foldproof
