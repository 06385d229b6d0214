/// Look-ahead: while a motion continues in straight lines, one search covers several steps.
#pragma once

#include "check/candidate_cache.h"
#include "check/look_ahead_policy.h"
#include "check/pipeline.h"

namespace foldproof::inline internal {

/// Caches the candidates of a search that looks ahead for later steps.
///
/// Such a search extrapolates the first step in straight lines and finds the pairs of features that may touch
/// while every vertex stays within a slack of its extrapolated position. A later step whose ends are within
/// the slack is a cache hit: its collisions are among these pairs (docs/soundness.md, F1), so it needs no
/// search.
class LookAhead {
 public:
  struct Plan {
    Index steps = 1;    ///< Search for this many steps, the present one included; 0: a cache hit.
    double extent = 0;  ///< Of a cache hit: the largest side of the bounding box of the step.
    bool is_cache_hit() const { return steps == 0; }
  };
  Plan plan(const StepMotion& motion, Positions x0, Positions x1, const StepSettings& settings);

  /// Searches after an update of the motion with plan().steps. `distance`, mesh units: what the step alone
  /// needs. Error: as Pipeline::find_leaf_pairs.
  Result<void> search(Pipeline& pipeline, const StepSettings& settings, double distance, Work& work);
  /// Runs the narrow phase of a step, after its search or on a cache hit. `out.work` has the search's work.
  void test(const NarrowStep& step, Pipeline& pipeline, StepResult& out);

  /// Makes the next step a cache miss.
  void invalidate() { search_valid_ = false; }

 private:
  double begin_search(const StepMotion& motion, const StepSettings& settings, double distance);

  bool search_valid_ = false;
  // Of the last search:
  StepSettings settings_;  // what its later steps alone ask for is as by default
  double steps_ = 1;
  double distance_ = 0;            // thickness + tolerance that its steps may have, mesh units
  double candidate_distance_ = 0;  // distance_ plus slack, in the frame
  float slack_ = 0;                // along any axis, in the frame; 0 where it does not look ahead
  double edge_length_ = 0;         // mean, in the frame
  float times_[2] = {0, 1};        // of the present step, in the motion of the search
  LookAheadPolicy policy_;
  CandidateCache candidates_;
};

}  // namespace foldproof::inline internal
