/// A moving average for heuristics.
#pragma once

namespace foldproof::inline internal {

/// Adds a value to an exponential moving average with weight 1/2; a mean of 0 has no value yet.
inline void add_to_mean(double& mean, double value) { mean = mean > 0 ? (mean + value) / 2 : value; }

}  // namespace foldproof::inline internal
