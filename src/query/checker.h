/// Inside of StepChecker: what continuous and static queries share.
#pragma once

#include "query/forecast.h"

namespace foldproof {

/// What is asked about, and what it takes.
struct Question {
  Scene& scene;
  std::vector<Chunk>& chunks;
  Forecast* forecast = nullptr;        ///< Without one every step is searched for itself.
  const PairChoice* choice = nullptr;  ///< Which pairs count; all when it is null.
  DistinctObjects distinct = {};  ///< Of whose hierarchies the scene is; empty where nothing was left out.
};

/// StepChecker::check.
Result<void> check_step(const Question& question, Positions x0, Positions x1, const StepSettings& settings,
                        StepResult& out);

/// StepChecker::check_static.
Result<void> check_pose(const Question& question, Positions x, const StepSettings& settings,
                        StaticResult& out);

struct StepChecker::Impl {
  std::vector<std::shared_ptr<const DistinctTriangles>> distinct;
  Scene scene;
  std::vector<Chunk> chunks;
  Forecast forecast;
};

}  // namespace foldproof
