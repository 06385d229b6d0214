/// Foldproof in simulators that use ipc-toolkit: a broad phase and a narrow phase behind its interfaces.
///
/// Needs ipc-toolkit 1.3 or newer, which is not part of Foldproof. docs/ipc_toolkit.md says what to change in
/// a simulator, and for which releases this is written. Errors are exceptions here, as in ipc-toolkit:
/// std::invalid_argument for bad input, std::logic_error for what is not supported. They say what to do.
#pragma once

#include <algorithm>
#include <ipc/broad_phase/broad_phase.hpp>
#include <optional>
#include <stdexcept>
#include <tuple>

#include "foldproof/ipc_narrow_phase.h"
#include "foldproof/solver.h"

namespace foldproof::ipc_toolkit {

namespace detail {

/// Of the build function that takes one pose.
template <class Vertices, class Elements>
std::tuple<Vertices, Elements> build_parameters(void (::ipc::BroadPhase::*build)(Vertices, Elements, Elements,
                                                                                 double));
using Build = decltype(build_parameters(&::ipc::BroadPhase::build));

/// The function overrides one only since 1.4, so it is not marked so.
class NamedBroadPhase : public ::ipc::BroadPhase {
 public:
  virtual std::string name() const { return "Foldproof"; }  // NOLINT(modernize-use-override)
};

}  // namespace detail

/// Finds every pair of features whose distance is at most twice the radius of inflation at some time of the
/// step, or in the pose, if ipc-toolkit's filters allow it, and few others; of edges and faces only those
/// that cross. Edge-edge and face-vertex candidates of a step are what StepChecker::check finds, edge-face
/// candidates of a pose come from StepChecker::check_static. So what certificates prove costs nothing.
/// Filters are asked when candidates are listed. 3D only. Keep it: from build to build it reuses certificates
/// and lists while edges and faces stay the same. One thread at a time.
class BroadPhase : public detail::NamedBroadPhase {
 public:
  using Vertices = std::tuple_element_t<0, detail::Build>;
  using Elements = std::tuple_element_t<1, detail::Build>;
  using ::ipc::BroadPhase::build;

  /// One pose. Here as below, no box is made: ipc-toolkit's own function is not called.
  void build(Vertices vertices, Elements edges, Elements faces, double inflation_radius = 0) override {
    require_3d(vertices);
    keep(vertices.rows(), edges, faces, inflation_radius);
    x0_ = positions_of(vertices);
    x1_.clear();
  }
  /// A step.
  void build(Vertices vertices_t0, Vertices vertices_t1, Elements edges, Elements faces,
             double inflation_radius = 0) override {
    require_3d(vertices_t0);
    require_3d(vertices_t1);
    keep(vertices_t0.rows(), edges, faces, inflation_radius);
    x0_ = positions_of(vertices_t0);
    x1_ = positions_of(vertices_t1);
  }
  void clear() override {
    ::ipc::BroadPhase::clear();
    inflation_.reset();
  }

  void detect_vertex_vertex_candidates(
      detail::Parameter<&::ipc::BroadPhase::detect_vertex_vertex_candidates> candidates) const override {
    require_positions();
    if (x0_.empty()) return;
    vertices_.find({.vertex_count = mesh_.vertex_count}, x0_, x1_, *inflation_);
    for (const auto& [a, b] : vertices_.found.vertex_vertex) {
      if (can_vertices_collide(a, b)) candidates.emplace_back(int(a), int(b));
    }
  }
  /// Of all edges with all vertices, which are points of their own here.
  void detect_edge_vertex_candidates(
      detail::Parameter<&::ipc::BroadPhase::detect_edge_vertex_candidates> candidates) const override {
    require_positions();
    if (mesh_.edges.empty()) return;
    const Index n = mesh_.vertex_count;
    edges_and_points_.find({.edges = mesh_.edges, .vertex_count = 2 * n, .others = n}, twice(x0_), twice(x1_),
                           *inflation_);
    for (const auto& [edge, point] : edges_and_points_.found.edge_vertex) {
      if (can_edge_vertex_collide(edge, point - n)) candidates.emplace_back(int(edge), int(point - n));
    }
  }
  void detect_edge_edge_candidates(
      detail::Parameter<&::ipc::BroadPhase::detect_edge_edge_candidates> candidates) const override {
    for (const auto& [a, b] : near().edge_edge) {
      // Edges of faces that ipc-toolkit was not given come behind its own.
      if (b < mesh_.edges.size() && can_edges_collide(a, b)) candidates.emplace_back(int(a), int(b));
    }
  }
  void detect_face_vertex_candidates(
      detail::Parameter<&::ipc::BroadPhase::detect_face_vertex_candidates> candidates) const override {
    for (const auto& [vertex, face] : near().vertex_face) {
      if (can_face_vertex_collide(face, vertex)) candidates.emplace_back(int(face), int(vertex));
    }
  }
  /// Those that cross in one pose, decided exactly: what ipc::has_intersections asks for.
  void detect_edge_face_candidates(
      detail::Parameter<&::ipc::BroadPhase::detect_edge_face_candidates> candidates) const override {
    require_positions();
    if (!x1_.empty())
      throw std::logic_error("foldproof: edge-face candidates are those of one pose; build with one pose");
    if (mesh_.edges.empty() || mesh_.faces.empty()) return;
    for (const auto& [edge, face] : steps_.crossings(mesh_, x0_)) {
      if (can_edge_face_collide(edge, face)) candidates.emplace_back(edge, face);
    }
  }
  void detect_face_face_candidates(
      detail::Parameter<&::ipc::BroadPhase::detect_face_face_candidates>) const override {
    throw std::logic_error("foldproof: no face-face candidates; ask another broad phase, as ipc::BruteForce");
  }

