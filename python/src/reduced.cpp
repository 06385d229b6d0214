// Shapes told by a few numbers: certified balls, and the checker that uses them.
#include "foldproof/reduced.h"

#include <mutex>
#include <optional>

#include "arrays.h"
#include "long_call.h"
#include "module.h"
#include "steps.h"

namespace foldproof::python {
namespace {

/// With scratch of one caller at a time.
struct Shape {
  std::shared_ptr<const ReducedShape> shape;
  ReducedShape::Scratch scratch;
  std::mutex mutex;

  Index modes() const { return shape->motion()->modes(); }
  py::ssize_t vertices() const { return shape->motion()->hierarchy()->topology().vertex_count(); }
};

// Balls reach as far as any training pose lies.
ReducedCentre centre_at(const Learned& learned, const Eigen::VectorXd& p) {
  double farthest = std::sqrt(static_cast<double>(p.size())) + 4;
  for (Eigen::Index k = 0; k < learned.coordinates.cols(); ++k)
    farthest = std::max(farthest, 1.1 * learned.pca.mahalanobis(learned.coordinates.col(k) - p));
  return {{p.data(), p.data() + p.size()}, farthest};
}

std::vector<ReducedCentre> centres_of(const Learned& learned, const py::object& given) {
  const Index modes = learned.pca.modes();
  std::vector<ReducedCentre> centres;
  if (given.is_none()) {
    centres.push_back(centre_at(learned, Eigen::VectorXd::Zero(modes)));
    const Clusters& clusters = learned.clusters;
    for (Index c = 0; clusters.count() > 1 && c < clusters.count(); ++c)
      centres.push_back(centre_at(learned, clusters.centres.col(c)));
    return centres;
  }
  const std::string layout = "C x M with M = " + std::to_string(modes) + " modes";
  const Numbers p = numbers_of(given, "centres", {-1, modes}, layout.c_str());
  for (py::ssize_t c = 0; c < p.shape(0); ++c)
    centres.push_back(centre_at(learned, Eigen::Map<const Eigen::VectorXd>(p.data() + c * modes, modes)));
  return centres;
}

std::unique_ptr<Shape> build(const Model& model, const py::object& centres, double clearance,
                             const py::object& progress) {
  if (!model.learned)
    refuse("model", "has learned no shapes", "train it anew with at least 3 poses that differ");
  if (!(clearance >= 0) || !std::isfinite(clearance))
    refuse("clearance", "is not a finite number, at least 0", "give another");
  auto list = centres_of(*model.learned, centres);
  auto made = std::make_unique<Shape>();
  run_long(progress, [&](LongCall& call) {
    auto motion = std::make_shared<const ReducedMotion>(
        take(ReducedMotion::make(model.hierarchy(), model.learned->pca)));
    made->shape = std::make_shared<const ReducedShape>(
        take(ReducedShape::build(std::move(motion), std::move(list), {.clearance = clearance},
                                 {.progress = call.progress(), .cancel = call.cancel()})));
  });
  return made;
}

Index centre_of(const Shape& self, std::int64_t centre) {
  const auto count = static_cast<std::int64_t>(self.shape->centres().size());
  if (centre >= 0 && centre < count) return static_cast<Index>(centre);
  throw py::index_error("centre " + std::to_string(centre) + " of " + std::to_string(count));
}

Numbers coordinates_of(const Shape& self, const py::handle& p, const char* what) {
  const std::string layout = std::to_string(self.modes()) + " numbers, one per mode";
  return numbers_of(p, what, {self.modes()}, layout.c_str());
}

py::array centres_array(const Shape& self) {
  std::vector<double> p;
  for (const ReducedCentre& centre : self.shape->centres())
    p.insert(p.end(), centre.p.begin(), centre.p.end());
  return owned(std::move(p), {static_cast<py::ssize_t>(self.shape->centres().size()), self.modes()});
}

py::tuple certified(const Shape& self, std::int64_t centre, double at_least) {
  const CertifiedRadius found = self.shape->certified(centre_of(self, centre), at_least);
  py::array_t<LeftOut> left(static_cast<py::ssize_t>(found.left_out.size()));
  std::copy(found.left_out.begin(), found.left_out.end(), left.mutable_data());
  return py::make_tuple(found.radius, left);
}

/// One object at one end of a step; keeps the arrays.
struct Placed {
  Numbers p;
  ReducedPose pose;
};

// p alone, or (p, rotation, translation).
Placed placed(const Shape& self, const py::handle& item, const char* what) {
  py::object p = py::reinterpret_borrow<py::object>(item);
  py::object rotation = py::none(), translation = py::none();
  if (py::isinstance<py::tuple>(item)) {
    const auto parts = py::reinterpret_borrow<py::tuple>(item);
    if (parts.size() != 3)
      refuse(what, "has " + std::to_string(parts.size()) + " parts", "give p, or (p, rotation, translation)");
    p = parts[0], rotation = parts[1], translation = parts[2];
  }
  Placed result{coordinates_of(self, p, what), {}};
  result.pose.p = span_of(result.p);
  if (!rotation.is_none()) {
    const Numbers r = numbers_of(rotation, "rotation", {3, 3}, "3 x 3");
    result.pose.rotation = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(r.data());
  }
  if (!translation.is_none())
    result.pose.translation = Eigen::Map<const Vec3>(numbers_of(translation, "translation", {3}, "3").data());
  return result;
}

py::array positions(const Shape& self, const py::object& p, const py::object& rotation,
                    const py::object& translation) {
  const Placed where = placed(self, py::make_tuple(p, rotation, translation), "p");
  std::vector<double> x(static_cast<std::size_t>(3 * self.vertices()));
  {
    const py::gil_scoped_release others_go_on;
    place_vertices(*self.shape->motion(), where.pose, x);
  }
  return owned(std::move(x), {self.vertices(), 3});
}

const char* proven_free(Shape& self, const py::object& p0, const py::object& p1) {
  const Numbers from = coordinates_of(self, p0, "p0"), to = coordinates_of(self, p1, "p1");
  const py::gil_scoped_release others_go_on;
  const std::lock_guard lock(self.mutex);
  switch (self.shape->proven_free(span_of(from), span_of(to), self.scratch)) {
    case ReducedProof::Free:
      return "free";
    case ReducedProof::FreeButLeft:
      return "free_but_left";
    default:
      return "open";
  }
}

struct Checker {
  std::vector<py::object> shapes;
  std::optional<ReducedChecker> checker;
  std::mutex mutex;
};

std::unique_ptr<Checker> make_checker(const py::object& shapes) {
  auto made = std::make_unique<Checker>();
  std::vector<ReducedChecker::Object> objects;
  for (const auto& item : items_of(shapes)) {
    if (!py::isinstance<Shape>(item))
      throw py::type_error("shapes: expected a foldproof.ReducedShape, or a list of them");
    made->shapes.push_back(py::reinterpret_borrow<py::object>(item));
    objects.push_back(item.cast<const Shape&>().shape);
  }
  if (objects.empty()) refuse("shapes", "are none", "give at least one");
  made->checker.emplace(std::move(objects));
  return made;
}

std::vector<Placed> ends_of(const Checker& self, const py::object& given, const char* what) {
  py::list items;
  if (self.shapes.size() == 1 && !py::isinstance<py::list>(given)) {
    items.append(given);
  } else {
    items = py::list(given);
  }
  if (items.size() != self.shapes.size()) {
    refuse(what,
           "has " + std::to_string(items.size()) + " poses for " + std::to_string(self.shapes.size()) +
               " objects",
           "give a list with one per object");
  }
  std::vector<Placed> ends;
  for (std::size_t k = 0; k < items.size(); ++k)
    ends.push_back(placed(self.shapes[k].cast<const Shape&>(), items[k], what));
  return ends;
}

std::unique_ptr<StepResult> check(Checker& self, const py::object& begin, const py::object& end,
                                  const py::kwargs& settings) {
  const StepSettings step = step_settings(settings);
  const auto from = ends_of(self, begin, "begin"), to = ends_of(self, end, "end");
  const auto poses = [](const std::vector<Placed>& placed) {
    std::vector<ReducedPose> list;
    for (const Placed& one : placed) list.push_back(one.pose);
    return list;
  };
  const auto x0 = poses(from), x1 = poses(to);
  auto result = std::make_unique<StepResult>();
  const py::gil_scoped_release others_go_on;
  const std::lock_guard lock(self.mutex);
  take(self.checker->check(x0, x1, step, *result));
  return result;
}

}  // namespace

void bind_reduced(py::module_& module) {
  PYBIND11_NUMPY_DTYPE(LeftOut, leaf_a, leaf_b, touches, radius);
  py::class_<Shape>(
      module, "ReducedShape",
      "How far the shapes of a model may go without touching themselves: balls in the space of its "
      "M coordinates p, proven free. Distances are in standard deviations (Mahalanobis).")
      .def(
          py::init(&build), py::arg("model"), py::arg("centres") = py::none(), py::arg("clearance") = 0.0,
          py::kw_only(), py::arg("progress") = py::none(),
          "centres: C x M coordinates to centre balls at; None: the mean, and the centres of the groups of "
          "poses "
          "where there are several. clearance: mesh units; what is proven apart is farther apart than this. "
          "0: "
          "2^-20 of the mesh's size. progress: called with the share that is done.\n\n"
          "Takes about 20 microseconds per triangle and centre. Ctrl-C ends it. Error: wrong shapes, a model "
          "that learned no shapes.")
      .def_property_readonly("modes", &Shape::modes, "M.")
      .def_property_readonly(
          "clearance", [](const Shape& s) { return s.shape->clearance(); }, "Mesh units.")
      .def_property_readonly("centres", &centres_array, "C x M coordinates.")
      .def(
          "radius", [](const Shape& s, std::int64_t c) { return s.shape->radius(centre_of(s, c)); },
          py::arg("centre") = 0,
          "No p nearer to the centre makes the surface touch itself, but for the pairs of patches that "
          "certified() names.")
      .def("certified", &certified, py::arg("centre") = 0, py::arg("at_least") = 0.0,
           "(radius, left_out): the radius when pairs of patches that reach less far than at_least are left "
           "out "
           "as well. left_out: structured array of leaf_a, leaf_b, touches, radius.")
      .def(
          "distance",
          [](const Shape& s, const py::object& p, std::int64_t c) {
            return s.shape->distance(centre_of(s, c), span_of(coordinates_of(s, p, "p")));
          },
          py::arg("p"), py::arg("centre") = 0, "From the centre to p (M numbers).")
      .def("positions", &positions, py::arg("p"), py::arg("rotation") = py::none(),
           py::arg("translation") = py::none(),
           "The shape x(p) as the checker sees it, V x 3: turned by rotation (3 x 3), then moved by "
           "translation "
           "(3, mesh units).")
      .def("proven_free", &proven_free, py::arg("p0"), py::arg("p1"),
           "Whether nothing touches on the way from p0 to p1: 'free', 'free_but_left' (but for pairs of "
           "patches "
           "that no centre proves) or 'open'.");
  py::class_<Checker>(
      module, "ReducedChecker",
      "Checks objects that move in reduced coordinates; what balls prove costs nothing per vertex. "
      "Steps of one checker wait for each other.")
      .def(py::init(&make_checker), py::arg("shapes"), "shapes: a ReducedShape, or a list of them.")
      .def("check", &check, py::arg("begin"), py::arg("end"),
           with_settings(
               "What StepChecker.check answers for the vertices at both ends (ReducedShape.positions), "
               "which go straight.\n\n"
               "begin, end: p (M numbers), or (p, rotation, translation) of a placed object; a list with "
               "one of these per object. Error: wrong shapes, numbers that are not finite, a rotation "
               "that is none.")
               .c_str());
}

}  // namespace foldproof::python
