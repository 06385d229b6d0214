/// Candidates of a search that looks ahead, with the time interval in which each of them may touch.
#pragma once

#include "check/narrow_phase.h"

namespace foldproof::inline internal {

/// Stores the candidates of a motion for the steps along it. Buffers are kept.
class CandidateCache {
 public:
  /// Finds the candidates among pairs of leaves whose features are filled. Drops those that stay farther
  /// apart than `distance`, in the frame, during the whole motion. `chunks` is scratch.
  void fill(std::span<const TraversalTask> tasks, std::span<const LeafPair> pairs, double distance,
            std::vector<Chunk>& chunks);

  /// Runs the narrow phase on the candidates that may touch between two times of the motion, in [0,1]. Adds
  /// to `out`.
  void test(const NarrowStep& step, const float (&times)[2], std::vector<Chunk>& chunks,
            StepResult& out) const;

  struct TimedCandidate {
    CandidateBuffer::Pair pair;
    ContactInterval interval;
  };
  /// Of all pairs of leaves, in their order; those of pair i end at ends[i].
  struct Lists {
    std::vector<TimedCandidate> vertex_face, face_vertex, edge_edge;
    std::vector<Chunk::Ends> ends;
  };

 private:
  std::span<const LeafPair> pairs_;
  Lists lists_;
};

}  // namespace foldproof::inline internal
