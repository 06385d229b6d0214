// A barrier on the pairs that are close. It has no mollifier for edges that are nearly parallel.
#pragma once

#include "foldproof/solver.h"

namespace example {

using Contact = foldproof::ClosePair;

// -stiffness (d/reach - 1)^2 ln(d/reach), as incremental potential contact has it; joules. Zero from reach
// on, infinite at 0.
struct Barrier {
  double reach;
  double stiffness;
  double value(double d) const;
  double slope(double d) const;
  double curvature(double d) const;
};

}  // namespace example
