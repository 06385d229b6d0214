/// What the library's answers are held against. Nothing here is shared with it but types.
#pragma once

#include <string>

#include "adversary/case.h"
#include "oracle/oracle.h"

namespace foldproof::adversary {

/// Two features in motion.
struct Features {
  oracle::Kind kind;
  FourPoints x0, x1;
};

/// True only when the features stay farther apart than `bound` (mesh units) throughout: by boxes and planes
/// in extended precision, with room for its rounding.
bool surely_beyond(const Features& pair, double bound);

/// Exactly: do they come as near as `distance`? With a distance other than 0, where exact brackets do not
/// settle it in short time, no.
bool comes_within(const Features& pair, double distance);

std::string describe(const Features& pair);

}  // namespace foldproof::adversary
