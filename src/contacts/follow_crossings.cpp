#include "contacts/follow_crossings.h"

#include <algorithm>
#include <tuple>

#include "base/parallel.h"
#include "check/triangles_cross.h"

namespace foldproof::internal {
namespace {

TriangleCrossing ordered(Index object_a, Index a, Index object_b, Index b) {
  return std::pair(object_b, b) < std::pair(object_a, a) ? TriangleCrossing{object_b, b, object_a, a}
                                                         : TriangleCrossing{object_a, a, object_b, b};
}

// The pairs of triangles that have a colliding pair of features, each once, sorted.
void list_pairs(const Surfaces& surfaces, const PairFilter* filter, const StepResult& step,
                std::vector<TriangleCrossing>& out) {
  out.clear();
  for (const VertexFaceCollision& c : step.vertex_face) {
    for (const Index t : surfaces.triangles_at(c.vertex_object, c.vertex))
      out.push_back(ordered(c.vertex_object, t, c.face_object, c.face));
  }
  std::vector<Index> at_a, at_b;
  for (const EdgeEdgeCollision& c : step.edge_edge) {
    surfaces.triangles_with_edge(c.object_a, c.a, at_a);
    surfaces.triangles_with_edge(c.object_b, c.b, at_b);
    for (const Index a : at_a) {
      for (const Index b : at_b) out.push_back(ordered(c.object_a, a, c.object_b, b));
    }
  }
  if (filter != nullptr) {
    std::erase_if(out, [&](const TriangleCrossing& c) {
      return !filter->crossing(c.object_a, c.triangle_a, c.object_b, c.triangle_b);
    });
  }
  std::sort(out.begin(), out.end(), is_before);
  const auto same = [](const TriangleCrossing& a, const TriangleCrossing& b) {
    return !is_before(a, b) && !is_before(b, a);
  };
  out.erase(std::unique(out.begin(), out.end(), same), out.end());
}

bool cross(const Surfaces& surfaces, Positions x, const TriangleCrossing& c) {
  const Triangle &s = surfaces.topology(c.object_a).triangles()[c.triangle_a],
                 &t = surfaces.topology(c.object_b).triangles()[c.triangle_b];
  if (c.object_a == c.object_b) {
    return may_cross(surfaces.topology(c.object_a), c.triangle_a, c.triangle_b) &&
           triangles_cross(x[c.object_a], s, t);
  }
  return triangles_intersect(corners(x[c.object_a], s), corners(x[c.object_b], t));
}

}  // namespace

bool is_before(const TriangleCrossing& a, const TriangleCrossing& b) {
  return std::tie(a.object_a, a.triangle_a, a.object_b, a.triangle_b) <
         std::tie(b.object_a, b.triangle_a, b.object_b, b.triangle_b);
}

void follow_crossings(const Surfaces& surfaces, const PairFilter* filter, const StepResult& step,
                      Positions x1, std::vector<TriangleCrossing>& tested,
                      std::vector<TriangleCrossing>& crossings) {
  list_pairs(surfaces, filter, step, tested);
  if (tested.empty()) return;
  std::vector<TriangleCrossing> kept;
  std::set_difference(crossings.begin(), crossings.end(), tested.begin(), tested.end(),
                      std::back_inserter(kept), is_before);
  std::vector<std::uint8_t> crosses(tested.size());
  parallel_for(IndexRange{0, tested.size()}, 256, [&](IndexRange range) {
    for (std::size_t i = range.begin; i < range.end; ++i) crosses[i] = cross(surfaces, x1, tested[i]);
  });
  std::size_t count = 0;
  for (std::size_t i = 0; i < tested.size(); ++i) {
    if (crosses[i]) tested[count++] = tested[i];
  }
  tested.resize(count);
  crossings.clear();
  std::merge(kept.begin(), kept.end(), tested.begin(), tested.end(), std::back_inserter(crossings),
             is_before);
}

}  // namespace foldproof::internal
