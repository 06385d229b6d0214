// FaceMarks and colors of faces from an answer.
#include <algorithm>

#include "report/report.h"

namespace foldproof {
namespace {

/// Collects the faces of one object that collide, and those around its colliding vertices and edges.
class FaceMarks {
 public:
  FaceMarks(const Topology& topology, Index object)
      : topology_(topology),
        object_(object),
        faces_(topology.triangles().size()),
        vertex_hit_(topology.vertex_count()),
        edge_hit_(topology.edges().size()) {}

  void face(Index object, Index face) {
    if (object == object_) faces_[face] = 1;
  }
  void vertex(Index object, Index vertex) {
    if (object == object_) vertex_hit_[vertex] = 1;
  }
  void edge(Index object, Edge edge) {
    if (object != object_) return;
    const auto edges = topology_.edges();
    edge_hit_[static_cast<std::size_t>(std::lower_bound(edges.begin(), edges.end(), edge) - edges.begin())] =
        1;
  }

  std::vector<std::uint8_t> finish() {
    const auto triangles = topology_.triangles();
    const auto triangle_edges = topology_.triangle_edges();
    for (std::size_t face = 0; face < triangles.size(); ++face) {
      for (int k = 0; k < 3; ++k) {
        const Index edge = triangle_edges[face][k];
        if (vertex_hit_[triangles[face][k]] || (edge != kNoIndex && edge_hit_[edge])) faces_[face] = 1;
      }
    }
    return std::move(faces_);
  }

 private:
  const Topology& topology_;
  Index object_;
  std::vector<std::uint8_t> faces_, vertex_hit_, edge_hit_;
};

}  // namespace

std::optional<std::vector<std::uint8_t>> inside_faces(const Topology& topology, Index object,
                                                      const CheckedStep& step) {
  if (!step.contacts || !step.contacts->is_known()) {
    if (step.pose) return colliding_faces(topology, object, *step.pose);
    return std::nullopt;
  }
  FaceMarks marks(topology, object);
  for (const TriangleCrossing& c : step.contacts->crossings()) {
    marks.face(c.object_a, c.triangle_a);
    marks.face(c.object_b, c.triangle_b);
  }
  for (const ContactFinder::Inside& in : step.contacts->inside()) marks.face(in.object, in.triangle);
  return marks.finish();
}

std::vector<std::uint8_t> colliding_faces(const Topology& topology, Index object, const StepResult& answer) {
  FaceMarks marks(topology, object);
  for (const VertexFaceCollision& c : answer.vertex_face) {
    marks.face(c.face_object, c.face);
    marks.vertex(c.vertex_object, c.vertex);
  }
  for (const EdgeEdgeCollision& c : answer.edge_edge) {
    marks.edge(c.object_a, c.a);
    marks.edge(c.object_b, c.b);
  }
  return marks.finish();
}

std::vector<std::uint8_t> colliding_faces(const Topology& topology, Index object,
                                          const StaticResult& answer) {
  FaceMarks marks(topology, object);
  for (const TriangleCrossing& c : answer.crossings) {
    marks.face(c.object_a, c.triangle_a);
    marks.face(c.object_b, c.triangle_b);
  }
  return marks.finish();
}

}  // namespace foldproof
