/// What a step costs when the motion is told by coordinates of a subspace: one shape at several resolutions.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "foldproof/base.h"

namespace foldproof::bench {

struct ReducedPlan {
  Index largest = 1'000'000;  ///< Triangles; sizes go up to it in powers of ten from 10,000.
  Index steps = 30;
  bool processor_time = false;
};

/// A generated tube that bends, twists and bulges, with six modes; a row per resolution and distance from the
/// mean. Error: a step collides, or cannot be checked.
Result<nlohmann::json> measure_reduced(const ReducedPlan& plan);

}  // namespace foldproof::bench
