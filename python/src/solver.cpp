// Queries of implicit solvers.
#include "foldproof/solver.h"

#include <mutex>

#include "filters.h"
#include "module.h"
#include "steps.h"
#include "unlocked.h"

namespace foldproof::python {
namespace {

CollisionFilter filter_of(const py::object& groups, const py::object& excluded) {
  if (groups.is_none()) {
    if (!excluded.is_none()) refuse("excluded", "is given without groups", "give a group for each vertex");
    return {};
  }
  auto of_vertex = ids_of(groups, "groups", "group", 1, "V numbers");
  if (excluded.is_none()) return take(CollisionFilter::patches(std::move(of_vertex)));
  const auto pairs = rows_of<2>(ids_of(excluded, "excluded", "group", 2, "K x 2 groups"));
  return take(CollisionFilter::groups(std::move(of_vertex), pairs));
}

template <std::size_t N>
std::vector<std::array<Index, N>> optional_rows(const py::object& x, const char* what, const char* layout) {
  if (x.is_none()) return {};
  return rows_of<N>(ids_of(x, what, "vertex", N, layout));
}

// NOLINTNEXTLINE(readability-function-size): one parameter for each of Python's
std::shared_ptr<CollisionMesh> make_mesh(const py::object& rest_positions, const py::object& edges,
                                         const py::object& faces, const py::object& groups,
                                         const py::object& excluded, bool points,
                                         const py::object& leaf_triangles) {
  const Numbers x = numbers_of(rest_positions, "rest_positions", {-1, 3}, "V x 3");
  CollisionMeshSettings settings;
  settings.filter = filter_of(groups, excluded);
  settings.points = points;
  settings.hierarchy.leaf_triangles = static_cast<Index>(whole_number(leaf_triangles, "leaf_triangles"));
  auto edge_rows = optional_rows<2>(edges, "edges", "E x 2 vertex ids");
  auto face_rows = optional_rows<3>(faces, "faces", "F x 3 vertex ids");
  const Unlocked unlocked;
  return std::make_shared<CollisionMesh>(
      take(CollisionMesh::make(span_of(x), std::move(edge_rows), std::move(face_rows), std::move(settings))));
}

/// A view of N ids per row, over memory that belongs to `owner`.
template <std::size_t N, class Row>
py::array rows_view(std::span<const Row> rows, const py::object& owner) {
  static_assert(sizeof(Row) == N * sizeof(Index));
  std::vector<py::ssize_t> shape{static_cast<py::ssize_t>(rows.size())};
  if (N > 1) shape.push_back(static_cast<py::ssize_t>(N));
  return view_of(reinterpret_cast<const Index*>(rows.data()), std::move(shape), owner);
}

template <class Pair>
py::array pairs_view(const std::vector<Pair>& pairs, const py::object& owner) {
  return rows_view<2>(std::span<const Pair>(pairs), owner);
}

/// A checker with a lock of its own, as it works without Python's.
struct Solver {
  std::shared_ptr<CollisionMesh> mesh;
  ContactChecker checker;
  std::mutex mutex;
  StepSize size{1, StepSize::Limit::None};  ///< The last one.

  Solver(std::shared_ptr<CollisionMesh> of, const ContactSettings& settings, const py::object& filter)
      : mesh(std::move(of)), checker(mesh, settings, filter_for(filter, {Object(mesh->hierarchy())})) {}

  Numbers positions(const py::object& x, const char* what) const {
    const py::ssize_t vertices = mesh->vertex_count();
    return numbers_of(x, what, {vertices, 3}, ("V x 3 with V = " + std::to_string(vertices)).c_str());
  }

  /// Calls the checker without Python's lock.
  template <class Query>
  auto ask(Query query) {
    const Unlocked unlocked;
    const std::lock_guard lock(mutex);
    return take(query(checker));
  }

