/// Inside of ReducedShape.
#pragma once

#include "reduced/pair_tree.h"

namespace foldproof {

struct ReducedShape::Impl {
  std::shared_ptr<const ReducedMotion> motion;
  std::vector<ReducedCentre> centres;
  double clearance = 0;
  std::shared_ptr<const NodeMotions> nodes;
  std::vector<double> stiffness;  ///< Per mode, 1 / deviation.
  PairTree tree;
  std::vector<std::array<Index, 2>> always_open;
  std::vector<double> radius;                  ///< Per centre.
  std::vector<std::vector<LeftOut>> left_out;  ///< Per centre.

  /// The norm of p - centre, rounded up; infinite when it is not a number.
  float distance(Index centre, std::span<const double> p) const;
  /// ReducedShape::find_open; ends where more than `most` pairs stay open.
  ReducedProof find_open(std::span<const double> p0, std::span<const double> p1, std::size_t most,
                         Scratch& scratch) const;
};

}  // namespace foldproof
