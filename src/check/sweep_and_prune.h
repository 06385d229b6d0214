/// Which of many objects come near each other at all.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "foldproof/base.h"

namespace foldproof {

/// Holds an object during a whole step.
struct SweptBox {
  std::array<double, 3> low, high;
};

/// Sort and sweep (Baraff 1992) over boxes of whole objects. Buffers are kept.
class SweepAndPrune {
 public:
  using Pair = std::array<Index, 2>;
  /// Pairs a < b of boxes that no axis keeps farther apart than `distance`, ascending. Cost: O(n log n) and
  /// the pairs that overlap along the axis on which the boxes' middles spread most. Valid until the next
  /// call.
  std::span<const Pair> pairs(std::span<const SweptBox> boxes, double distance);

 private:
  std::vector<Index> order_;
  std::vector<Pair> pairs_;
};

}  // namespace foldproof
