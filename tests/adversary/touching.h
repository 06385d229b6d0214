/// Single pairs of features that are built to touch, and of triangles in one plane that nearly do. A pair
/// takes microseconds, so errors in the bounds of rounding and underflow show soon.
#pragma once

#include "adversary/pairs.h"

namespace foldproof::adversary {

/// Checks some of both. A complaint, or nothing.
std::string ask_touching(Source& source, Tally& tally);

}  // namespace foldproof::adversary
