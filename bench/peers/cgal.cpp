/// CGAL: box_intersection_d, a streamed hybrid of segment trees and sweeps. No hierarchy is kept.
#include <CGAL/box_intersection_d.h>
#include <CGAL/version.h>

#include "competitor.h"
#include "swept_boxes.h"

namespace foldproof::bench {
namespace {

using CgalBox = CGAL::Box_intersection_d::Box_with_info_d<float, 3, Index>;

CgalBox cgal_box(Box box, Index id) { return CgalBox(box.lo.data(), box.hi.data(), id); }

class CgalPeer : public Peer {
 public:
  void inflate(double distance) override { boxes_.margin = distance / 2; }
  void prepare(const Topology& topology) override { topology_ = &topology; }

  const Candidates& step(std::span<const double> x0, std::span<const double> x1) override {
    boxes_.update(x0, x1);
    fill();
    candidates_.clear();
    const auto edges = topology_->edges();
    CGAL::box_self_intersection_d(edge_boxes_.begin(), edge_boxes_.end(),
                                  [&](const CgalBox& a, const CgalBox& b) {
                                    const auto [i, j] = ordered(a.info(), b.info());
                                    if (!incident(edges[i], edges[j]))
                                      candidates_.edge_edge.push_back({i, j});
                                  });
    const auto triangles = topology_->triangles();
    CGAL::box_intersection_d(vertex_boxes_.begin(), vertex_boxes_.end(), face_boxes_.begin(),
                             face_boxes_.end(), [&](const CgalBox& v, const CgalBox& f) {
                               if (!incident(v.info(), triangles[f.info()]))
                                 candidates_.vertex_face.push_back({v.info(), f.info()});
                             });
    return candidates_;
  }

 private:
  /// Anew each step: CGAL's algorithm reorders the boxes that it is given.
  void fill() {
    edge_boxes_.clear();
    vertex_boxes_.clear();
    face_boxes_.clear();
    const auto edges = topology_->edges();
    for (Index e = 0; e < edges.size(); ++e) edge_boxes_.push_back(cgal_box(boxes_.edge(edges[e]), e));
    for (Index v = 0; v < topology_->vertex_count(); ++v)
      vertex_boxes_.push_back(cgal_box(boxes_.vertex(v), v));
    const auto triangles = topology_->triangles();
    for (Index f = 0; f < triangles.size(); ++f)
      face_boxes_.push_back(cgal_box(boxes_.face(triangles[f]), f));
  }

  const Topology* topology_ = nullptr;
  SweptBoxes boxes_;
  std::vector<CgalBox> edge_boxes_, vertex_boxes_, face_boxes_;
  Candidates candidates_;
};

const RegisterPeer kCgal{
    {"CGAL", "CGAL box_intersection_d", CGAL_VERSION_STR, [] { return std::make_unique<CgalPeer>(); }}};

}  // namespace
}  // namespace foldproof::bench
