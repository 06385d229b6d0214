/// Inside of ReducedShape.
#pragma once

#include "reduced/pair_tree.h"

namespace foldproof {

struct ReducedShape::Impl {
  std::shared_ptr<const ReducedMotion> motion;
  std::vector<ReducedCenter> centers;
  double clearance = 0;
  std::shared_ptr<const NodeMotions> nodes;
  std::vector<double> inverse_deviations;  ///< Per mode, 1 / deviation.
  PairTree tree;
  std::vector<std::array<Index, 2>> never_certified;
  std::vector<double> radius;                             ///< Per center.
  std::vector<std::vector<UncertifiedPair>> uncertified;  ///< Per center.

  /// The norm of p - center, rounded up; infinite when it is not a number.
  float distance(Index center, std::span<const double> p) const;
  /// ReducedShape::find_unproven, which ends once more than `max_unproven` pairs stay unproven.
  ReducedProof find_unproven(std::span<const double> p0, std::span<const double> p1, std::size_t max_unproven,
                             Scratch& scratch) const;
};

}  // namespace foldproof
