/// What heuristics remember of steps.
#pragma once

namespace foldproof {

/// A mean in which each value counts half of the one after it; 0 stands for no value yet.
inline void add_to_mean(double& mean, double value) { mean = mean > 0 ? (mean + value) / 2 : value; }

}  // namespace foldproof
