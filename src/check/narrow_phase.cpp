#include "check/narrow_phase.h"

#include "base/parallel.h"
#include "check/answer.h"
#include "check/pair_lanes.h"

namespace foldproof::internal {
namespace {

// Lowers `earliest` to the time of a collision. Later candidates stop once they are proven free until then.
void update_earliest(const NarrowStep& step, double toi) {
  double now = step.earliest->load(std::memory_order_relaxed);
  while (toi < now && !step.earliest->compare_exchange_weak(now, toi, std::memory_order_relaxed)) {
  }
}

// One object of a pair.
struct Side {
  Index object;
  const Hierarchy* hierarchy;
  const double *x0, *x1;

  Side(const NarrowStep& step, Index which)
      : object(which),
        hierarchy(&step.hierarchy(which)),
        x0(step.x0[which].data()),
        x1(step.x1[which].data()) {}
  void prefetch(Index vertex) const {
    __builtin_prefetch(x0 + 3 * std::size_t{vertex});
    __builtin_prefetch(x1 + 3 * std::size_t{vertex});
  }
  // User's ids of a vertex and an edge, given by their indices in leaf order.
  Index vertex(Index index) const { return hierarchy->vertex_ids()[index]; }
  Edge edge(Index index) const {
    const Edge& e = hierarchy->edges()[index];
    return {vertex(e[0]), vertex(e[1])};
  }
};

// Tests candidates of one kind.
template <class Pair>
class CandidateTester {
 public:
  CandidateTester(const NarrowStep& step, std::vector<Pair>& hits, std::uint64_t& undecided)
      : step_(step), lanes_(kEdgeEdge, step.ccd, step.earliest, Report{step, hits, undecided}, step.pairs) {}

  // Adds a vertex of `a` and a face of `b`, or an edge of each, by their indices in leaf order.
  void add(const Side& a, Index index_a, const Side& b, Index index_b) {
    if constexpr (kEdgeEdge) {
      add_edges(a, a.edge(index_a), b, b.edge(index_b));
    } else {
      add_face(a, a.vertex(index_a), b, index_b);
    }
  }

  // Prefetches the positions of a later pair.
  void prefetch(const Side& a, Index index_a, const Side& b, Index index_b) const {
    if constexpr (kEdgeEdge) {
      for (const Index vertex : a.edge(index_a)) a.prefetch(vertex);
      for (const Index vertex : b.edge(index_b)) b.prefetch(vertex);
    } else {
      a.prefetch(a.vertex(index_a));
      for (const Index corner : b.hierarchy->triangles()[index_b]) b.prefetch(b.vertex(corner));
    }
  }

  void finish() { lanes_.finish(); }

 private:
  static constexpr bool kEdgeEdge = std::is_same_v<Pair, EdgeEdgeCollision>;

  struct Report {
    const NarrowStep& step;
    std::vector<Pair>& hits;
    std::uint64_t& undecided;
    void operator()(const Pair& pair, const CcdResult& result) const {
      if (result.answer == Answer::Separated) return;
      if (result.answer == Answer::Hit && !(result.toi >= step.from && result.toi < step.to)) return;
      if (step.earliest != nullptr) update_earliest(step, result.toi);
      undecided += result.answer == Answer::Undecided;
      Pair& hit = hits.emplace_back(pair);
      hit.toi = result.toi;
      hit.answer = result.answer;
    }
  };

  void add_edges(const Side& a, const Edge& edge_a, const Side& b, const Edge& edge_b) {
    // In the order of their ids, so that the answer does not depend on the hierarchy.
    if (a.object == b.object && edge_b < edge_a) return add_edges(b, edge_b, a, edge_a);
    if (!step_.filter.edge_edge(a.object, edge_a, b.object, edge_b)) return;
    for (int k = 0; k < 2; ++k) {
      set_point(k, a, edge_a[k]);
      set_point(2 + k, b, edge_b[k]);
    }
    lanes_.add({a.object, edge_a, b.object, edge_b, 1, Answer::Separated});
  }

