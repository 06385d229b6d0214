// What of ipc-toolkit asks and filters: written for these tests.

#include <algorithm>
#include <limits>
#include <set>
#include <stdexcept>

#include "ipc/ipc.hpp"

namespace ipc {
namespace {

using Ids = std::vector<std::size_t>;

std::vector<Ids> rows_of(Eigen::ConstRef<Eigen::MatrixXi> matrix) {
  std::vector<Ids> rows(matrix.rows());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    for (int k = 0; k < matrix.cols(); ++k) rows[i].push_back(matrix(i, k));
  }
  return rows;
}

Eigen::MatrixXd rows_of(Eigen::ConstRef<Eigen::MatrixXd> vertices, const std::vector<int>& ids) {
  Eigen::MatrixXd rows(ids.size(), vertices.cols());
  for (std::size_t i = 0; i < ids.size(); ++i) rows.row(i) = vertices.row(ids[i]);
  return rows;
}

using Pose = const Eigen::MatrixXd*;  // null: there is no second one

void build_broad_phase(BroadPhase& broad_phase, const Eigen::MatrixXd& t0, Pose t1,
                       const Eigen::MatrixXi& edges, const Eigen::MatrixXi& faces, double radius) {
  if (t1)
    broad_phase.build(t0, *t1, edges, faces, radius);
  else
    broad_phase.build(t0, edges, faces, radius);
}

void find_codim_points(Candidates& candidates, const CollisionMesh& mesh, const Eigen::MatrixXd& t0, Pose t1,
                       double radius, BroadPhase& broad_phase) {
  const auto& points = mesh.codim_vertices();
  if (points.empty()) return;
  broad_phase.clear();
  const Eigen::MatrixXd p0 = rows_of(t0, points), p1 = t1 ? rows_of(*t1, points) : p0;
  build_broad_phase(broad_phase, p0, t1 ? &p1 : nullptr, {}, {}, radius);
  broad_phase.detect_vertex_vertex_candidates(candidates.vv_candidates);
  for (auto& pair : candidates.vv_candidates) pair = {points[pair.vertex0_id], points[pair.vertex1_id]};
}

void find_codim_edges(Candidates& candidates, const CollisionMesh& mesh, const Eigen::MatrixXd& t0, Pose t1,
                      double radius, BroadPhase& broad_phase) {
  const auto& points = mesh.codim_vertices();
  if (points.empty() || mesh.codim_edges().empty()) return;
  std::vector<int> vertices = points;
  Eigen::MatrixXi edges(mesh.codim_edges().size(), 2);
  for (int i = 0; i < edges.rows(); ++i) {
    for (int k = 0; k < 2; ++k) {
      const int vertex = mesh.edges()(mesh.codim_edges()[i], k);
      auto at = std::find(vertices.begin() + points.size(), vertices.end(), vertex);
      edges(i, k) = static_cast<int>(at - vertices.begin());
      if (at == vertices.end()) vertices.push_back(vertex);
    }
  }
  const std::size_t n = points.size();
  broad_phase.clear();
  broad_phase.can_vertices_collide = [&](std::size_t i, std::size_t j) {
    return (i < n) != (j < n) && mesh.can_collide(vertices[i], vertices[j]);
  };
  const Eigen::MatrixXd p0 = rows_of(t0, vertices), p1 = t1 ? rows_of(*t1, vertices) : p0;
  build_broad_phase(broad_phase, p0, t1 ? &p1 : nullptr, edges, {}, radius);
  broad_phase.detect_edge_vertex_candidates(candidates.ev_candidates);
  for (auto& pair : candidates.ev_candidates)
    pair = {mesh.codim_edges()[pair.edge_id], points[pair.vertex_id]};
}

void find_all(Candidates& candidates, const CollisionMesh& mesh, const Eigen::MatrixXd& t0, Pose t1,
              double radius, BroadPhase& broad_phase) {
  candidates = {};
  broad_phase.can_vertices_collide = mesh.can_collide;
  build_broad_phase(broad_phase, t0, t1, mesh.edges(), mesh.faces(), radius);
#if IPC_STAND_IN >= 15
  broad_phase.detect_collision_candidates(candidates);
#else
  broad_phase.detect_collision_candidates(static_cast<int>(t0.cols()), candidates);
#endif
  find_codim_points(candidates, mesh, t0, t1, radius, broad_phase);
  find_codim_edges(candidates, mesh, t0, t1, radius, broad_phase);
}

}  // namespace

