/// Inside of ReducedShape.
#pragma once

#include "reduced/pair_tree.h"

namespace foldproof {

struct ReducedShape::Impl {
  std::shared_ptr<const ReducedMotion> motion;
  std::vector<ReducedCenter> centers;
  std::shared_ptr<const NodeMotions> nodes;
  std::vector<double> inverse_deviations;  ///< Per mode, 1 / deviation.
  ReducedBalls balls;
  std::vector<float> radii;  ///< [pair][center]: of balls, with those below counted in (PairTreeResult).
  std::vector<std::array<Index, 2>> never_certified;
  std::vector<double> radius;                             ///< Per center.
  std::vector<std::vector<UncertifiedPair>> uncertified;  ///< Per center.

  /// Takes balls of these centers. Precondition: are_balls_of.
  void use(ReducedBalls given, std::span<const CenterPose> poses);
  /// The norm of p - center, rounded up; infinite when it is not a number.
  float distance(Index center, std::span<const double> p) const;
  /// ReducedShape::find_unproven, which ends once more than `max_unproven` pairs stay unproven.
  ReducedProof find_unproven(std::span<const double> p0, std::span<const double> p1, std::size_t max_unproven,
                             Scratch& scratch) const;
};

}  // namespace foldproof