  /// What is kept of the last call; waits for one of another thread.
  template <class Read>
  auto of_last_call(Read read) {
    const Unlocked unlocked;
    const std::lock_guard lock(mutex);
    return read();
  }
};

std::unique_ptr<Candidates> candidates_of(Solver& self, const py::object& x0, const py::object& x1,
                                          double inflation) {
  const Numbers from = self.positions(x0, "x0");
  const Numbers to = x1.is_none() ? from : self.positions(x1, "x1");
  auto found = std::make_unique<Candidates>();
  self.ask([&](ContactChecker& c) { return c.candidates(span_of(from), span_of(to), inflation, *found); });
  return found;
}

double step_size_of(Solver& self, const py::object& x0, const py::object& x1, double min_distance) {
  const Numbers from = self.positions(x0, "x0"), to = self.positions(x1, "x1");
  return self.ask([&](ContactChecker& c) {
    return c.collision_free_step_size(span_of(from), span_of(to), min_distance)
        .map([&](const StepSize& size) {
          self.size = size;
          return size.share;
        });
  });
}

py::array_t<double> step_sizes_of(Solver& self, const py::object& x0, const py::object& x1,
                                  double min_distance) {
  const Numbers from = self.positions(x0, "x0"), to = self.positions(x1, "x1");
  std::vector<double> shares;
  self.ask([&](ContactChecker& c) {
    return c.collision_free_step_sizes(span_of(from), span_of(to), shares, min_distance);
  });
  return py::array_t<double>(static_cast<py::ssize_t>(shares.size()), shares.data());
}

bool step_is_free(Solver& self, const py::object& x0, const py::object& x1, double min_distance) {
  const Numbers from = self.positions(x0, "x0"), to = self.positions(x1, "x1");
  return self.ask([&](ContactChecker& c) {
    return c.is_step_collision_free(span_of(from), span_of(to), min_distance).result();
  });
}

/// ClosePair as NumPy has it.
struct CloseRow {
  ClosePair::Kind kind;
  Index count;
  std::array<Index, 4> vertices;
  std::array<double, 4> weights;
  double distance;
  std::array<double, 3> normal;
  double mollifier_threshold;
};

CloseRow row_of(const ClosePair& p) {
  return {p.kind,
          p.count,
          p.vertices,
          p.weights,
          p.distance,
          {p.normal[0], p.normal[1], p.normal[2]},
          p.mollifier_threshold};
}

py::array close_pairs_of(Solver& self, const py::object& x, double distance, const py::object& active) {
  const Numbers pose = self.positions(x, "x");
  std::vector<std::uint8_t> flags;
  if (!active.is_none()) flags = flags_of(active, "active", self.mesh->vertex_count());
  std::vector<ClosePair> found;
  self.ask([&](ContactChecker& c) { return c.close_pairs(span_of(pose), distance, found, flags); });
  std::vector<CloseRow> rows;
  rows.reserve(found.size());
  for (const ClosePair& pair : found) rows.push_back(row_of(pair));
  return owned_rows(std::move(rows));
}

void bind_mesh(py::module_& module) {
  py::class_<CollisionMesh, std::shared_ptr<CollisionMesh>>(
      module, "CollisionMesh",
      "What may collide: faces, edges without a face, points without either. Immutable; any number of "
      "checkers may share it.")
      .def(
          py::init(&make_mesh), py::arg("rest_positions"), py::arg("edges") = py::none(),
          py::arg("faces") = py::none(), py::kw_only(), py::arg("groups") = py::none(),
          py::arg("excluded") = py::none(), py::arg("points") = true, py::arg("leaf_triangles") = 12,
          "rest_positions: V x 3, mesh units. edges: E x 2, faces: F x 3 vertex ids; edges of faces that are "
          "missing are appended.\n\n"
          "groups: V small numbers; vertices whose groups are a row of excluded (K x 2) do not collide; "
          "excluded None: no group collides with itself. Two features may collide when any vertex of one may "
          "collide with any of the other. points: vertices in no edge and no face collide. Error: wrong "
          "shapes, ids beyond V, an edge twice.")
      .def_property_readonly("vertex_count", &CollisionMesh::vertex_count, "V.")
      .def_property_readonly(
          "edges",
          [](const py::object& self) {
            return rows_view<2>(self.cast<const CollisionMesh&>().edges(), self);
          },
          "E x 2 vertex ids, uint32: the given edges, then the missing ones of faces; read-only.")
      .def_property_readonly(
          "faces",
          [](const py::object& self) {
            return rows_view<3>(self.cast<const CollisionMesh&>().faces(), self);
          },
          "F x 3 vertex ids, uint32, as given; read-only.")
      .def_property_readonly(
          "codim_edges",
          [](const py::object& self) {
            return rows_view<1>(self.cast<const CollisionMesh&>().codim_edges(), self);
          },
          "Rows of edges that are in no face, uint32.")
      .def_property_readonly(
          "codim_points",
          [](const py::object& self) {
            return rows_view<1>(self.cast<const CollisionMesh&>().codim_points(), self);
          },
          "Vertices in no edge and no face, uint32.");
}

void bind_candidates(py::module_& module) {
  py::class_<Candidates>(module, "Candidates",
                         "Pairs of features that may be close: arrays n x 2, uint32, no row twice.")
      .def("__len__", &Candidates::size)
      .def_property_readonly(
          "vertex_face",
          [](const py::object& self) { return pairs_view(self.cast<const Candidates&>().vertex_face, self); },
          "Vertex id, face id.")
      .def_property_readonly(
          "edge_edge",
          [](const py::object& self) { return pairs_view(self.cast<const Candidates&>().edge_edge, self); },
          "Two rows of CollisionMesh.edges.")
      .def_property_readonly(
          "edge_vertex",
          [](const py::object& self) { return pairs_view(self.cast<const Candidates&>().edge_vertex, self); },
          "A codimensional edge's row and a codimensional point.")
      .def_property_readonly(
          "vertex_vertex",
          [](const py::object& self) {
            return pairs_view(self.cast<const Candidates&>().vertex_vertex, self);
          },
          "Two codimensional points.");
}

void bind_last_call(py::class_<Solver>& checker) {
  checker
      .def_property_readonly(
          "mesh", [](const Solver& self) { return self.mesh; }, "The CollisionMesh that it answers about.")
      .def_property_readonly(
          "limit",
          [](Solver& self) {
            return kStepLimitNames[static_cast<std::size_t>(
                self.of_last_call([&] { return self.size.limit; }))];
          },
          "Why the last step size is not larger: 'none' (it is 1), 'contact' (a collision on the way), "
          "'start' (it is 0: in x0 a pair is too close already), or 'undecided' (the first pair in the way "
          "could not be decided, or no share could be proven free).")
      .def_property_readonly(
          "contact",
          [](Solver& self) -> py::object {
            const StepSize size = self.of_last_call([&] { return self.size; });
            if (size.limit == StepSize::Limit::None) return py::none();
            return py::make_tuple(size.contact_time,
                                  owned_rows(std::vector{row_of(size.contact)})[py::int_(0)]);
          },
          "The collision that limited the last step size: its time in [0, 1], and its closest features at "
          "that "
          "time as a row of close_pairs(). None where limit is 'none'.")
      .def_property_readonly(
          "work",
          [](Solver& self) { return work_of(self.of_last_call([&] { return self.checker.work(); })); },
          "The work of the last call, in numbers.")
      .def_property_readonly(
          "milliseconds",
          [](Solver& self) {
            return milliseconds_of(self.of_last_call([&] { return self.checker.milliseconds(); }));
          },
          "Wall time of the last call: total, update, traverse, narrow.");
}

void bind_queries(py::class_<Solver>& checker) {
  checker
      .def(
          "collision_free_step_size", &step_size_of, py::arg("x0"), py::arg("x1"),
          py::arg("min_distance") = 0.0,
          "A share of the step in [0, 1] that is proven free: step_towards(x0, x1, share) keeps farther than "
          "min_distance on the way.\n\n"
          "x0, x1: V x 3, mesh units. limit says why the share is not larger. Error: wrong shapes, numbers "
          "that are not finite.")
      .def(
          "collision_free_step_sizes", &step_sizes_of, py::arg("x0"), py::arg("x1"),
          py::arg("min_distance") = 0.0,
          "A share of the step for each vertex (V,), so that one contact does not stop a scene: 1, but for "
          "islands of vertices that collide on the way; each goes one share.\n\n"
          "step_towards(x0, x1, shares) is proven free but for pairs that are too close in x0, whose islands "
          "have the share 0. Error: as collision_free_step_size.")
      .def("is_step_collision_free", &step_is_free, py::arg("x0"), py::arg("x1"),
           py::arg("min_distance") = 0.0,
           "True: proven that no pair comes as close as min_distance while vertices move straight from x0 to "
           "x1.\n\nx0, x1: V x 3, mesh units. Error: as collision_free_step_size.")
      .def("candidates", &candidates_of, py::arg("x0"), py::arg("x1") = py::none(), py::kw_only(),
           py::arg("inflation"),
           "Every pair whose distance is <= inflation in the pose x0, or at some time of the step from x0 to "
           "x1, and other close pairs.\n\nx0, x1: V x 3, mesh units. Error: as collision_free_step_size.")
      .def("close_pairs", &close_pairs_of, py::arg("x"), py::arg("distance"), py::arg("active") = py::none(),
           "Every pair whose distance is <= distance in the pose x, each once by its closest features: a "
           "structured array with kind (names in foldproof.CLOSE_PAIR_KINDS), count (of pairs with these "
           "closest "
           "features), vertices (4; the last one repeated where they are fewer), weights (4), distance, "
           "normal "
           "(from the second feature to the first) and mollifier_threshold (0 unless edges are nearly "
           "parallel). "
           "weights[k] * normal is the gradient of the distance at vertices[k].\n\n"
           "x: V x 3, mesh units. distance: may be infinite. active: V booleans; pairs without an active "
           "vertex "
           "are left out. Error: as collision_free_step_size.")
      .def(
          "has_intersections",
          [](Solver& self, const py::object& x) {
            const Numbers pose = self.positions(x, "x");
            return self.ask([&](ContactChecker& c) { return c.has_intersections(span_of(pose)).result(); });
          },
          py::arg("x"),
          "Whether two faces, codimensional edges or points have a point in common, decided exactly.\n\n"
          "x: V x 3, mesh units. Error: as collision_free_step_size.")
      .def(
          "minimum_distance",
          [](Solver& self, const py::object& x, double bound) {
            const Numbers pose = self.positions(x, "x");
            return self.ask([&](ContactChecker& c) { return c.minimum_distance(span_of(pose), bound); });
          },
          py::arg("x"), py::arg("bound"),
          "The smallest distance of two features that may collide, mesh units; infinity when it is above "
          "bound, which may be infinite.\n\nx: V x 3, mesh units. Error: as collision_free_step_size.");
}

void bind_checker(py::module_& module) {
  py::class_<Solver> checker(
      module, "ContactChecker",
      "Answers the queries of implicit solvers about one mesh, and reuses the work of earlier "
      "calls.\n\nCalls of one checker wait for each other; use one per thread.");
  checker.def(
      py::init([](std::shared_ptr<CollisionMesh> mesh, bool certificates, double tolerance,
                  double conservative_rescaling, bool rescale_distance, const py::object& filter) {
        return std::make_unique<Solver>(
            std::move(mesh),
            ContactSettings{certificates, tolerance, conservative_rescaling, rescale_distance}, filter);
      }),
      py::arg("mesh").none(false), py::kw_only(), py::arg("certificates") = true, py::arg("tolerance") = 0.0,
      py::arg("conservative_rescaling") = 0.8, py::arg("rescale_distance") = false,
      py::arg("filter") = py::none(),
      "certificates: skip what they prove in steps. tolerance: mesh units; 0: 2^-30 of each pair's "
      "size. conservative_rescaling: the share, in (0, 1], of the way to contact that a step may "
      "go; with rescale_distance also of a pair's distance beyond min_distance that it may lose, as in "
      "ipc-toolkit. filter: a PairFilter for the mesh, of pairs that are not tested, beside those of its "
      "groups.");
  bind_queries(checker);
  bind_last_call(checker);
}

py::array_t<double> towards(const py::object& x0, const py::object& x1, const py::object& share) {
  const Numbers from = numbers_of(x0, "x0", {-1, 3}, "V x 3");
  const Numbers to = numbers_of(x1, "x1", {from.shape(0), 3}, "V x 3 like x0");
  py::array_t<double> out({from.shape(0), py::ssize_t{3}});
  const std::span<double> into(out.mutable_data(), static_cast<std::size_t>(out.size()));
  if (py::array(share).ndim() == 0) {
    step_towards(span_of(from), span_of(to), py::float_(share).cast<double>(), into);
  } else {
    const Numbers shares = numbers_of(share, "share", {from.shape(0)}, "a number, or V of them");
    step_towards(span_of(from), span_of(to), span_of(shares), into);
  }
  return out;
}

}  // namespace

void bind_solver(py::module_& module) {
  PYBIND11_NUMPY_DTYPE(CloseRow, kind, count, vertices, weights, distance, normal, mollifier_threshold);
  py::tuple kinds(kClosePairKindNames.size());
  for (std::size_t k = 0; k < kinds.size(); ++k) kinds[k] = kClosePairKindNames[k];
  module.attr("CLOSE_PAIR_KINDS") = kinds;
  bind_mesh(module);
  bind_candidates(module);
  bind_checker(module);
  module.def("step_towards", &towards, py::arg("x0"), py::arg("x1"), py::arg("share"),
             "The positions at a share of the step from x0 to x1, rounded as "
             "ContactChecker.collision_free_step_size "
             "assumes them; x1 itself for 1.\n\nx0, x1: V x 3. share: one for all, or V of them, as of "
             "collision_free_step_sizes.");
}

}  // namespace foldproof::python
