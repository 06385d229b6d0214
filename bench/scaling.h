/// How the time of a step grows with the mesh and shrinks with threads, and what training takes.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "measure.h"

namespace foldproof::bench {

/// Tenth steps of the growth scenes: foldproof with certificates alone, and the floor. Error: as measure.
Result<nlohmann::json> measure_growth(Plan plan);

/// Full and tenth steps with 1, 2, 4, ... threads, up to the number of processors, all on the same steps one
/// after the other. Of each number of threads (`teams`): mean milliseconds of wall time, and how
/// many processors they had on average, fewer than threads also on a busy machine. Rows: the growth scenes
/// with about 200,000 triangles and with about 2,000,000. The process must not be pinned to one processor.
Result<nlohmann::json> measure_threads(const Plan& plan);

/// Training with all that it does by default, on the sets of poses of the data that are there. `proven`: of
/// the neighborhoods in all poses, as the model says.
Result<nlohmann::json> measure_training();

}  // namespace foldproof::bench
