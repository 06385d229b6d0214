/// How many processors could share a step: its loops, run on one thread and timed piece by piece.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "measure.h"

namespace foldproof::bench {

/// Full steps and smooth tenths of the motions, full steps of ground truth, and of the growth scenes with
/// about 200,000 and 2,000,000 triangles. `speedup_2` and `speedup_16`: how many times sooner so many
/// processors would end a step, if a free one takes the next piece and each loop and piece costs what oneTBB
/// takes. `serial`: milliseconds outside of all loops; `imbalance`: what 16 processors wait for those with
/// the last pieces. Error: foldproof was not built with FOLDPROOF_THREADS=record.
Result<nlohmann::json> measure_span(std::span<const SceneInfo> scenes, const Plan& plan);

}  // namespace foldproof::bench
