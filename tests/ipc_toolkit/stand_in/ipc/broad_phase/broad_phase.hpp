#pragma once

#include "ipc/candidates/candidates.hpp"

namespace ipc {

/// The real one keeps boxes; the stand-in keeps what the filters need of them, the ids of vertices.
class BroadPhase {
 public:
  virtual ~BroadPhase() = default;
#if IPC_STAND_IN >= 14
  virtual std::string name() const = 0;
#endif

  virtual void build(Eigen::ConstRef<Eigen::MatrixXd> vertices, Eigen::ConstRef<Eigen::MatrixXi> edges,
                     Eigen::ConstRef<Eigen::MatrixXi> faces, double inflation_radius = 0);
  virtual void build(Eigen::ConstRef<Eigen::MatrixXd> vertices_t0,
                     Eigen::ConstRef<Eigen::MatrixXd> vertices_t1, Eigen::ConstRef<Eigen::MatrixXi> edges,
                     Eigen::ConstRef<Eigen::MatrixXi> faces, double inflation_radius = 0);
#if IPC_STAND_IN >= 15
  struct AABB {};
  using AABBs = std::vector<AABB>;
  virtual void build(const AABBs& vertex_boxes, Eigen::ConstRef<Eigen::MatrixXi> edges,
                     Eigen::ConstRef<Eigen::MatrixXi> faces, std::uint8_t dim);
#endif
  virtual void clear();

  virtual void detect_vertex_vertex_candidates(std::vector<VertexVertexCandidate>& candidates) const = 0;
  virtual void detect_edge_vertex_candidates(std::vector<EdgeVertexCandidate>& candidates) const = 0;
  virtual void detect_edge_edge_candidates(std::vector<EdgeEdgeCandidate>& candidates) const = 0;
  virtual void detect_face_vertex_candidates(std::vector<FaceVertexCandidate>& candidates) const = 0;
  virtual void detect_edge_face_candidates(std::vector<EdgeFaceCandidate>& candidates) const = 0;
  virtual void detect_face_face_candidates(std::vector<FaceFaceCandidate>& candidates) const = 0;

  /// Virtual up to 1.3. Since 1.5 it knows the dimension from the last build.
#if IPC_STAND_IN >= 15
  void detect_collision_candidates(Candidates& candidates) const;
#elif IPC_STAND_IN == 14
  void detect_collision_candidates(int dim, Candidates& candidates) const;
#else
  virtual void detect_collision_candidates(int dim, Candidates& candidates) const;
#endif

  CollisionFilter can_vertices_collide = [](std::size_t, std::size_t) { return true; };

 protected:
#if IPC_STAND_IN >= 15
  virtual void build(Eigen::ConstRef<Eigen::MatrixXi> edges, Eigen::ConstRef<Eigen::MatrixXi> faces);
  std::uint8_t dim = 0;
#endif
  virtual bool can_edge_vertex_collide(std::size_t edge, std::size_t vertex) const;
  virtual bool can_edges_collide(std::size_t edge_a, std::size_t edge_b) const;
  virtual bool can_face_vertex_collide(std::size_t face, std::size_t vertex) const;
  virtual bool can_edge_face_collide(std::size_t edge, std::size_t face) const;
  virtual bool can_faces_collide(std::size_t face_a, std::size_t face_b) const;

 private:
  bool can_collide(const std::vector<std::size_t>& a, const std::vector<std::size_t>& b) const;
  std::vector<std::vector<std::size_t>> edges_, faces_;
};

}  // namespace ipc
