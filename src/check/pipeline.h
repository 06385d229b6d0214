/// The pipeline of a query on a set of objects. Its stages: motion, broad phase, culling, narrow phase.
#pragma once

#include <memory>

#include "base/parallel.h"
#include "base/stopwatch.h"
#include "base/try.h"
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
  /// Explains the last find_leaf_pairs, if its settings ask for it.
  void explain(Explanation& out);

  const Filter filter;
  StepMotion motion;
  Culling culling;
  BroadPhase broad_phase;
  NarrowScratch narrow;
  StretchEnds stretch;  ///< Of a long step.

 private:
  StepSettings settings_;  // of the last find_leaf_pairs
  double distance_ = 0;
};

/// Runs the stages of a query in turn, until one fails, and adds their times. They return a Result<void>.
template <class Update, class Search, class Narrow>
Result<void> run_stages(StageTimes& times, Update update, Search search, Narrow narrow) {
  Stopwatch watch;
  const auto take_time = [&](double& stage) {
    const double ms = watch.lap();
    stage += ms;
    times.total += ms;
  };
  FOLDPROOF_TRY(update());
  take_time(times.update);
  FOLDPROOF_TRY(search());
  take_time(times.traverse);
  FOLDPROOF_TRY(narrow());
  take_time(times.narrow);
  return {};
}

/// Runs a call, isolated and in plain arithmetic, on what a checker remembers from call to call. A call that
/// throws, for want of memory or from a user's filter, may leave anything behind: it loses the memory, and
/// the next one makes it anew.
template <class Memory, class Make, class Run>
auto run_on(std::unique_ptr<Memory>& memory, Make make, Run run) {
  const PlainArithmetic plain;
  std::unique_ptr<Memory> mine = std::move(memory);
  if (!mine) mine = make();
  auto result = isolated([&] { return run(*mine); });
  memory = std::move(mine);
  return result;
}

}  // namespace foldproof::inline internal