CollisionMesh::CollisionMesh(const Eigen::MatrixXd& rest_positions, const Eigen::MatrixXi& edges,
                             const Eigen::MatrixXi& faces)
    : edges_(edges), faces_(faces) {
  std::set<std::set<int>> of_faces;
  std::set<int> with_edge;
  for (int f = 0; f < faces.rows(); ++f) {
    for (int k = 0; k < 3; ++k) {
      of_faces.insert({faces(f, k), faces(f, (k + 1) % 3)});
      with_edge.insert(faces(f, k));
    }
  }
  for (int e = 0; e < edges.rows(); ++e) {
    with_edge.insert({edges(e, 0), edges(e, 1)});
    if (!of_faces.contains({edges(e, 0), edges(e, 1)})) codim_edges_.push_back(e);
  }
  for (int v = 0; v < rest_positions.rows(); ++v)
    if (!with_edge.contains(v)) codim_vertices_.push_back(v);
}

void BroadPhase::build([[maybe_unused]] Eigen::ConstRef<Eigen::MatrixXd> vertices,
                       Eigen::ConstRef<Eigen::MatrixXi> edges, Eigen::ConstRef<Eigen::MatrixXi> faces,
                       double) {
  clear();
#if IPC_STAND_IN >= 15
  dim = static_cast<std::uint8_t>(vertices.cols());
#endif
  edges_ = rows_of(edges);
  faces_ = rows_of(faces);
}
void BroadPhase::build(Eigen::ConstRef<Eigen::MatrixXd> vertices_t0, Eigen::ConstRef<Eigen::MatrixXd>,
                       Eigen::ConstRef<Eigen::MatrixXi> edges, Eigen::ConstRef<Eigen::MatrixXi> faces,
                       double inflation_radius) {
  BroadPhase::build(vertices_t0, edges, faces, inflation_radius);
}
#if IPC_STAND_IN >= 15
void BroadPhase::build(const AABBs&, Eigen::ConstRef<Eigen::MatrixXi> edges,
                       Eigen::ConstRef<Eigen::MatrixXi> faces, std::uint8_t dimension) {
  clear();
  dim = dimension;
  build(edges, faces);
}
void BroadPhase::build(Eigen::ConstRef<Eigen::MatrixXi> edges, Eigen::ConstRef<Eigen::MatrixXi> faces) {
  edges_ = rows_of(edges);
  faces_ = rows_of(faces);
}
#endif
void BroadPhase::clear() {
  edges_.clear();
  faces_.clear();
}

namespace {
void detect_in(int dim, const BroadPhase& broad_phase, Candidates& candidates) {
  if (dim != 3) throw std::logic_error("the stand-in is for 3D");
  broad_phase.detect_edge_edge_candidates(candidates.ee_candidates);
  broad_phase.detect_face_vertex_candidates(candidates.fv_candidates);
}
}  // namespace
#if IPC_STAND_IN >= 15
void BroadPhase::detect_collision_candidates(Candidates& candidates) const {
  detect_in(dim, *this, candidates);
}
#else
void BroadPhase::detect_collision_candidates(int dim, Candidates& candidates) const {
  detect_in(dim, *this, candidates);
}
#endif

bool BroadPhase::can_collide(const Ids& a, const Ids& b) const {
  bool any = false;
  for (const std::size_t i : a) {
    for (const std::size_t j : b) {
      if (i == j) return false;
      any = any || can_vertices_collide(i, j);
    }
  }
  return any;
}
bool BroadPhase::can_edge_vertex_collide(std::size_t edge, std::size_t vertex) const {
  return can_collide(edges_[edge], {vertex});
}
bool BroadPhase::can_edges_collide(std::size_t edge_a, std::size_t edge_b) const {
  return can_collide(edges_[edge_a], edges_[edge_b]);
}
bool BroadPhase::can_face_vertex_collide(std::size_t face, std::size_t vertex) const {
  return can_collide(faces_[face], {vertex});
}
bool BroadPhase::can_edge_face_collide(std::size_t edge, std::size_t face) const {
  return can_collide(edges_[edge], faces_[face]);
}
bool BroadPhase::can_faces_collide(std::size_t face_a, std::size_t face_b) const {
  return can_collide(faces_[face_a], faces_[face_b]);
}

void Candidates::build(const CollisionMesh& mesh, Eigen::ConstRef<Eigen::MatrixXd> vertices,
                       double inflation_radius, BroadPhase* broad_phase) {
  find_all(*this, mesh, vertices, nullptr, inflation_radius, *broad_phase);
}
void Candidates::build(const CollisionMesh& mesh, Eigen::ConstRef<Eigen::MatrixXd> vertices_t0,
                       Eigen::ConstRef<Eigen::MatrixXd> vertices_t1, double inflation_radius,
                       BroadPhase* broad_phase) {
  const Eigen::MatrixXd t1 = vertices_t1;
  find_all(*this, mesh, vertices_t0, &t1, inflation_radius, *broad_phase);
}

