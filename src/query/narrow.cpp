
#include <algorithm>
#include <cmath>
#include <tuple>

#include "base/parallel.h"
#include "ccd/march.h"
#include "query/narrow.h"
#include "query/shortlist.h"

namespace foldproof {
namespace {

auto key(const VertexFaceCollision& c) {
  return std::tuple(c.vertex_object, c.vertex, c.face_object, c.face);
}
auto key(const EdgeEdgeCollision& c) { return std::tuple(c.object_a, c.a, c.object_b, c.b); }

// Lowers `earliest` to a collision's time. Later candidates stop as soon as they are proven free until then.
void note_earliest(const NarrowStep& step, double toi) {
  double now = step.earliest->load(std::memory_order_relaxed);
  while (toi < now && !step.earliest->compare_exchange_weak(now, toi, std::memory_order_relaxed)) {
  }
}

double latest_now(const NarrowStep& step) {
  return step.earliest != nullptr ? step.earliest->load(std::memory_order_relaxed) : step.ccd.latest;
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

// Collects pairs of one kind until there are eight, drops those that the first test proves apart, and follows
// the rest, eight at a time.
template <class Pair>
class Narrow {
 public:
  Narrow(const NarrowStep& step, std::vector<Pair>& hits, std::uint64_t& undecided)
      : step_(step), hits_(hits), undecided_(undecided), march_(kEdgeEdge, step.ccd) {}

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

  void finish() {
    if (count_ > 0) start();
    while (march_.busy()) look();
  }

 private:
  static constexpr bool kEdgeEdge = std::is_same_v<Pair, EdgeEdgeCollision>;

  void add_edges(const Side& a, const Edge& edge_a, const Side& b, const Edge& edge_b) {
    // One order of the two, whatever the hierarchy: the answer to a pair is then a property of the pair.
    if (a.object == b.object && edge_b < edge_a) return add_edges(b, edge_b, a, edge_a);
    if (step_.choice != nullptr && !step_.choice->edge_edge(edge_a, edge_b)) return;
    pairs_[count_] = {a.object, edge_a, b.object, edge_b, 1, Answer::Separated};
    for (int k = 0; k < 2; ++k) {
      set_point(k, a, edge_a[k]);
      set_point(2 + k, b, edge_b[k]);
    }
    if (++count_ == 8) start();
  }

  void add_face(const Side& a, Index vertex, const Side& b, Index face) {
    const Index face_id = b.hierarchy->triangle_ids()[face];
    if (step_.choice != nullptr && !step_.choice->vertex_face(vertex, face_id)) return;
    pairs_[count_] = {a.object, vertex, b.object, face_id, 1, Answer::Separated};
    set_point(0, a, vertex);
    for (int k = 0; k < 3; ++k) set_point(1 + k, b, b.vertex(b.hierarchy->triangles()[face][k]));
    if (++count_ == 8) start();
  }

  void set_point(int point, const Side& side, Index vertex) {
    const std::size_t offset = 3 * std::size_t{vertex};
    batch_.set(count_, point, side.x0 + offset, side.x1 + offset);
  }

  void start() {
    for (unsigned left = march_.take(batch_, count_); left != 0; left &= left - 1) {
      while (march_.full()) look();
      const int k = __builtin_ctz(left);
      followed_[march_.start(k, latest_now(step_))] = pairs_[k];
    }
    count_ = 0;
  }

  void look() {
    for (unsigned done = march_.look(); done != 0; done &= done - 1) {
      const int lane = __builtin_ctz(done);
      note(followed_[lane], march_.result(lane));
    }
  }

  void note(const Pair& pair, const CcdResult& result) {
    if (result.answer == Answer::Separated) return;
    if (step_.earliest != nullptr) note_earliest(step_, result.toi);
    undecided_ += result.answer == Answer::Undecided;
    Pair& hit = hits_.emplace_back(pair);
    hit.toi = result.toi;
    hit.answer = result.answer;
  }

  const NarrowStep& step_;
  std::vector<Pair>& hits_;
  std::uint64_t& undecided_;
  int count_ = 0;
  std::array<Pair, 8> pairs_;
  PairBatch batch_{};
  March march_;
  std::array<Pair, 8> followed_;  // per lane of the march
};

}  // namespace

void gather(const NarrowStep& step, Chunk& chunk) {
  constexpr std::size_t kAhead = 2;
  chunk.candidates.clear();
  chunk.ends.clear();
  for (std::size_t i = 0; i < chunk.pairs.size(); ++i) {
    const LeafPairRef& pair = chunk.pairs[i];
    if (i + kAhead < chunk.pairs.size()) {
      const LeafPairRef& later = chunk.pairs[i + kAhead];
      prefetch_features(step.tasks[later.task].traversal, later.leaves);
    }
    find_candidates(step.tasks[pair.task].traversal, pair.leaves, chunk.candidates);
    chunk.ends.push_back({chunk.candidates.vertex_face.size(), chunk.candidates.face_vertex.size(),
                          chunk.candidates.edge_edge.size()});
  }
}

namespace {

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

namespace {

// By ids, so that neither the hierarchy nor the threads show in the answer; where only the earliest is
// wanted, by time first.
struct Before {
  bool earliest_first;
  template <class Collision>
  bool operator()(const Collision& a, const Collision& b) const {
    if (earliest_first && a.toi != b.toi) return a.toi < b.toi;
    return key(a) < key(b);
  }
};

template <class Collision>
Shortlist<Collision, Before> shortlist(std::vector<Collision>& list, bool earliest_only,
                                       std::uint64_t max_listed) {
  return {list, earliest_only ? 1 : max_listed, Before{earliest_only}};
}

const DistinctTriangles* copies_in(DistinctObjects distinct, Index object) {
  return distinct.empty() || !distinct[object]->has_copies() ? nullptr : distinct[object].get();
}

// With every copy of its face.
void take(const NarrowStep& step, VertexFaceCollision found, Shortlist<VertexFaceCollision, Before>& list,
          StepResult& out) {
  const DistinctTriangles* distinct = copies_in(step.distinct, found.face_object);
  if (distinct == nullptr) {
    ++out.vertex_face_count;
    list.add(found);
    return;
  }
  const auto copies = distinct->copies(found.face);
  out.vertex_face_count += copies.size();
  out.work.undecided += found.answer == Answer::Undecided ? copies.size() - 1 : 0;
  for (const Index copy : copies) {
    found.face = copy;
    if (!list.add(found)) break;
  }
}

// Keeps the one pair with the smallest time; vertex-face before edge-edge, then smaller ids.
void keep_earliest(StepResult& out) {
  auto& vf = out.vertex_face;
  auto& ee = out.edge_edge;
  if (!vf.empty() && vf[0].toi == out.earliest_toi) {
    ee.clear();
  } else {
    vf.clear();
  }
  out.vertex_face_count = vf.size();
  out.edge_edge_count = ee.size();
}

}  // namespace

void finish(const StepSettings& settings, StepResult& out) {
  shortlist(out.vertex_face, settings.earliest_only, settings.max_listed).finish();
  shortlist(out.edge_edge, settings.earliest_only, settings.max_listed).finish();
  if (settings.earliest_only) keep_earliest(out);
}

void take_found(const NarrowStep& step, Chunk& c, StepResult& out) {
  out.work.candidates_vf += c.candidates.vertex_face.size() + c.candidates.face_vertex.size();
  out.work.candidates_ee += c.candidates.edge_edge.size();
  out.work.undecided += std::exchange(c.undecided, 0);
  const bool earliest_only = step.earliest != nullptr;
  auto vertex_face = shortlist(out.vertex_face, earliest_only, step.max_listed);
  for (const VertexFaceCollision& found : c.vertex_face) {
    out.earliest_toi = std::min(out.earliest_toi, found.toi);
    take(step, found, vertex_face, out);
  }
  auto edge_edge = shortlist(out.edge_edge, earliest_only, step.max_listed);
  for (const EdgeEdgeCollision& found : c.edge_edge) {
    out.earliest_toi = std::min(out.earliest_toi, found.toi);
    edge_edge.add(found);
  }
  out.edge_edge_count += c.edge_edge.size();
  c.vertex_face.clear();
  c.edge_edge.clear();
}

void test_round(const NarrowStep& step, std::span<Chunk> chunks, Stopwatch& watch, StepResult& out) {
  parallel_for(std::size_t{0}, chunks.size(), [&](std::size_t i) { gather(step, chunks[i]); });
  out.milliseconds.traverse += watch.lap();
  parallel_for(std::size_t{0}, chunks.size(), [&](std::size_t i) { narrow(step, chunks[i]); });
  for (Chunk& chunk : chunks) take_found(step, chunk, out);
  out.milliseconds.narrow += watch.lap();
}

void spread(DistinctObjects distinct, Explanation& explanation) {
  for (std::size_t i = 0; i < distinct.size(); ++i) {
    if (!distinct[i]->has_copies()) continue;
    Explanation::Object& object = explanation.objects[i];
    distinct[i]->spread(object.level);
    distinct[i]->spread(object.margin);
    distinct[i]->spread(object.reason);
  }
}

void clear(StepResult& out) {
  out.vertex_face.clear();
  out.edge_edge.clear();
  out.vertex_face_count = out.edge_edge_count = 0;
  out.earliest_toi = 1;
  out.work = {};
  out.milliseconds = {};
}

// Never below what doubles can tell apart, so that the narrow phase need not raise it (soundness.md, C1).
double tolerance_for(const StepSettings& settings, double side) {
  // Four times the side need not be a number.
  const double automatic = side * 0x1p-30,
               least = std::isfinite(4 * side) ? ccd_resolution(std::max(4 * side, settings.thickness))
                                               : 4 * ccd_resolution(std::max(side, settings.thickness / 4));
  return std::max(settings.tolerance > 0 ? settings.tolerance : automatic, least);
}

Result<void> check_settings(const StepSettings& settings) {
  for (const auto& [name, value] :
       {std::pair("thickness", settings.thickness), std::pair("tolerance", settings.tolerance)}) {
    if (!(value >= 0) || !std::isfinite(value))
      return fail(name, "is not a length", "give a number of at least 0");
  }
  return {};
}

}  // namespace foldproof
