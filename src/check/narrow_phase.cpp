#include "check/narrow_phase.h"

#include "base/parallel.h"
#include "check/answer.h"
#include "check/pair_lanes.h"

namespace foldproof {
namespace {

// Lowers `earliest` to a collision's time. Later candidates stop as soon as they are proven free until then.
void note_earliest(const NarrowStep& step, double toi) {
  double now = step.earliest->load(std::memory_order_relaxed);
  while (toi < now && !step.earliest->compare_exchange_weak(now, toi, std::memory_order_relaxed)) {
  }
}

// What the narrow phase reads of one object.
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
  Index vertex(Index place) const { return hierarchy->vertex_ids()[place]; }
  Edge edge(Index place) const {
    const Edge& e = hierarchy->edges()[place];
    return {vertex(e[0]), vertex(e[1])};
  }
};

// The narrow phase on candidates of one kind.
template <class Pair>
class Narrow {
 public:
  Narrow(const NarrowStep& step, std::vector<Pair>& hits, std::uint64_t& undecided)
      : step_(step), lanes_(kEdgeEdge, step.ccd, step.earliest, Note{step, hits, undecided}) {}

  // A vertex of `a` and a face of `b`, or an edge of each, by their places in leaf order.
  void add(const Side& a, Index place_a, const Side& b, Index place_b) {
    if constexpr (kEdgeEdge) {
      add_edges(a, a.edge(place_a), b, b.edge(place_b));
    } else {
      add_face(a, a.vertex(place_a), b, place_b);
    }
  }

  // Asks the memory for the positions that a later pair needs.
  void prefetch(const Side& a, Index place_a, const Side& b, Index place_b) const {
    if constexpr (kEdgeEdge) {
      for (const Index vertex : a.edge(place_a)) a.prefetch(vertex);
      for (const Index vertex : b.edge(place_b)) b.prefetch(vertex);
    } else {
      a.prefetch(a.vertex(place_a));
      for (const Index place : b.hierarchy->triangles()[place_b]) b.prefetch(b.vertex(place));
    }
  }

  void finish() { lanes_.finish(); }

 private:
  static constexpr bool kEdgeEdge = std::is_same_v<Pair, EdgeEdgeCollision>;

  struct Note {
    const NarrowStep& step;
    std::vector<Pair>& hits;
    std::uint64_t& undecided;
    void operator()(const Pair& pair, const CcdResult& result) const {
      if (result.answer == Answer::Separated) return;
      if (step.earliest != nullptr) note_earliest(step, result.toi);
      undecided += result.answer == Answer::Undecided;
      Pair& hit = hits.emplace_back(pair);
      hit.toi = result.toi;
      hit.answer = result.answer;
    }
  };

  void add_edges(const Side& a, const Edge& edge_a, const Side& b, const Edge& edge_b) {
    // One order of the two, whatever the hierarchy: the answer to a pair is then a property of the pair.
    if (a.object == b.object && edge_b < edge_a) return add_edges(b, edge_b, a, edge_a);
    if (step_.filter != nullptr && !step_.filter->edge_edge(edge_a, edge_b)) return;
    for (int k = 0; k < 2; ++k) {
      set_point(k, a, edge_a[k]);
      set_point(2 + k, b, edge_b[k]);
    }
    lanes_.add({a.object, edge_a, b.object, edge_b, 1, Answer::Separated});
  }

  void add_face(const Side& a, Index vertex, const Side& b, Index face) {
    const Index face_id = b.hierarchy->triangle_ids()[face];
    if (step_.filter != nullptr && !step_.filter->vertex_face(vertex, face_id)) return;
    set_point(0, a, vertex);
    for (int k = 0; k < 3; ++k) set_point(1 + k, b, b.vertex(b.hierarchy->triangles()[face][k]));
    lanes_.add({a.object, vertex, b.object, face_id, 1, Answer::Separated});
  }

