/// Shapes in which many triangles meet at a vertex or an edge, or coincide.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "foldproof/base.h"

namespace foldproof::bench {

/// Times each family at n, 2n and 4n: the first pose of a new checker, and the mean of five steps of another.
/// `size`: triangles and answers. The exponent e fits time ~ size^e between the smallest and the largest.
Result<nlohmann::json> measure_families(bool processor_time);

}  // namespace foldproof::bench