 protected:
  // As in ipc-toolkit, which asks its boxes for the vertices.
  bool can_edge_vertex_collide(std::size_t edge, std::size_t vertex) const override {
    return can_collide(mesh_.edges[edge], std::array{static_cast<Index>(vertex)});
  }
  bool can_edges_collide(std::size_t a, std::size_t b) const override {
    return can_collide(mesh_.edges[a], mesh_.edges[b]);
  }
  bool can_face_vertex_collide(std::size_t face, std::size_t vertex) const override {
    return can_collide(mesh_.faces[face], std::array{static_cast<Index>(vertex)});
  }
  bool can_edge_face_collide(std::size_t edge, std::size_t face) const override {
    return can_collide(mesh_.edges[edge], mesh_.faces[face]);
  }

 private:
  /// Whether some of their vertices may, and they have none in common.
  bool can_collide(std::span<const Index> a, std::span<const Index> b) const {
    bool any = false;
    for (const Index i : a) {
      for (const Index j : b) {
        if (i == j) return false;
        any = any || can_vertices_collide(i, j);
      }
    }
    return any;
  }

  struct Mesh {
    std::vector<Edge> edges = {};
    std::vector<Triangle> faces = {};
    Index vertex_count = 0;
    Index others = 0;  ///< If not 0: vertices from here on collide with those before, and nothing else does.
    bool operator==(const Mesh&) const = default;
  };
  /// A checker for one kind of candidates, kept while its mesh stays the same.
  struct Query {
    Mesh mesh;
    std::optional<ContactChecker> checker;
    Candidates found;

    /// `x1` is empty for one pose.
    void find(const Mesh& wanted, std::span<const double> x0, std::span<const double> x1, double inflation) {
      if (!checker || mesh != wanted) start(wanted, x0);
      detail::value_of(x1.empty() ? checker->candidates(x0, inflation, found)
                                  : checker->candidates(x0, x1, inflation, found));
    }
    void start(const Mesh& wanted, std::span<const double> x0) {
      CollisionMeshSettings settings;
      if (wanted.others != 0) {
        std::vector<Index> group(wanted.vertex_count, 0);
        std::fill(group.begin() + wanted.others, group.end(), 1);
        const std::array<std::array<Index, 2>, 2> excluded{{{0, 0}, {1, 1}}};
        settings.filter = detail::value_of(CollisionFilter::groups(std::move(group), excluded));
      }
      checker.emplace(std::make_shared<const CollisionMesh>(
          detail::value_of(CollisionMesh::make(x0, wanted.edges, wanted.faces, settings))));
      mesh = wanted;
    }
  };

  /// A checker of all elements, kept while they stay the same.
  struct Steps {
    Mesh mesh;
    std::shared_ptr<const Hierarchy> hierarchy;
    std::vector<std::pair<Edge, Index>> rows;  ///< Of edges, the smaller vertex first, ascending.
    std::optional<StepChecker> checker;
    StepResult step;
    StaticResult pose;

