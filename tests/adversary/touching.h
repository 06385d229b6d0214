/// Single pairs of features and of triangles whose answer is known by how they are made: quick to ask, so
/// that rounding that is not allowed for shows soon.
#pragma once

#include "adversary/pairs.h"

namespace foldproof::adversary {

/// Asks about some. A complaint, or nothing.
std::string ask_touching(Source& source, Tally& tally);

}  // namespace foldproof::adversary
