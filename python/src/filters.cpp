// Which pairs checkers do not test.
#include "filters.h"

#include "module.h"
#include "steps.h"
#include "unlocked.h"

namespace foldproof::python {
namespace {

bool same_objects(const std::vector<Object>& a, const std::vector<Object>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const Object& s, const Object& t) {
    return s.hierarchy() == t.hierarchy() ||
           (s.hierarchy()->topology() == t.hierarchy()->topology() &&
            std::ranges::equal(s.hierarchy()->triangle_ids(), t.hierarchy()->triangle_ids()));
  });
}

void require_filter(const py::handle& filter) {
  if (!py::isinstance<Filter>(filter))
    throw py::type_error("filter: expected a foldproof.PairFilter, as foldproof.ignore_sewn makes one");
}

template <class Make>
std::unique_ptr<Filter> make_filter(std::vector<Object> objects, Make make) {
  const Unlocked unlocked;
  auto pairs = take(make(objects));
  return std::make_unique<Filter>(Filter{std::move(pairs), std::move(objects)});
}

std::unique_ptr<Filter> sewn(const py::object& objects, const py::object& seams) {
  std::vector<Object> of = objects_of(objects);
  std::vector<std::array<ObjectVertex, 2>> pairs;
  if (of.size() == 1) {
    for (const auto& [a, b] : rows_of<2>(ids_of(seams, "seams", "vertex", 2, "K x 2 vertex ids")))
      pairs.push_back({{{0, a}, {0, b}}});
  } else {
    const char* layout = "K x 4: object, vertex, object, vertex";
    for (const auto& [a, v, b, w] : rows_of<4>(ids_of(seams, "seams", "object or vertex", 4, layout)))
      pairs.push_back({{{a, v}, {b, w}}});
  }
  return make_filter(std::move(of), [&](const auto& all) { return ignore_sewn(all, pairs); });
}

std::unique_ptr<Filter> rings(const py::object& objects, const py::object& count) {
  const auto most = static_cast<Index>(whole_number(count, "rings"));
  return make_filter(objects_of(objects), [&](const auto& all) { return ignore_rings(all, most); });
}

std::unique_ptr<Filter> length(const py::object& objects, const py::object& x, double most) {
  std::vector<Object> of = objects_of(objects);
  const Pose pose = pose_of(x, "x", of);
  return make_filter(std::move(of), [&](const auto& all) { return ignore_length(all, pose.spans, most); });
}

std::unique_ptr<Filter> fixed(const py::object& objects, const py::object& flags) {
  std::vector<Object> of = objects_of(objects);
  const py::list items =
      of.size() == 1 && !py::isinstance<py::list>(flags) ? py::list(py::make_tuple(flags)) : items_of(flags);
  if (items.size() != of.size())
    refuse("fixed", "is not for each of the objects", "give a list with one array of booleans per object");
  std::vector<std::vector<std::uint8_t>> is_fixed;
  for (std::size_t k = 0; k < of.size(); ++k)
    is_fixed.push_back(flags_of(items[k], "fixed", of[k].hierarchy()->topology().vertex_count()));
  return make_filter(std::move(of), [&](const auto& all) { return ignore_fixed(all, is_fixed); });
}

std::unique_ptr<Filter> touching(const py::object& objects, const py::object& x, double thickness) {
  std::vector<Object> of = objects_of(objects);
  const Pose pose = pose_of(x, "x", of);
  return make_filter(std::move(of),
                     [&](const auto& all) { return ignore_touching(all, pose.spans, thickness); });
}

std::unique_ptr<Filter> all_of(const py::args& filters) {
  if (filters.empty()) refuse("filters", "are none", "give at least one");
  require_filter(filters[0]);
  const auto& objects = filters[0].cast<const Filter&>().objects;
  std::vector<std::shared_ptr<const PairFilter>> pairs;
  for (const auto& filter : filters)
    pairs.push_back(filter_for(py::reinterpret_borrow<py::object>(filter), objects));
  return std::make_unique<Filter>(Filter{ignore_all(std::move(pairs)), objects});
}

}  // namespace

std::shared_ptr<const PairFilter> filter_for(const py::object& filter, const std::vector<Object>& objects) {
  if (filter.is_none()) return nullptr;
  require_filter(filter);
  const auto& made = filter.cast<const Filter&>();
  if (!same_objects(made.objects, objects))
    refuse("filter", "was made for other objects", "make one for these");
  return made.pairs;
}

std::vector<std::uint8_t> flags_of(const py::handle& flags, const char* what, Index vertices) {
  const auto array = py::array::ensure(flags);
  if (!array || array.dtype().kind() != 'b' || array.ndim() != 1 || array.shape(0) != vertices)
    refuse(what, "is not an array of V booleans with V = " + std::to_string(vertices),
           "give True or False for each vertex");
  const auto values = py::array_t<bool, py::array::c_style | py::array::forcecast>(array);
  return {values.data(), values.data() + values.size()};
}

void bind_filters(py::module_& module) {
  py::class_<Filter>(module, "PairFilter",
                     "Pairs of objects' features and triangles that a StepChecker, ContactFinder or "
                     "ContactChecker does not test. "
                     "ignore_sewn and its like make one.")
      .def_property_readonly(
          "object_count", [](const Filter& self) { return self.objects.size(); },
          "How many objects it is for.");
  const char* objects = "objects: what the checker is given, or the CollisionMesh of a ContactChecker.";
  const auto text = [&](const char* what, const char* arguments) {
    return std::string(what) + "\n\n" + objects + " " + arguments;
  };
  module.def(
      "ignore_sewn", &sewn, py::arg("objects"), py::arg("seams"),
      text("Ignores what meets at a seam: pairs that contain one each of two vertices sewn to each other.",
           "seams: K x 2 vertex ids; of several objects K x 4: object, vertex, object, vertex. Sew a "
           "vertex on an edge "
           "to both of its ends.")
          .c_str());
  module.def(
      "ignore_rings", &rings, py::arg("objects"), py::arg("rings"),
      text("Ignores neighbors: pairs within an object with a path of at most this many edges between them.",
           "rings: 0: a common vertex. Folds of this size are not found in poses either.")
          .c_str());
  module.def("ignore_length", &length, py::arg("objects"), py::arg("x"), py::arg("length"),
             text("Ignores neighbors: pairs within an object with a path along edges of at most this length "
                  "between them.",
                  "x: V x 3, the pose, or a list of one array per object. length: mesh units.")
                 .c_str());
  module.def("ignore_fixed", &fixed, py::arg("objects"), py::arg("fixed"),
             text("Ignores pairs all of whose vertices are fixed.",
                  "fixed: V booleans, or a list of one array per object.")
                 .c_str());
  module.def(
      "ignore_touching", &touching, py::arg("objects"), py::arg("x"), py::arg("thickness") = 0.0,
      text("Ignores the pairs that touch or cross in a pose.",
           "x: V x 3, or a list of one array per object. thickness: mesh units; features this close touch.")
          .c_str());
  module.def("ignore_all", &all_of,
             "Ignores what any of the filters ignores. They are for the same objects.");
}

}  // namespace foldproof::python
