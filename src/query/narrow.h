/// From pairs of leaves to collisions: candidates, the narrow phase on them, and the sorted answer. Shared by
/// all queries.
#pragma once

#include <atomic>
#include <chrono>

#include "bvh/traverse.h"
#include "foldproof/query.h"
#include "query/distinct.h"

namespace foldproof {

/// A share of the traversal of one object with itself or of two objects.
struct TraversalTask {
  Traversal traversal;
  Index object_a, object_b;
};

/// A leaf pair to be tested, with the task it came from.
struct LeafPairRef {
  Index task;
  NodePair leaves;
};

class Stopwatch {
 public:
  /// Milliseconds since the last call.
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    const double ms = std::chrono::duration<double, std::milli>(now - last_).count();
    last_ = now;
    return ms;
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

inline Vec3 position(std::span<const double> x, Index vertex) {
  return Eigen::Map<const Vec3>(&x[3 * std::size_t{vertex}]);
}

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
template <class AnyChunk, class Round>
void in_rounds(std::span<const LeafPairRef> left, std::vector<AnyChunk>& chunks, Round round) {
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
class PairChoice {
 public:
  virtual ~PairChoice() = default;
  virtual bool vertex_face(Index vertex, Index face) const = 0;
  virtual bool edge_edge(const Edge& a, const Edge& b) const = 0;
  /// Two triangles of a pose.
  virtual bool crossing(Index triangle_a, Index triangle_b) const = 0;
};

/// What the objects of a query stand for, where some triangles are copies of others; empty where nobody
/// asked.
using DistinctObjects = std::span<const std::shared_ptr<const DistinctTriangles>>;

/// What is said of the triangles that were looked at becomes what is said of all.
void spread(DistinctObjects distinct, Explanation& explanation);

/// What the narrow phase needs to know about the step. The features of the leaves that it is asked about have
/// been filled, and their vertices stand in x0 and x1.
struct NarrowStep {
  std::span<const KineticTree> trees;
  std::span<const TraversalTask> tasks;
  Positions x0, x1;
  CcdSettings ccd;
  std::atomic<double>* earliest;       ///< null unless only the earliest is wanted
  std::uint64_t max_listed;            ///< StepSettings::max_listed
  const PairChoice* choice = nullptr;  ///< null: all pairs count
  DistinctObjects distinct = {};
  const Hierarchy& hierarchy(Index object) const { return *trees[object].hierarchy; }
};

Result<void> check_settings(const StepSettings& settings);
void clear(StepResult& out);
/// The tolerance to use when everything lies in a box of this side.
double tolerance_for(const StepSettings& settings, double side);

/// Finds a chunk's candidates.
void gather(const NarrowStep& step, Chunk& chunk);
/// The narrow phase on them.
void narrow(const NarrowStep& step, Chunk& chunk);
/// Adds what a chunk found to the answer, and forgets it there.
void take_found(const NarrowStep& step, Chunk& chunk, StepResult& out);
/// First all candidates of a round, then the narrow phase on them.
void test_round(const NarrowStep& step, std::span<Chunk> chunks, Stopwatch& watch, StepResult& out);
/// Sorts by ids; with StepSettings::earliest_only, keeps the earliest.
void finish(const StepSettings& settings, StepResult& out);

}  // namespace foldproof
