/// From measurements to JSON, of which tools/bench_tables makes tables and a page.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "measure.h"

namespace foldproof::bench {

/// Measures scenes, with a line on the error stream for each row: what `measure` says of them, step by step.
Result<nlohmann::json> measure_scenes(const std::vector<SceneInfo>& scenes, const Plan& plan);

}  // namespace foldproof::bench
