/// Candidates of a search that looks ahead, and when each of them may meet.
#pragma once

#include "check/narrow_phase.h"

namespace foldproof {

/// Keeps the candidates of a motion for the steps along it. Reused: buffers are kept.
class TimedCandidates {
 public:
  /// Finds the candidates among pairs of leaves whose features have been filled, and leaves out those that
  /// stay farther apart than `distance`, in the frame, all the way. `chunks` is scratch.
  void gather(std::span<const TraversalTask> tasks, std::span<const LeafPairRef> pairs, double distance,
              std::vector<Chunk>& chunks);

  /// The narrow phase on those that may meet between two times of the motion, which goes from 0 to 1. Adds to
  /// `out`.
  void test(const NarrowStep& step, const float (&times)[2], std::vector<Chunk>& chunks,
            StepResult& out) const;

  struct Kept {
    CandidateBuffer::Pair pair;
    Meeting meeting;
  };
  /// Those of all pairs of leaves, one after the other.
  struct All {
    std::vector<Kept> vertex_face, face_vertex, edge_edge;
    std::vector<Chunk::Ends> ends;  ///< Per pair of leaves.
  };

 private:
  std::span<const LeafPairRef> pairs_;
  All all_;
};

}  // namespace foldproof