  void add_face(const Side& a, Index vertex, const Side& b, Index face) {
    const Index face_id = b.hierarchy->triangle_ids()[face];
    if (!step_.filter.vertex_face(a.object, vertex, b.object, face_id)) return;
    set_point(0, a, vertex);
    for (int k = 0; k < 3; ++k) set_point(1 + k, b, b.vertex(b.hierarchy->triangles()[face][k]));
    lanes_.add({a.object, vertex, b.object, face_id, 1, Answer::Separated});
  }

  void set_point(int point, const Side& side, Index vertex) {
    const std::size_t offset = 3 * std::size_t{vertex};
    lanes_.set_point(point, side.x0 + offset, side.x1 + offset);
  }

  const NarrowStep& step_;
  PairLanes<Pair, Report> lanes_;
};

// Adds candidates of two objects. `swapped`: their features are of b and a.
template <class Pair>
void add_candidates(CandidateTester<Pair>& tester, std::span<const CandidatePair> pairs, const Side& a,
                    const Side& b, bool swapped = false) {
  constexpr std::size_t kPrefetchDistance = 12;
  const Side &first = swapped ? b : a, &second = swapped ? a : b;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const auto [index_a, index_b] = pairs[i];
    if (i + kPrefetchDistance < pairs.size()) {
      const auto later = pairs[i + kPrefetchDistance];
      tester.prefetch(first, swapped ? later.b : later.a, second, swapped ? later.a : later.b);
    }
    tester.add(first, swapped ? index_b : index_a, second, swapped ? index_a : index_b);
  }
}

}  // namespace

void find_candidates(std::span<const TraversalTask> tasks, std::span<const TaskLeaves> pairs,
                     CandidateRuns& out) {
  constexpr std::size_t kPrefetchDistance = 2;
  out.clear();
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (i + kPrefetchDistance < pairs.size()) {
      const TaskLeaves& later = pairs[i + kPrefetchDistance];
      prefetch_features(tasks[later.task].traversal, later.leaves);
    }
    const TraversalTask& task = tasks[pairs[i].task];
    find_candidates(task.traversal, pairs[i].leaves, out.candidates);
    const bool same_objects = !out.runs.empty() && tasks[out.runs.back().task].object_a == task.object_a &&
                              tasks[out.runs.back().task].object_b == task.object_b;
    if (!same_objects) out.runs.push_back({pairs[i].task, {}});
    for (const FeaturePair kind : kFeaturePairs) out.runs.back().ends[kind] = out.candidates[kind].size();
  }
}

void test_candidates(const NarrowStep& step, const CandidateRuns& all, Hits& out) {
  CandidateTester<VertexFaceCollision> vertex_face(step, out.vertex_face, out.work.undecided);
  CandidateTester<EdgeEdgeCollision> edge_edge(step, out.edge_edge, out.work.undecided);
  all.for_each([&](const CandidateRuns::Run& run, FeaturePair kind, std::size_t begin, std::size_t end) {
    const std::span pairs = std::span(all.candidates[kind]).subspan(begin, end - begin);
    const TraversalTask& task = step.tasks[run.task];
    const Side a(step, task.object_a), b(step, task.object_b);
    if (kind == FeaturePair::EdgeEdge) {
      add_candidates(edge_edge, pairs, a, b);
    } else {
      add_candidates(vertex_face, pairs, a, b, kind == FeaturePair::FaceVertex);
    }
  });
  vertex_face.finish();
  edge_edge.finish();
  const CandidateBuffer& c = all.candidates;
  out.work.candidates_vf += c[FeaturePair::VertexFace].size() + c[FeaturePair::FaceVertex].size();
  out.work.candidates_ee += c[FeaturePair::EdgeEdge].size();
}

void test_leaf_pairs(const NarrowStep& step, std::span<const TaskLeaves> pairs, NarrowScratch& scratch,
                     StepResult& out) {
  const auto test = [&](std::span<const TaskLeaves> chunk, Hits& hits) {
    CandidateRuns& candidates = scratch.candidates.local();
    find_candidates(step.tasks, chunk, candidates);
    test_candidates(step, candidates, hits);
  };
  in_chunks(pairs, kChunk, scratch.hits, test, [&](const Hits& hits) { add_collisions(step, hits, out); });
}

}  // namespace foldproof::internal
