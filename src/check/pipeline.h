/// The pipeline of a query on a set of objects. Its stages: motion, broad phase, culling, narrow phase.
#pragma once

#include <memory>

#include "base/parallel.h"
#include "check/broad_phase.h"
#include "check/narrow_phase.h"

namespace foldproof::inline internal {

struct Pipeline {
  /// `pair_filter` is fixed, because fronts and candidates are kept from step to step.
  explicit Pipeline(std::span<const Object> objects, Filter pair_filter = {})
      : filter(pair_filter), motion(objects), culling(objects) {}

  /// Stages 2 and 3, after an update of the motion: finds the pairs of leaves that come within `distance` and
  /// that no certificate separates, and fills their features. Adds to `work`. Error: as Culling::begin_step.
  Result<void> find_leaf_pairs(const StepSettings& settings, double distance, Work& work);
  /// Explains the last find_leaf_pairs, which must have had the same settings and distance.
  void explain(const StepSettings& settings, double distance, Explanation& out);

  const Filter filter;
  StepMotion motion;
  Culling culling;
  BroadPhase broad_phase;
  NarrowScratch narrow;
};

/// Runs a call, isolated, on what a checker remembers from call to call. A call that throws, for want of
/// memory or from a user's filter, may leave anything behind: it loses the memory, and the next one makes it
/// anew.
template <class Memory, class Make, class Run>
auto run_on(std::unique_ptr<Memory>& memory, Make make, Run run) {
  std::unique_ptr<Memory> mine = std::move(memory);
  if (!mine) mine = make();
  auto result = isolated([&] { return run(*mine); });
  memory = std::move(mine);
  return result;
}

}  // namespace foldproof::inline internal
