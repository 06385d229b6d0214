/// Stage 4 of the pipeline, narrow phase: candidate pairs of features, and which of them collide.
#pragma once

#include <algorithm>
#include <atomic>

#include "base/parallel.h"
#include "base/stopwatch.h"
#include "check/filter.h"
#include "check/motion.h"

namespace foldproof::inline internal {

/// Pairs of leaves that one task tests, and its results. Reuse it: its buffers are kept.
struct Chunk {
  std::span<const LeafPair> pairs;
  /// Candidates of all pairs of leaves, in their order; those of pair i end at ends[i].
  CandidateBuffer candidates;
  struct Ends {
    std::size_t vertex_face, face_vertex, edge_edge;
  };
  std::vector<Ends> ends;
  struct ContactIntervals {
    std::vector<ContactInterval> vertex_face, face_vertex, edge_edge;
  };
  ContactIntervals intervals;  ///< Of the candidates, in a search that looks ahead.
  std::vector<VertexFaceCollision> vertex_face;
  std::vector<EdgeEdgeCollision> edge_edge;
  std::vector<TriangleCrossing> crossings;
  std::uint64_t undecided = 0;
};

/// Distributes pairs of leaves to chunks, a bounded number per round, so that candidates take bounded memory.
/// `round(count)` processes chunks [0, count).
template <class Round>
void in_rounds(std::span<const LeafPair> pairs, std::vector<Chunk>& chunks, Round round) {
  constexpr std::size_t kPairsPerChunk = 128;
  const std::size_t chunks_per_round = 8 * static_cast<std::size_t>(std::max(4, thread_count()));
  while (!pairs.empty()) {
    std::size_t count = 0;
    for (; count < chunks_per_round && !pairs.empty(); ++count) {
      if (count == chunks.size()) chunks.emplace_back();
      chunks[count].pairs = pairs.first(std::min(kPairsPerChunk, pairs.size()));
      pairs = pairs.subspan(chunks[count].pairs.size());
    }
    round(count);
  }
}

/// Input of the narrow phase. Precondition: the features of the leaves to be tested are filled; x0 and x1
/// have at least their vertices.
struct NarrowStep {
  NarrowStep(const StepSettings& settings, double used_tolerance, std::span<const KineticBvh> all_bvhs,
             std::span<const TraversalTask> all_tasks, Positions start, Positions end)
      : bvhs(all_bvhs),
        tasks(all_tasks),
        x0(start),
        x1(end),
        earliest(settings.earliest_only ? &earliest_ : nullptr),
        max_listed(settings.max_listed) {
    ccd.thickness = settings.thickness;
    ccd.tolerance = used_tolerance;
  }

  std::span<const KineticBvh> bvhs;
  std::span<const TraversalTask> tasks;
  Positions x0, x1;
  CcdSettings ccd;
  std::atomic<double>* earliest;  ///< Null unless StepSettings::earliest_only.
  std::uint64_t max_listed;       ///< StepSettings::max_listed.
  Filter filter = {};
  const Hierarchy& hierarchy(Index object) const { return *bvhs[object].hierarchy; }

 private:
  std::atomic<double> earliest_{1};
};

/// Finds the candidates of a chunk.
void find_candidates(std::span<const TraversalTask> tasks, Chunk& chunk);
/// Finds those candidates of a chunk that collide.
void test_candidates(const NarrowStep& step, Chunk& chunk);
/// Both, for all pairs of leaves. Adds to `out`.
void test_leaf_pairs(const NarrowStep& step, std::span<const LeafPair> pairs, std::vector<Chunk>& chunks,
                     Stopwatch& watch, StepResult& out);

}  // namespace foldproof::inline internal
