#include "report/joined.h"

#include <cmath>

#include "base/try.h"

namespace foldproof {

void JoinedMesh::pose(const CheckedStep& step, double t, std::vector<double>& out) const {
  out.resize(std::size_t{topology.vertex_count()} * 3);
  for (std::size_t object = 0; object < step.x0.size(); ++object) {
    const std::span<const double> x0 = step.x0[object], x1 = step.x1[object];
    double* x = out.data() + first_vertex[object] * 3;
    for (std::size_t k = 0; k < x0.size(); ++k) x[k] = std::lerp(x0[k], x1[k], t);
  }
}

void mark_faces(Motions motions, const CheckedStep& step, std::vector<std::uint8_t>& out) {
  out.clear();
  for (Index object = 0; object < motions.size(); ++object) {
    const Topology& topology = motions[object]->topology();
    const auto marks = step.pose ? colliding_faces(topology, object, *step.pose)
                                 : colliding_faces(topology, object, *step.step);
    out.insert(out.end(), marks.begin(), marks.end());
  }
}

Result<JoinedMesh> join(Motions motions, const char* option) {
  JoinedMesh joined;
  std::size_t vertices = 0;
  std::vector<Triangle> triangles;
  for (const auto& motion : motions) {
    joined.first_vertex.push_back(vertices);
    joined.first_face.push_back(triangles.size());
    const auto offset = static_cast<Index>(vertices);
    for (const Triangle& t : motion->topology().triangles()) {
      triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
    }
    vertices += motion->topology().vertex_count();
    if (vertices >= kNoIndex || triangles.size() >= kNoIndex) {
      return fail(ErrorCode::LimitExceeded, option, "all objects together are too large for one mesh",
                  "check fewer objects at a time");
    }
  }
  joined.topology = FOLDPROOF_TRY(Topology::make(static_cast<Index>(vertices), std::move(triangles)));
  return joined;
}

}  // namespace foldproof
