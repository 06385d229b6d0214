/// Sweep and prune: which objects come near each other.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "foldproof/base.h"

namespace foldproof::inline internal {

/// Bounds an object during a whole step.
struct SweptBox {
  std::array<double, 3> low, high;
};

/// Sweep and prune (Baraff 1992) over boxes of whole objects. Buffers are kept.
class SweepAndPrune {
 public:
  using Pair = std::array<Index, 2>;
  /// Pairs a < b of boxes whose distance along every axis is at most `distance`, ascending. Cost: O(n log n)
  /// plus the pairs that overlap along the axis on which the boxes' centers spread most. Valid until the next
  /// call.
  std::span<const Pair> pairs(std::span<const SweptBox> boxes, double distance);

 private:
  std::vector<Index> order_;
  std::vector<Pair> pairs_;
};

}  // namespace foldproof::inline internal
