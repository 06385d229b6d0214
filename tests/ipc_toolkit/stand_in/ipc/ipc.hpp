#pragma once

#include "ipc/broad_phase/broad_phase.hpp"
#include "ipc/ccd/narrow_phase_ccd.hpp"

namespace ipc {

class CollisionMesh {
 public:
  CollisionMesh(const Eigen::MatrixXd& rest_positions, const Eigen::MatrixXi& edges,
                const Eigen::MatrixXi& faces);
  const Eigen::MatrixXi& edges() const { return edges_; }
  const Eigen::MatrixXi& faces() const { return faces_; }
  /// Rows of edges() that are in no face.
  const std::vector<int>& codim_edges() const { return codim_edges_; }
  /// Vertices in no edge and no face.
  const std::vector<int>& codim_vertices() const { return codim_vertices_; }

  CollisionFilter can_collide = [](std::size_t, std::size_t) { return true; };

 private:
  Eigen::MatrixXi edges_, faces_;
  std::vector<int> codim_edges_, codim_vertices_;
};

/// The real ones take a number for one of ipc-toolkit's own broad phases in 1.3, a std::shared_ptr in 1.4.
bool is_step_collision_free(const CollisionMesh& mesh, Eigen::ConstRef<Eigen::MatrixXd> vertices_t0,
                            Eigen::ConstRef<Eigen::MatrixXd> vertices_t1, double min_distance,
                            BroadPhase* broad_phase, const NarrowPhaseCCD& narrow_phase_ccd);
double compute_collision_free_stepsize(const CollisionMesh& mesh,
                                       Eigen::ConstRef<Eigen::MatrixXd> vertices_t0,
                                       Eigen::ConstRef<Eigen::MatrixXd> vertices_t1, double min_distance,
                                       BroadPhase* broad_phase, const NarrowPhaseCCD& narrow_phase_ccd);

}  // namespace ipc