    /// What comes within `distance`: vertices and faces, and edges.
    void find(const Mesh& wanted, std::span<const double> x0, std::span<const double> x1, double distance,
              Candidates& out) {
      prepare(wanted, x0);
      detail::value_of(
          checker->check(x0, x1, {.thickness = distance, .max_listed = ~std::uint64_t{0}}, step));
      for (const VertexFaceCollision& hit : step.vertex_face) {
        if (hit.face < mesh.faces.size())  // behind them are edges and points without a face
          out.vertex_face.push_back({hit.vertex, hit.face});
      }
      for (const EdgeEdgeCollision& hit : step.edge_edge) {
        const auto a = row_of(hit.a), b = row_of(hit.b);
        if (a && b) out.edge_edge.push_back({*a, *b});
      }
    }
    /// The edges and faces that cross, and some that are beside a crossing, ascending.
    std::vector<std::pair<int, int>> crossings(const Mesh& wanted, std::span<const double> x) {
      prepare(wanted, x);
      detail::value_of(checker->check_static(x, {.max_listed = ~std::uint64_t{0}}, pose));
      std::vector<std::pair<int, int>> found;
      const auto add = [&](Index element, Index face) {
        if (face >= mesh.faces.size()) return;
        const Triangle& corners = hierarchy->topology().triangles()[element];
        for (int k = 0; k < 3; ++k) {
          if (const auto row = row_of({corners[k], corners[(k + 1) % 3]})) found.emplace_back(*row, face);
        }
      };
      for (const TriangleCrossing& crossing : pose.crossings) {
        add(crossing.triangle_a, crossing.triangle_b);
        add(crossing.triangle_b, crossing.triangle_a);
      }
      std::sort(found.begin(), found.end());
      found.erase(std::unique(found.begin(), found.end()), found.end());
      return found;
    }

   private:
    void prepare(const Mesh& wanted, std::span<const double> x0) {
      if (checker && mesh == wanted) return;
      hierarchy = detail::value_of(CollisionMesh::make(x0, wanted.edges, wanted.faces)).hierarchy();
      rows.clear();
      for (Index k = 0; k < wanted.edges.size(); ++k) rows.emplace_back(ascending(wanted.edges[k]), k);
      std::sort(rows.begin(), rows.end());
      checker.emplace(std::vector<Object>{hierarchy});
      mesh = wanted;
    }
    static Edge ascending(const Edge& edge) {
      return {std::min(edge[0], edge[1]), std::max(edge[0], edge[1])};
    }
    /// None: the simulator did not give it.
    std::optional<Index> row_of(const Edge& edge) const {
      const auto row = std::lower_bound(rows.begin(), rows.end(), std::pair(ascending(edge), Index{0}));
      if (row == rows.end() || row->first != ascending(edge)) return std::nullopt;
      return row->second;
    }
  };

  static std::vector<double> twice(std::vector<double> x) {
    x.reserve(2 * x.size());
    x.insert(x.end(), x.begin(), x.end());
    return x;
  }
  static void require_3d(Vertices vertices) {
    if (vertices.cols() != 3)
      throw std::invalid_argument("foldproof: positions have " + std::to_string(vertices.cols()) +
                                  " columns, not 3; keep a broad phase of ipc-toolkit for 2D");
  }
  void require_positions() const {
    if (!inflation_)
      throw std::logic_error("foldproof: no positions were given; call build with vertices, not boxes");
  }
  template <class Kept>
  static void set_dimension(Kept& kept) {
    if constexpr (requires { kept.dim; })
      kept.dim = 3;  // as since 1.5 detect_collision_candidates wants to know
  }
  void keep(Eigen::Index vertex_count, Elements edges, Elements faces, double inflation_radius) {
    clear();
    set_dimension(*this);
    mesh_ = {.edges = ids_of<2>(edges),
             .faces = ids_of<3>(faces),
             .vertex_count = static_cast<Index>(vertex_count)};
    inflation_ = 2 * inflation_radius;
    near_is_found_ = false;
  }
  const Candidates& near() const {
    require_positions();
    if (near_is_found_) return near_.found;
    near_.found.clear();
    if (mesh_.edges.empty() && mesh_.faces.empty()) {  // nothing collides
    } else if (x1_.empty()) {
      near_.find(mesh_, x0_, {}, *inflation_);
    } else {
      steps_.find(mesh_, x0_, x1_, *inflation_, near_.found);
    }
    near_is_found_ = true;
    return near_.found;
  }

  std::vector<double> x0_, x1_;  ///< x1_ is empty for one pose.
  Mesh mesh_;
  std::optional<double> inflation_;  ///< None: nothing is built.
  mutable Query near_, vertices_, edges_and_points_;
  mutable Steps steps_;
  mutable bool near_is_found_ = false;
};

}  // namespace foldproof::ipc_toolkit