  void set_point(int point, const Side& side, Index vertex) {
    const std::size_t offset = 3 * std::size_t{vertex};
    lanes_.set_point(point, side.x0 + offset, side.x1 + offset);
  }

  const NarrowStep& step_;
  PairLanes<Pair, Note> lanes_;
};

// Candidates of two objects, the second list's the other way round; memory is asked for some ahead.
template <class Pair>
void feed(Narrow<Pair>& narrow, std::span<const CandidateBuffer::Pair> pairs, const Side& a, const Side& b,
          bool turned = false) {
  constexpr std::size_t kAhead = 12;
  const Side &first = turned ? b : a, &second = turned ? a : b;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const auto [place_a, place_b] = pairs[i];
    if (i + kAhead < pairs.size()) {
      const auto later = pairs[i + kAhead];
      narrow.prefetch(first, turned ? later.b : later.a, second, turned ? later.a : later.b);
    }
    narrow.add(first, turned ? place_b : place_a, second, turned ? place_a : place_b);
  }
}

}  // namespace

void gather(std::span<const TraversalTask> tasks, Chunk& chunk) {
  constexpr std::size_t kAhead = 2;
  chunk.candidates.clear();
  chunk.ends.clear();
  for (std::size_t i = 0; i < chunk.pairs.size(); ++i) {
    const LeafPairRef& pair = chunk.pairs[i];
    if (i + kAhead < chunk.pairs.size()) {
      const LeafPairRef& later = chunk.pairs[i + kAhead];
      prefetch_features(tasks[later.task].traversal, later.leaves);
    }
    find_candidates(tasks[pair.task].traversal, pair.leaves, chunk.candidates);
    chunk.ends.push_back({chunk.candidates.vertex_face.size(), chunk.candidates.face_vertex.size(),
                          chunk.candidates.edge_edge.size()});
  }
}

void narrow(const NarrowStep& step, Chunk& chunk) {
  Narrow<VertexFaceCollision> vertex_face(step, chunk.vertex_face, chunk.undecided);
  Narrow<EdgeEdgeCollision> edge_edge(step, chunk.edge_edge, chunk.undecided);
  const CandidateBuffer& c = chunk.candidates;
  Chunk::Ends done{0, 0, 0};
  for (std::size_t i = 0; i < chunk.pairs.size(); ++i) {
    const auto objects = [&](std::size_t pair) {
      const TraversalTask& task = step.tasks[chunk.pairs[pair].task];
      return std::pair(task.object_a, task.object_b);
    };
    // As many pairs of leaves as belong to the same objects.
    while (i + 1 < chunk.pairs.size() && objects(i + 1) == objects(i)) ++i;
    const Side a(step, objects(i).first), b(step, objects(i).second);
    const Chunk::Ends& end = chunk.ends[i];
    const auto part = [](const auto& list, std::size_t from, std::size_t to) {
      return std::span(list).subspan(from, to - from);
    };
    feed(vertex_face, part(c.vertex_face, done.vertex_face, end.vertex_face), a, b);
    feed(vertex_face, part(c.face_vertex, done.face_vertex, end.face_vertex), a, b, true);
    feed(edge_edge, part(c.edge_edge, done.edge_edge, end.edge_edge), a, b);
    done = end;
  }
  vertex_face.finish();
  edge_edge.finish();
}

void test_leaf_pairs(const NarrowStep& step, std::span<const LeafPairRef> pairs, std::vector<Chunk>& chunks,
                     Stopwatch& watch, StepResult& out) {
  in_rounds(pairs, chunks, [&](std::size_t count) {
    parallel_for(std::size_t{0}, count, [&](std::size_t i) { gather(step.tasks, chunks[i]); });
    out.milliseconds.traverse += watch.lap();
    parallel_for(std::size_t{0}, count, [&](std::size_t i) { narrow(step, chunks[i]); });
    for (Chunk& chunk : std::span(chunks).first(count)) take_found(step, chunk, out);
    out.milliseconds.narrow += watch.lap();
  });
}

}  // namespace foldproof
