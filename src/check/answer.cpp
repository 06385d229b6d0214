#include "check/answer.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "check/shortlist.h"

namespace foldproof {
namespace {

auto key(const VertexFaceCollision& c) {
  return std::tuple(c.vertex_object, c.vertex, c.face_object, c.face);
}
auto key(const EdgeEdgeCollision& c) { return std::tuple(c.object_a, c.a, c.object_b, c.b); }

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

Work& Work::operator+=(const Work& more) {
  node_tests += more.node_tests;
  certificate_tests += more.certificate_tests;
  certificate_passes += more.certificate_passes;
  leaf_pairs += more.leaf_pairs;
  candidates_vf += more.candidates_vf;
  candidates_ee += more.candidates_ee;
  undecided += more.undecided;
  return *this;
}

StageTimes& StageTimes::operator+=(const StageTimes& more) {
  total += more.total;
  update += more.update;
  traverse += more.traverse;
  narrow += more.narrow;
  return *this;
}

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
  out.tolerance = 0;
  out.searched = 1;
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
