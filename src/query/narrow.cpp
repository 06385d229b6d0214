#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "ccd/march.h"
#include "query/narrow.h"

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

FourPoints vertex_face_points(Positions x, const VertexFaceCollision& pair, const Triangle& t) {
  const auto face = x[pair.face_object];
  return {position(x[pair.vertex_object], pair.vertex), position(face, t[0]), position(face, t[1]),
          position(face, t[2])};
}

FourPoints edge_edge_points(Positions x, const EdgeEdgeCollision& pair) {
  const auto a = x[pair.object_a], b = x[pair.object_b];
  return {position(a, pair.a[0]), position(a, pair.a[1]), position(b, pair.b[0]), position(b, pair.b[1])};
}

VertexFaceCollision vertex_face_pair(const NarrowStep& step, Index vertex_object, Index vertex,
                                     Index face_object, Index face) {
  return {vertex_object,
          step.hierarchy(vertex_object).vertex_ids()[vertex],
          face_object,
          step.hierarchy(face_object).triangle_ids()[face],
          1,
          Answer::Separated};
}

EdgeEdgeCollision edge_edge_pair(const NarrowStep& step, Index object_a, Index place_a, Index object_b,
                                 Index place_b) {
  const auto edge_of = [&](Index object, Index place) {
    const Hierarchy& h = step.hierarchy(object);
    return h.topology().edges()[h.edge_ids()[place]];
  };
  EdgeEdgeCollision pair{object_a, edge_of(object_a, place_a), object_b, edge_of(object_b, place_b),
                         1,        Answer::Separated};
  // One order of the two, whatever the hierarchy: the answer to a pair is then a property of the pair.
  if (object_a == object_b && pair.b < pair.a) std::swap(pair.a, pair.b);
  return pair;
}

// Collects pairs of one kind until there are eight, drops those that the first test proves apart, and follows
// the rest, eight at a time.
template <class Pair>
class Narrow {
 public:
  Narrow(const NarrowStep& step, std::vector<Pair>& hits, std::uint64_t& undecided)
      : step_(step), hits_(hits), undecided_(undecided), march_(kEdgeEdge, step.ccd) {}

  void add(const Pair& pair) {
    if (step_.choice != nullptr && !chosen(pair)) return;
    pairs_[count_] = pair;
    batch_.set(count_, points(step_.x0, pair), points(step_.x1, pair));
    if (++count_ == 8) start();
  }

  void finish() {
    if (count_ > 0) start();
    while (march_.busy()) look();
  }

 private:
  static constexpr bool kEdgeEdge = std::is_same_v<Pair, EdgeEdgeCollision>;

  bool chosen(const Pair& pair) const {
    if constexpr (kEdgeEdge) {
      return step_.choice->edge_edge(pair.a, pair.b);
    } else {
      return step_.choice->vertex_face(pair.vertex, pair.face);
    }
  }

