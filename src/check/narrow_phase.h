/// The pipeline's last stage: from pairs of leaves to pairs of features, and which of those collide.
#pragma once

#include <atomic>

#include "base/stopwatch.h"
#include "check/distinct.h"
#include "check/motion.h"

namespace foldproof {

/// Leaf pairs that one task tests, with what it finds. Reused.
struct Chunk {
  std::span<const LeafPairRef> pairs;
  /// Candidates stand pair after pair; `ends` says where each pair's end.
  CandidateBuffer candidates;
  struct Ends {
    std::size_t vertex_face, face_vertex, edge_edge;
  };
  std::vector<Ends> ends;
  struct Meetings {
    std::vector<Meeting> vertex_face, face_vertex, edge_edge;
  };
  Meetings meetings;  ///< Scratch of a search that looks ahead.
  std::vector<VertexFaceCollision> vertex_face;
  std::vector<EdgeEdgeCollision> edge_edge;
  std::vector<TriangleCrossing> crossings;
  std::uint64_t undecided = 0;
};

/// Hands out pairs of leaves to chunks, a bounded number at a time, so that candidates take bounded memory.
/// `round(count)` works on chunks [0, count).
template <class Round>
void in_rounds(std::span<const LeafPairRef> left, std::vector<Chunk>& chunks, Round round) {
  constexpr std::size_t kPairsPerChunk = 128, kChunksPerRound = 32;
  while (!left.empty()) {
    std::size_t count = 0;
    for (; count < kChunksPerRound && !left.empty(); ++count) {
      if (count == chunks.size()) chunks.emplace_back();
      chunks[count].pairs = left.first(std::min(kPairsPerChunk, left.size()));
      left = left.subspan(chunks[count].pairs.size());
    }
    round(count);
  }
}

/// Which pairs of features count, by the user's ids. Asked by several threads at once.
class PairFilter {
 public:
  virtual ~PairFilter() = default;
  virtual bool vertex_face(Index vertex, Index face) const = 0;
  virtual bool edge_edge(const Edge& a, const Edge& b) const = 0;
  /// Two triangles of a pose.
  virtual bool crossing(Index triangle_a, Index triangle_b) const = 0;
};

/// What the objects of a query stand for, where some triangles are copies of others; empty where nobody
/// asked.
using DistinctObjects = std::span<const std::shared_ptr<const DistinctTriangles>>;

/// What the narrow phase needs to know about the step. The features of the leaves that it is asked about have
/// been filled, and their vertices stand in x0 and x1.
struct NarrowStep {
  NarrowStep(const StepSettings& settings, double used_tolerance, std::span<const KineticTree> all_trees,
             std::span<const TraversalTask> all_tasks, Positions begin, Positions end)
      : trees(all_trees),
        tasks(all_tasks),
        x0(begin),
        x1(end),
        earliest(settings.earliest_only ? &earliest_ : nullptr),
        max_listed(settings.max_listed) {
    ccd.thickness = settings.thickness;
    ccd.tolerance = used_tolerance;
  }

  std::span<const KineticTree> trees;
  std::span<const TraversalTask> tasks;
  Positions x0, x1;
  CcdSettings ccd;
  std::atomic<double>* earliest;       ///< null unless only the earliest is wanted
  std::uint64_t max_listed;            ///< StepSettings::max_listed
  const PairFilter* filter = nullptr;  ///< null: all pairs count
  DistinctObjects distinct = {};
  const Hierarchy& hierarchy(Index object) const { return *trees[object].hierarchy; }

 private:
  std::atomic<double> earliest_{1};
};

/// Finds a chunk's candidates.
void gather(std::span<const TraversalTask> tasks, Chunk& chunk);
/// Which of them collide.
void narrow(const NarrowStep& step, Chunk& chunk);
/// Both, for all pairs of leaves. Adds to `out`.
void test_leaf_pairs(const NarrowStep& step, std::span<const LeafPairRef> pairs, std::vector<Chunk>& chunks,
                     Stopwatch& watch, StepResult& out);

}  // namespace foldproof
