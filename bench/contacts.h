/// What finding contacts costs, beside the check of the same steps.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "scene.h"

namespace foldproof::bench {

/// Rows: a motion, all of whose full steps are checked. Error: a scene cannot be read.
Result<nlohmann::json> measure_contacts(const std::vector<SceneInfo>& scenes, bool processor_time);

}  // namespace foldproof::bench
