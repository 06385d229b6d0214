/// Searching ahead: while a motion goes on as it did, one search serves many steps.
#pragma once

#include "check/horizon.h"
#include "check/pipeline.h"
#include "check/timed_candidates.h"

namespace foldproof {

/// Keeps what a search that looks ahead found, and says which steps it serves.
///
/// A search that looks ahead finds the pairs of features that may come near each other while every vertex
/// goes on as in the first step, with some slack. Where both ends of a later step lie within that slack,
/// its collisions are among these pairs (docs/soundness.md, F1), and it needs no search of its own. How far
/// to look is the horizon's guess.
class LookAhead {
 public:
  /// What is to be done for a step.
  struct Plan {
    Index steps = 1;  ///< Search for so many steps, this one included; 0: the last search serves it.
    double side = 0;  ///< Of a step that is served: the largest side of the box around everything.
    bool is_served() const { return steps == 0; }
  };
  Plan plan(const StepMotion& motion, Positions x0, Positions x1, const StepSettings& settings);

  /// Searches for a motion that was updated as planned; `distance`, mesh units, is enough for the step alone.
  /// Error: as Pipeline::find_leaf_pairs.
  Result<void> search(Pipeline& pipeline, Positions x0, Positions x1, const StepSettings& settings,
                      double distance, Work& work);
  /// The narrow phase on a step that was searched or is served. `work`, in the answer, is what a search took.
  void test(const NarrowStep& step, Pipeline& pipeline, Stopwatch& watch, StepResult& out);

  /// The next step needs a search.
  void forget() { search_valid_ = false; }

 private:
  bool same_search(const StepSettings& settings) const;
  double begin(const StepMotion& motion, const StepSettings& settings, double distance);

  bool search_valid_ = false;
  StepSettings settings_;
  double steps_ = 1;         // that the search looked ahead
  double distance_ = 0;      // that it was for, without slack
  double reach_ = 0;         // the same with slack, in the frame
  float slack_ = 0;          // along any axis, in the frame; 0 where it did not look ahead
  double edge_ = 0;          // mean length, in the frame
  float times_[2] = {0, 1};  // of the step at hand, in the motion that was searched
  Horizon horizon_;
  TimedCandidates candidates_;
};

}  // namespace foldproof
