/// Candidates of a search that looks ahead, with the time interval in which each of them may touch.
#pragma once

#include "check/narrow_phase.h"

namespace foldproof::inline internal {

/// Stores the candidates of a motion for the steps along it. Buffers are kept.
class CandidateCache {
 public:
  /// Finds the candidates among pairs of leaves whose features are filled. Drops those that stay farther
  /// apart than `distance`, in the frame, during the whole motion.
  void fill(std::span<const TraversalTask> tasks, std::span<const TaskLeaves> pairs, double distance);

  /// Runs the narrow phase on the candidates that may touch between two times of the motion, in [0,1]. Adds
  /// to `out`.
  void test(const NarrowStep& step, const float (&times)[2], NarrowScratch& scratch, StepResult& out) const;

 private:
  // Of a chunk of pairs of leaves.
  struct Part {
    CandidateRuns found;
    PerKind<std::vector<ContactInterval>> intervals;  // of found.candidates
  };
  static void find_intervals(std::span<const TraversalTask> tasks, double distance, Part& part);
  static void drop_empty(Part& part);

  std::vector<Part> parts_;  // the first count_; the rest keep their buffers
  std::size_t count_ = 0;
};

}  // namespace foldproof::inline internal
