/// The pipeline of a query on a set of objects, its stages in their order.
#pragma once

#include "check/broad_phase.h"
#include "check/narrow_phase.h"

namespace foldproof {

struct Pipeline {
  explicit Pipeline(const std::vector<Object>& objects) : Pipeline(std::span(objects)) {}
  explicit Pipeline(std::span<const Object> objects)
      : motion(objects), culling(objects), broad_phase(motion) {}

  /// After an update of the motion: finds the pairs of leaves that come closer than `distance` and that no
  /// certificate proves apart, and fills their features. Adds to `work`. Error: as Culling::begin.
  Result<void> find_leaf_pairs(Positions x0, Positions x1, const StepSettings& settings, double distance,
                               Work& work);
  /// Says what certificates did in the last such search, which had the same settings and distance.
  void explain(const StepSettings& settings, double distance, Explanation& out);

  StepMotion motion;
  Culling culling;
  BroadPhase broad_phase;
  std::vector<Chunk> chunks;  ///< The narrow phase's scratch.
};

}  // namespace foldproof
