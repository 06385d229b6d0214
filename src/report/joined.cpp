#include "report/joined.h"

#include <algorithm>
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

void mark_meeting(const JoinedMesh& joined, Motions motions, const CheckedStep& step,
                  std::vector<std::uint8_t>& out) {
  out.assign(joined.topology.triangles().size(), 0);
  for (Index object = 0; step.step && object < motions.size(); ++object)
    joined.put(object, colliding_faces(motions[object]->topology(), object, *step.step), out);
}

void InsideMarks::update(const JoinedMesh& joined, Motions motions, const CheckedStep& step) {
  inside.assign(joined.topology.triangles().size(), 0);
  for (Index object = 0; object < motions.size(); ++object) {
    const auto marks = inside_faces(motions[object]->topology(), object, step);
    if (marks) joined.put(object, *marks, inside);
  }
  count = static_cast<std::uint64_t>(std::count(inside.begin(), inside.end(), 1));
  deepest = 0;
  // Where the first frame was not tested, steps do not tell.
  if (!step.contacts || (step.step && number.empty())) return;
  const ContactFinder& contacts = *step.contacts;
  number.assign(inside.size(), contacts.is_known() ? 0 : -1);
  depth.assign(number.size(), 0);
  if (!contacts.is_known()) return;
  const auto mark = [&](Index object, Index triangle, Index contact) {
    const std::size_t face = joined.triangle(object, triangle);
    const double now = contacts.depth_now(contact).value_or(0);
    number[face] = static_cast<std::int32_t>(contact);
    depth[face] = static_cast<float>(now);
    deepest = std::max(deepest, now);
  };
  const auto crossings = contacts.crossings();
  const auto of_crossings = contacts.crossing_contacts();
  for (std::size_t i = 0; i < crossings.size(); ++i) {
    mark(crossings[i].object_a, crossings[i].triangle_a, of_crossings[i]);
    mark(crossings[i].object_b, crossings[i].triangle_b, of_crossings[i]);
  }
  for (const ContactFinder::Inside& in : contacts.inside()) mark(in.object, in.triangle, in.contact);
}

Result<JoinedMesh> join(Motions motions, const char* option) {
  JoinedMesh joined;
  std::uint64_t vertices = 0;
  std::vector<Triangle> faces;
  std::vector<Edge> lines;
  std::vector<Index> points;
  for (const auto& motion : motions) {
    const Topology& topology = motion->topology();
    joined.first_vertex.push_back(vertices);
    joined.places.push_back(
        {{faces.size(), lines.size(), points.size()}, topology.face_count(), topology.line_count()});
    const auto offset = static_cast<Index>(vertices);
    for (const Triangle& t : topology.faces()) faces.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
    for (const auto& [a, b] : topology.lines()) lines.push_back({a + offset, b + offset});
    for (const Index p : topology.points()) points.push_back(p + offset);
    vertices += topology.vertex_count();
    if (vertices >= kNoIndex || faces.size() + lines.size() + points.size() >= kNoIndex) {
      return fail(ErrorCode::LimitExceeded, option, "all objects together are too large for one mesh",
                  "check fewer objects at a time");
    }
  }
  for (auto& [first, own_faces, own_lines] : joined.places) {
    first[1] += faces.size();
    first[2] += faces.size() + lines.size();
  }
  joined.topology =
      FOLDPROOF_TRY(Topology::make(static_cast<Index>(vertices), std::move(faces), lines, points));
  return joined;
}

}  // namespace foldproof
