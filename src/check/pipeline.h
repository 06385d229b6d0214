/// The pipeline of a query on a set of objects. Its stages: motion, broad phase, culling, narrow phase.
#pragma once

#include "check/broad_phase.h"
#include "check/narrow_phase.h"

namespace foldproof::inline internal {

struct Pipeline {
  explicit Pipeline(const std::vector<Object>& objects) : Pipeline(std::span(objects)) {}
  explicit Pipeline(std::span<const Object> objects)
      : motion(objects), culling(objects), broad_phase(motion) {}

  /// Stages 2 and 3, after an update of the motion: finds the pairs of leaves that come within `distance` and
  /// that no certificate separates, and fills their features. Adds to `work`. Error: as Culling::begin_step.
  Result<void> find_leaf_pairs(Positions x0, Positions x1, const StepSettings& settings, double distance,
                               Work& work);
  /// Explains the last find_leaf_pairs, which must have had the same settings and distance.
  void explain(const StepSettings& settings, double distance, Explanation& out);

  StepMotion motion;
  Culling culling;
  BroadPhase broad_phase;
  std::vector<Chunk> chunks;  ///< Scratch of the narrow phase.
};

}  // namespace foldproof::inline internal
