/// Times for people to read.
#pragma once

#include <string>

namespace foldproof::inline internal {

/// A duration in words, with three digits at most: "0.42 ms", "12.3 ms", "1.67 s", "2 min 5 s", "3 h 12 min".
std::string duration(double milliseconds);

}  // namespace foldproof::inline internal
