#include "check/answer.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "check/smallest_k.h"

namespace foldproof::internal {
namespace {

auto key(const VertexFaceCollision& c) {
  return std::tuple(c.vertex_object, c.vertex, c.face_object, c.face);
}
auto key(const EdgeEdgeCollision& c) { return std::tuple(c.object_a, c.a, c.object_b, c.b); }

// Orders by ids, so that the answer depends neither on the hierarchy nor on threads; with earliest_only by
// time first.
struct Before {
  bool earliest_first;
  template <class Collision>
  bool operator()(const Collision& a, const Collision& b) const {
    if (earliest_first && a.toi != b.toi) return a.toi < b.toi;
    return key(a) < key(b);
  }
};

template <class Collision>
SmallestK<Collision, Before> smallest(std::vector<Collision>& list, bool earliest_only,
                                      std::uint64_t max_listed) {
  return {list, earliest_only ? 1 : max_listed, Before{earliest_only}};
}

const DistinctTriangles* copies_in(DistinctObjects distinct, Index object) {
  return distinct.empty() || !distinct[object]->has_copies() ? nullptr : distinct[object].get();
}

// Adds a collision with every copy of its face.
void add_copies(const NarrowStep& step, VertexFaceCollision found,
                SmallestK<VertexFaceCollision, Before>& list, StepResult& out) {
  const DistinctTriangles* distinct = copies_in(step.filter.distinct, found.face_object);
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

// Whether an earlier search of the same step has found the pair undecided, too.
template <class Collision, class Keys>
bool is_repeated(const Collision& hit, Keys* undecided, Work& work) {
  if (undecided == nullptr || hit.answer != Answer::Undecided || undecided->insert(key(hit)).second)
    return false;
  --work.undecided;
  return true;
}

// Keeps only the pair with the smallest time; ties: vertex-face before edge-edge.
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
  smallest(out.vertex_face, settings.earliest_only, settings.max_listed).finish();
  smallest(out.edge_edge, settings.earliest_only, settings.max_listed).finish();
  if (settings.earliest_only) keep_earliest(out);
}

void add_collisions(const NarrowStep& step, const Hits& hits, StepResult& out) {
  out.work += hits.work;
  const bool earliest_only = step.earliest != nullptr;
  auto vertex_face = smallest(out.vertex_face, earliest_only, step.max_listed);
  UndecidedPairs* const undecided = step.undecided;
  for (const VertexFaceCollision& hit : hits.vertex_face) {
    if (is_repeated(hit, undecided != nullptr ? &undecided->vertex_face : nullptr, out.work)) continue;
    out.earliest_toi = std::min(out.earliest_toi, hit.toi);
    add_copies(step, hit, vertex_face, out);
  }
  auto edge_edge = smallest(out.edge_edge, earliest_only, step.max_listed);
  for (const EdgeEdgeCollision& hit : hits.edge_edge) {
    if (is_repeated(hit, undecided != nullptr ? &undecided->edge_edge : nullptr, out.work)) continue;
    out.earliest_toi = std::min(out.earliest_toi, hit.toi);
    ++out.edge_edge_count;
    edge_edge.add(hit);
  }
}

void explain_copies(DistinctObjects distinct, Explanation& explanation) {
  for (std::size_t i = 0; i < distinct.size(); ++i) {
    if (!distinct[i]->has_copies()) continue;
    Explanation::Object& object = explanation.objects[i];
    distinct[i]->expand(object.level);
    distinct[i]->expand(object.margin);
    distinct[i]->expand(object.reason);
  }
}

void clear(StepResult& out) {
  out.complete = false;
  out.vertex_face.clear();
  out.edge_edge.clear();
  out.vertex_face_count = out.edge_edge_count = 0;
  out.tolerance = 0;
  out.search_steps = 1;
  out.earliest_toi = 1;
  out.work = {};
  out.milliseconds = {};
}

// Never below the resolution of doubles, so that the narrow phase need not raise it (docs/soundness.md, C1).
double tolerance_for(const StepSettings& settings, double extent) {
  const double automatic = extent * 0x1p-30;
  const double resolution = std::isfinite(4 * extent)
                                ? ccd_resolution(std::max(4 * extent, settings.thickness))
                                : 4 * ccd_resolution(std::max(extent, settings.thickness / 4));
  return std::max(settings.tolerance > 0 ? settings.tolerance : automatic, resolution);
}

Result<void> check_settings(const StepSettings& settings, std::size_t objects) {
  if (!settings.between && !settings.within)
    return fail(ErrorCode::InvalidArgument, "within and between", "are both off, so nothing would be tested",
                "leave one of them on");
  if (!settings.within && objects == 1)
    return fail(ErrorCode::InvalidArgument, "within",
                "is off, but there is only one object, so nothing would be tested",
                "leave it on, or give more objects");
  for (const auto& [name, value] :
       {std::pair("thickness", settings.thickness), std::pair("tolerance", settings.tolerance)}) {
    if (!(value >= 0) || !std::isfinite(value))
      return fail(ErrorCode::InvalidArgument, name, "is not a length", "give a number of at least 0");
  }
  return {};
}

}  // namespace foldproof::internal
