#include "foldproof/bvh.h"

#include "arrays.h"
#include "module.h"
#include "unlocked.h"

namespace foldproof::python {
namespace {

std::shared_ptr<Hierarchy> build(const py::handle& triangles, const py::handle& positions,
                                 const py::handle& leaf_triangles) {
  const Numbers x = numbers_of(positions, "positions", {-1, 3}, "V x 3");
  auto list = triangles_of(triangles);
  const auto leaf = static_cast<Index>(whole_number(leaf_triangles, "leaf_triangles"));
  const Unlocked unlocked;
  auto topology = take(Topology::make(static_cast<Index>(x.shape(0)), std::move(list)));
  return std::make_shared<Hierarchy>(
      take(Hierarchy::build(std::move(topology), span_of(x), {.leaf_triangles = leaf})));
}

template <std::size_t N>
py::array ids_of(std::span<const std::array<Index, N>> rows, const py::object& owner) {
  return view_of(reinterpret_cast<const Index*>(rows.data()),
                 {static_cast<py::ssize_t>(rows.size()), static_cast<py::ssize_t>(N)}, owner);
}

}  // namespace

void bind_hierarchy(py::module_& module) {
  py::class_<Hierarchy, std::shared_ptr<Hierarchy>>(module, "Hierarchy",
                                                    "Triangles and a bounding volume hierarchy over them. "
                                                    "Immutable; shared by any number of checkers.")
      .def(py::init(&build), py::arg("triangles"), py::arg("positions"), py::arg("leaf_triangles") = 12,
           "triangles: T x 3 vertex ids. positions: V x 3, mesh units, any pose of the mesh.\n\n"
           "Takes a few microseconds per triangle. Error: wrong shapes, ids beyond V, numbers that are not "
           "finite.")
      .def_property_readonly(
          "vertex_count", [](const Hierarchy& h) { return h.topology().vertex_count(); }, "V.")
      .def_property_readonly(
          "triangles",
          [](const py::object& self) {
            return ids_of(self.cast<const Hierarchy&>().topology().triangles(), self);
          },
          "T x 3 vertex ids, uint32, in the given order; read-only.")
      .def_property_readonly(
          "edges",
          [](const py::object& self) {
            return ids_of(self.cast<const Hierarchy&>().topology().edges(), self);
          },
          "E x 2 vertex ids, uint32, the smaller first, in lexicographic order; read-only.")
      .def_property_readonly("leaf_count", &Hierarchy::leaf_count, "The number of leaves.");
}

}  // namespace foldproof::python
