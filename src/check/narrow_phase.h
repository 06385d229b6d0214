/// Stage 4 of the pipeline, narrow phase: candidate pairs of features, and which of them collide.
#pragma once

#include <algorithm>
#include <atomic>
#include <limits>
#include <set>
#include <tuple>
#include <utility>

#include "base/parallel.h"
#include "ccd/conservative_advancement.h"
#include "check/filter.h"
#include "check/motion.h"

namespace foldproof::inline internal {

/// Candidates of pairs of leaves. Reuse it: its buffers are kept.
struct CandidateRuns {
  /// Candidates of the same two objects: in each list those from the end of the run before.
  struct Run {
    Index task;
    PerKind<std::size_t> ends;
  };
  CandidateBuffer candidates;
  std::vector<Run> runs;

  void clear() {
    candidates.clear();
    runs.clear();
  }
  /// visit(Run, FeaturePair, first, end) for each list of each run.
  template <class Visit>
  void for_each(Visit visit) const {
    PerKind<std::size_t> begin{};
    for (const Run& run : runs) {
      for (const FeaturePair kind : kFeaturePairs)
        visit(run, kind, std::exchange(begin[kind], run.ends[kind]), run.ends[kind]);
    }
  }
};

/// What was found among a chunk of pairs of leaves.
struct Hits {
  std::vector<VertexFaceCollision> vertex_face;
  std::vector<EdgeEdgeCollision> edge_edge;
  std::vector<TriangleCrossing> crossings;  ///< In a pose.
  Work work;                                ///< Candidates and undecided pairs.
  void clear() {
    vertex_face.clear();
    edge_edge.clear();
    crossings.clear();
    work = {};
  }
};

/// Memory of the narrow phase.
struct NarrowScratch {
  PerThread<CandidateRuns> candidates;
  std::vector<Hits> hits;
};

/// Pairs of leaves per chunk, and chunks whose hits are kept at once, so that they take bounded memory.
inline constexpr std::size_t kChunk = 128, kRound = 512;

/// Calls test(pairs, hits) for all pairs in chunks, in parallel, and add(hits) for one chunk after the other,
/// until is_done() after a round. `hits` is scratch. Isolated: a user's filter, which may start loops, is
/// asked while a thread's scratch is in use.
template <class Pair, class Test, class Add, class IsDone>
void in_chunks(std::span<const Pair> pairs, std::size_t chunk, std::vector<Hits>& hits, Test test, Add add,
               IsDone is_done) {
  while (!pairs.empty() && !is_done()) {
    const std::span<const Pair> round = pairs.first(std::min(pairs.size(), kRound * chunk));
    pairs = pairs.subspan(round.size());
    const std::size_t count = (round.size() + chunk - 1) / chunk;
    if (hits.size() < count) hits.resize(count);
    parallel_for(std::size_t{0}, count, [&](std::size_t i) {
      hits[i].clear();
      isolated([&] { test(round.subspan(i * chunk, std::min(chunk, round.size() - i * chunk)), hits[i]); });
    });
    for (const Hits& found : std::span(hits).first(count)) add(found);
  }
}
template <class Pair, class Test, class Add>
void in_chunks(std::span<const Pair> pairs, std::size_t chunk, std::vector<Hits>& hits, Test test, Add add) {
  in_chunks(pairs, chunk, hits, test, add, [] { return false; });
}

/// Pairs that are undecided, by their objects and ids.
struct UndecidedPairs {
  std::set<std::tuple<Index, Index, Index, Index>> vertex_face;
  std::set<std::tuple<Index, Edge, Index, Edge>> edge_edge;
};

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
  PairSettings pairs;
  std::atomic<double>* earliest;  ///< Null unless StepSettings::earliest_only.
  std::uint64_t max_listed;       ///< StepSettings::max_listed.
  /// Of several searches that share a step (docs/soundness.md, F2): hits from `from` on and before `to`
  /// count.
  double from = 0, to = std::numeric_limits<double>::infinity();
  UndecidedPairs* undecided = nullptr;  ///< Those of the searches before. Null: this is the only one.
  Filter filter = {};
  const Hierarchy& hierarchy(Index object) const { return *bvhs[object].hierarchy; }

 private:
  std::atomic<double> earliest_{1};
};

/// Finds the candidates of pairs of leaves.
void find_candidates(std::span<const TraversalTask> tasks, std::span<const TaskLeaves> pairs,
                     CandidateRuns& out);
/// Finds those candidates that collide.
void test_candidates(const NarrowStep& step, const CandidateRuns& all, Hits& out);
/// Both. Adds to `out`.
void test_leaf_pairs(const NarrowStep& step, std::span<const TaskLeaves> pairs, NarrowScratch& scratch,
                     StepResult& out);

}  // namespace foldproof::inline internal