  FourPoints points(Positions x, const Pair& pair) const {
    if constexpr (kEdgeEdge) {
      return edge_edge_points(x, pair);
    } else {
      return vertex_face_points(x, pair, step_.hierarchy(pair.face_object).topology().triangles()[pair.face]);
    }
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

void gather(const NarrowStep& step, Chunk& chunk) {
  chunk.candidates.clear();
  chunk.ends.clear();
  for (const LeafPairRef& pair : chunk.pairs) {
    find_candidates(step.tasks[pair.task].traversal, pair.leaves, chunk.candidates);
    chunk.ends.push_back({chunk.candidates.vertex_face.size(), chunk.candidates.face_vertex.size(),
                          chunk.candidates.edge_edge.size()});
  }
}

void narrow(const NarrowStep& step, Chunk& chunk) {
  Narrow<VertexFaceCollision> vertex_face(step, chunk.vertex_face, chunk.undecided);
  Narrow<EdgeEdgeCollision> edge_edge(step, chunk.edge_edge, chunk.undecided);
  Chunk::Ends done{0, 0, 0};
  for (std::size_t i = 0; i < chunk.pairs.size(); ++i) {
    const TraversalTask& task = step.tasks[chunk.pairs[i].task];
    const Index a = task.object_a, b = task.object_b;
    const CandidateBuffer& c = chunk.candidates;
    for (; done.vertex_face < chunk.ends[i].vertex_face; ++done.vertex_face) {
      const auto pair = c.vertex_face[done.vertex_face];
      vertex_face.add(vertex_face_pair(step, a, pair.a, b, pair.b));
    }
    for (; done.face_vertex < chunk.ends[i].face_vertex; ++done.face_vertex) {
      const auto pair = c.face_vertex[done.face_vertex];
      vertex_face.add(vertex_face_pair(step, b, pair.b, a, pair.a));
    }
    for (; done.edge_edge < chunk.ends[i].edge_edge; ++done.edge_edge) {
      const auto pair = c.edge_edge[done.edge_edge];
      edge_edge.add(edge_edge_pair(step, a, pair.a, b, pair.b));
    }
  }
  vertex_face.finish();
  edge_edge.finish();
}

// Sorts by ids, so that neither the hierarchy nor the threads show in the answer.
template <class Collision>
void sort_by_ids(std::vector<Collision>& collisions) {
  std::sort(collisions.begin(), collisions.end(),
            [](const Collision& a, const Collision& b) { return key(a) < key(b); });
}

// Keeps the one pair with the smallest time; vertex-face before edge-edge, then smaller ids.
void keep_earliest(StepResult& out) {
  const auto first_at = [](auto& list, double toi) {
    auto it = std::find_if(list.begin(), list.end(), [&](const auto& c) { return c.toi == toi; });
    if (it == list.end()) {
      list.clear();
      return false;
    }
    list.front() = *it;
    list.resize(1);
    return true;
  };
  if (first_at(out.vertex_face, out.earliest_toi)) {
    out.edge_edge.clear();
  } else {
    first_at(out.edge_edge, out.earliest_toi);
  }
}

}  // namespace

void finish(const StepSettings& settings, StepResult& out) {
  sort_by_ids(out.vertex_face);
  sort_by_ids(out.edge_edge);
  for (const auto& c : out.vertex_face) out.earliest_toi = std::min(out.earliest_toi, c.toi);
  for (const auto& c : out.edge_edge) out.earliest_toi = std::min(out.earliest_toi, c.toi);
  if (settings.earliest_only && !out.clean()) keep_earliest(out);
}

void test_round(const NarrowStep& step, std::span<Chunk> chunks, Stopwatch& watch, StepResult& out) {
  tbb::parallel_for(std::size_t{0}, chunks.size(), [&](std::size_t i) { gather(step, chunks[i]); });
  out.milliseconds.traverse += watch.lap();
  tbb::parallel_for(std::size_t{0}, chunks.size(), [&](std::size_t i) { narrow(step, chunks[i]); });
  for (Chunk& c : chunks) {
    out.work.candidates_vf += c.candidates.vertex_face.size() + c.candidates.face_vertex.size();
    out.work.candidates_ee += c.candidates.edge_edge.size();
    out.work.undecided += std::exchange(c.undecided, 0);
    out.vertex_face.insert(out.vertex_face.end(), c.vertex_face.begin(), c.vertex_face.end());
    out.edge_edge.insert(out.edge_edge.end(), c.edge_edge.begin(), c.edge_edge.end());
    c.vertex_face.clear();
    c.edge_edge.clear();
  }
  out.milliseconds.narrow += watch.lap();
}

void clear(StepResult& out) {
  out.vertex_face.clear();
  out.edge_edge.clear();
  out.earliest_toi = 1;
  out.work = {};
  out.milliseconds = {};
}

// Never below what doubles can tell apart, so that the narrow phase need not raise it (soundness.md, C1).
double tolerance_for(const StepSettings& settings, double side) {
  const double automatic = side * 0x1p-30, least = ccd_resolution(std::max(4 * side, settings.thickness));
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
