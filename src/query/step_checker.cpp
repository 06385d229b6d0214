#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <tuple>

#include "query/checker.h"

namespace foldproof {
namespace {

auto key(const VertexFaceCollision& c) { return std::tuple(c.vertex_object, c.vertex, c.face_object, c.face); }
auto key(const EdgeEdgeCollision& c) { return std::tuple(c.object_a, c.a, c.object_b, c.b); }

// What the narrow phase needs to know about the step.
struct Step {
  const Scene& scene;
  Positions x0, x1;
  CcdSettings ccd;
  std::atomic<double>* earliest;  // null unless only the earliest is wanted
};

// Lowers `earliest` to a collision's time. Later candidates stop as soon as they are proven free until then.
void note_earliest(const Step& step, double toi) {
  double now = step.earliest->load(std::memory_order_relaxed);
  while (toi < now && !step.earliest->compare_exchange_weak(now, toi, std::memory_order_relaxed)) {
  }
}

CcdSettings settings_now(const Step& step) {
  CcdSettings ccd = step.ccd;
  if (step.earliest != nullptr) ccd.latest = step.earliest->load(std::memory_order_relaxed);
  return ccd;
}

void test_vertex_face(const Step& step, Index vertex_object, Index vertex, Index face_object, Index face, Chunk& out) {
  const Index v = step.scene.hierarchy(vertex_object).vertex_ids()[vertex];
  const Index f = step.scene.hierarchy(face_object).triangle_ids()[face];
  const Triangle& t = step.scene.hierarchy(face_object).topology().triangles()[f];
  const auto points = [&](Positions x) {
    const auto of_face = x[face_object];
    return FourPoints{position(x[vertex_object], v), position(of_face, t[0]), position(of_face, t[1]), position(of_face, t[2])};
  };
  const CcdResult result = vertex_face_ccd(points(step.x0), points(step.x1), settings_now(step));
  if (result.answer == Answer::Separated) return;
  if (step.earliest != nullptr) note_earliest(step, result.toi);
  out.undecided += result.answer == Answer::Undecided;
  out.vertex_face.push_back({vertex_object, v, face_object, f, result.toi, result.answer});
}

void test_edge_edge(const Step& step, Index object_a, Index place_a, Index object_b, Index place_b, Chunk& out) {
  const auto edge_of = [&](Index object, Index place) {
    const Hierarchy& h = step.scene.hierarchy(object);
    return h.topology().edges()[h.edge_ids()[place]];
  };
  Edge a = edge_of(object_a, place_a), b = edge_of(object_b, place_b);
  // One order of the two, whatever the hierarchy: the answer to a pair is then a property of the pair.
  if (object_a == object_b && b < a) std::swap(a, b);
  const auto points = [&](Positions x) {
    const auto xa = x[object_a], xb = x[object_b];
    return FourPoints{position(xa, a[0]), position(xa, a[1]), position(xb, b[0]), position(xb, b[1])};
  };
  const CcdResult result = edge_edge_ccd(points(step.x0), points(step.x1), settings_now(step));
  if (result.answer == Answer::Separated) return;
  if (step.earliest != nullptr) note_earliest(step, result.toi);
  out.undecided += result.answer == Answer::Undecided;
  out.edge_edge.push_back({object_a, a, object_b, b, result.toi, result.answer});
}

void gather(const Scene& scene, Chunk& chunk) {
  chunk.candidates.clear();
  chunk.ends.clear();
  for (const LeafPairRef& pair : chunk.pairs) {
    find_candidates(scene.task(pair.task).traversal, pair.leaves, chunk.candidates);
    chunk.ends.push_back({chunk.candidates.vertex_face.size(), chunk.candidates.face_vertex.size(),
                          chunk.candidates.edge_edge.size()});
  }
}

void narrow(const Step& step, Chunk& chunk) {
  Chunk::Ends done{0, 0, 0};
  for (std::size_t i = 0; i < chunk.pairs.size(); ++i) {
    const TraversalTask& task = step.scene.task(chunk.pairs[i].task);
    const Index a = task.object_a, b = task.object_b;
    const CandidateBuffer& c = chunk.candidates;
    for (; done.vertex_face < chunk.ends[i].vertex_face; ++done.vertex_face) {
      const auto pair = c.vertex_face[done.vertex_face];
      test_vertex_face(step, a, pair.a, b, pair.b, chunk);
    }
    for (; done.face_vertex < chunk.ends[i].face_vertex; ++done.face_vertex) {
      const auto pair = c.face_vertex[done.face_vertex];
      test_vertex_face(step, b, pair.b, a, pair.a, chunk);
    }
    for (; done.edge_edge < chunk.ends[i].edge_edge; ++done.edge_edge) {
      const auto pair = c.edge_edge[done.edge_edge];
      test_edge_edge(step, a, pair.a, b, pair.b, chunk);
    }
  }
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

void finish(const StepSettings& settings, StepResult& out) {
  sort_by_ids(out.vertex_face);
  sort_by_ids(out.edge_edge);
  for (const auto& c : out.vertex_face) out.earliest_toi = std::min(out.earliest_toi, c.toi);
  for (const auto& c : out.edge_edge) out.earliest_toi = std::min(out.earliest_toi, c.toi);
  if (settings.earliest_only && !out.clean()) keep_earliest(out);
}

// First all candidates of a round, then the narrow phase on them.
void test_round(const Step& step, std::span<Chunk> chunks, Stopwatch& watch, StepResult& out) {
  tbb::parallel_for(std::size_t{0}, chunks.size(), [&](std::size_t i) { gather(step.scene, chunks[i]); });
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

Result<void> check_settings(const StepSettings& settings) {
  for (const auto& [name, value] : {std::pair("thickness", settings.thickness), std::pair("tolerance", settings.tolerance)}) {
    if (!(value >= 0) || !std::isfinite(value)) return fail(name, "is not a length", "give a number of at least 0");
  }
  return {};
}

}  // namespace

StepChecker::StepChecker(std::vector<std::shared_ptr<const Hierarchy>> objects)
    : impl_(new Impl{Scene(std::move(objects)), {}}) {}
StepChecker::~StepChecker() = default;
StepChecker::StepChecker(StepChecker&&) noexcept = default;
StepChecker& StepChecker::operator=(StepChecker&&) noexcept = default;

Result<void> StepChecker::check(Positions x0, Positions x1, const StepSettings& settings, StepResult& out) {
  Stopwatch total, watch;
  out.vertex_face.clear();
  out.edge_edge.clear();
  out.earliest_toi = 1;
  out.work = {};
  out.milliseconds = {};
  if (auto ok = check_settings(settings); !ok) return ok;
  Scene& scene = impl_->scene;
  if (auto ok = scene.update(x0, x1); !ok) return ok;
  out.milliseconds.update = watch.lap();

  // Never below what doubles can tell apart, so that the narrow phase need not raise it (soundness.md, C1).
  const double side = scene.largest_side();
  const double automatic = side * 0x1p-30, least = ccd_resolution(std::max(4 * side, settings.thickness));
  out.tolerance = std::max(settings.tolerance > 0 ? settings.tolerance : automatic, least);
  scene.traverse(settings, settings.thickness + out.tolerance, out.work);
  out.milliseconds.traverse = watch.lap();

  std::atomic<double> earliest{1};
  Step step{scene, x0, x1, {}, settings.earliest_only ? &earliest : nullptr};
  step.ccd.thickness = settings.thickness;
  step.ccd.tolerance = out.tolerance;
  impl_->in_rounds([&](std::size_t count) { test_round(step, std::span(impl_->chunks).first(count), watch, out); });
  finish(settings, out);
  out.milliseconds.narrow += watch.lap();
  out.milliseconds.total = total.lap();
  return {};
}

}  // namespace foldproof
