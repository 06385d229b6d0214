#pragma once

#include "ipc/eigen.hpp"

namespace ipc {

struct VertexVertexCandidate {
  VertexVertexCandidate(index_t a, index_t b) : vertex0_id(a), vertex1_id(b) {}
  index_t vertex0_id, vertex1_id;
};
struct EdgeVertexCandidate {
  EdgeVertexCandidate(index_t edge, index_t vertex) : edge_id(edge), vertex_id(vertex) {}
  index_t edge_id, vertex_id;
};
struct EdgeEdgeCandidate {
  EdgeEdgeCandidate(index_t a, index_t b) : edge0_id(a), edge1_id(b) {}
  index_t edge0_id, edge1_id;
};
struct FaceVertexCandidate {
  FaceVertexCandidate(index_t face, index_t vertex) : face_id(face), vertex_id(vertex) {}
  index_t face_id, vertex_id;
};
struct EdgeFaceCandidate {
  EdgeFaceCandidate(index_t edge, index_t face) : edge_id(edge), face_id(face) {}
  index_t edge_id, face_id;
};
struct FaceFaceCandidate {
  FaceFaceCandidate(index_t a, index_t b) : face0_id(a), face1_id(b) {}
  index_t face0_id, face1_id;
};

class BroadPhase;
class CollisionMesh;
class NarrowPhaseCCD;

/// Asks a broad phase as ipc-toolkit does: for edges and faces, then for points among themselves, then for
/// points and edges without a face.
class Candidates {
 public:
  void build(const CollisionMesh& mesh, Eigen::ConstRef<Eigen::MatrixXd> vertices, double inflation_radius,
             BroadPhase* broad_phase);
  void build(const CollisionMesh& mesh, Eigen::ConstRef<Eigen::MatrixXd> vertices_t0,
             Eigen::ConstRef<Eigen::MatrixXd> vertices_t1, double inflation_radius, BroadPhase* broad_phase);
  bool is_step_collision_free(const CollisionMesh& mesh, Eigen::ConstRef<Eigen::MatrixXd> vertices_t0,
                              Eigen::ConstRef<Eigen::MatrixXd> vertices_t1, double min_distance,
                              const NarrowPhaseCCD& narrow_phase_ccd) const;
  double compute_collision_free_stepsize(const CollisionMesh& mesh,
                                         Eigen::ConstRef<Eigen::MatrixXd> vertices_t0,
                                         Eigen::ConstRef<Eigen::MatrixXd> vertices_t1, double min_distance,
                                         const NarrowPhaseCCD& narrow_phase_ccd) const;
  std::size_t size() const {
    return vv_candidates.size() + ev_candidates.size() + ee_candidates.size() + fv_candidates.size();
  }

  std::vector<VertexVertexCandidate> vv_candidates;
  std::vector<EdgeVertexCandidate> ev_candidates;
  std::vector<EdgeEdgeCandidate> ee_candidates;
  std::vector<FaceVertexCandidate> fv_candidates;

 private:
  template <class Ask>
  void for_each(const CollisionMesh& mesh, const Eigen::MatrixXd& x0, const Eigen::MatrixXd& x1,
                const NarrowPhaseCCD& ccd, Ask ask) const;
};

}  // namespace ipc