template <class Ask>
void Candidates::for_each(const CollisionMesh& mesh, const Eigen::MatrixXd& x0, const Eigen::MatrixXd& x1,
                          const NarrowPhaseCCD& ccd, Ask ask) const {
  const auto at0 = [&](index_t vertex) { return Eigen::Vector3d(x0.row(vertex)); };
  const auto at1 = [&](index_t vertex) { return Eigen::Vector3d(x1.row(vertex)); };
  const auto& edges = mesh.edges();
  const auto& faces = mesh.faces();
  for (const auto& [a, b] : vv_candidates) {
    ask([&, a = a, b = b](double& toi, double min_distance, double tmax) {
      return ccd.point_point_ccd(at0(a), at0(b), at1(a), at1(b), toi, min_distance, tmax);
    });
  }
  for (const auto& [edge, v] : ev_candidates) {
    const int a = edges(edge, 0), b = edges(edge, 1);
    ask([&, v = v](double& toi, double min_distance, double tmax) {
      return ccd.point_edge_ccd(at0(v), at0(a), at0(b), at1(v), at1(a), at1(b), toi, min_distance, tmax);
    });
  }
  for (const auto& [first, second] : ee_candidates) {
    const int a = edges(first, 0), b = edges(first, 1), c = edges(second, 0), d = edges(second, 1);
    ask([&](double& toi, double min_distance, double tmax) {
      return ccd.edge_edge_ccd(at0(a), at0(b), at0(c), at0(d), at1(a), at1(b), at1(c), at1(d), toi,
                               min_distance, tmax);
    });
  }
  for (const auto& [face, v] : fv_candidates) {
    const int a = faces(face, 0), b = faces(face, 1), c = faces(face, 2);
    ask([&, v = v](double& toi, double min_distance, double tmax) {
      return ccd.point_triangle_ccd(at0(v), at0(a), at0(b), at0(c), at1(v), at1(a), at1(b), at1(c), toi,
                                    min_distance, tmax);
    });
  }
}

bool Candidates::is_step_collision_free(const CollisionMesh& mesh,
                                        Eigen::ConstRef<Eigen::MatrixXd> vertices_t0,
                                        Eigen::ConstRef<Eigen::MatrixXd> vertices_t1, double min_distance,
                                        const NarrowPhaseCCD& narrow_phase_ccd) const {
  bool free = true;
  for_each(mesh, vertices_t0, vertices_t1, narrow_phase_ccd, [&](auto collides) {
    double toi = 1;
    if (collides(toi, min_distance, 1)) free = false;
  });
  return free;
}

double Candidates::compute_collision_free_stepsize(const CollisionMesh& mesh,
                                                   Eigen::ConstRef<Eigen::MatrixXd> vertices_t0,
                                                   Eigen::ConstRef<Eigen::MatrixXd> vertices_t1,
                                                   double min_distance,
                                                   const NarrowPhaseCCD& narrow_phase_ccd) const {
  double earliest = 1;
  for_each(mesh, vertices_t0, vertices_t1, narrow_phase_ccd, [&](auto collides) {
    double toi = std::numeric_limits<double>::infinity();
    if (collides(toi, min_distance, earliest)) earliest = std::min(earliest, toi);
  });
  return earliest;
}

bool is_step_collision_free(const CollisionMesh& mesh, Eigen::ConstRef<Eigen::MatrixXd> vertices_t0,
                            Eigen::ConstRef<Eigen::MatrixXd> vertices_t1, double min_distance,
                            BroadPhase* broad_phase, const NarrowPhaseCCD& narrow_phase_ccd) {
  Candidates candidates;
  candidates.build(mesh, vertices_t0, vertices_t1, min_distance / 2, broad_phase);
  return candidates.is_step_collision_free(mesh, vertices_t0, vertices_t1, min_distance, narrow_phase_ccd);
}
double compute_collision_free_stepsize(const CollisionMesh& mesh,
                                       Eigen::ConstRef<Eigen::MatrixXd> vertices_t0,
                                       Eigen::ConstRef<Eigen::MatrixXd> vertices_t1, double min_distance,
                                       BroadPhase* broad_phase, const NarrowPhaseCCD& narrow_phase_ccd) {
  Candidates candidates;
  candidates.build(mesh, vertices_t0, vertices_t1, min_distance / 2, broad_phase);
  return candidates.compute_collision_free_stepsize(mesh, vertices_t0, vertices_t1, min_distance,
                                                    narrow_phase_ccd);
}

}  // namespace ipc
