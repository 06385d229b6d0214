// Shapes described by a few coordinates: certified balls, and the checker that uses them.
#include "foldproof/reduced.h"

#include <mutex>
#include <optional>

#include "arrays.h"
#include "long_call.h"
#include "models.h"
#include "module.h"
#include "steps.h"
#include "unlocked.h"

namespace foldproof::python {
namespace {

/// Its scratch serves one call at a time.
struct Shape {
  std::shared_ptr<const ReducedShape> shape;
  std::shared_ptr<const ChartLibrary> charts;
  ReducedShape::Scratch scratch;
  std::mutex mutex;

  Index modes() const { return shape->motion()->modes(); }
  py::ssize_t vertices() const { return shape->motion()->hierarchy()->topology().vertex_count(); }
};

// Balls large enough for all training poses.
ReducedCenter center_at(const Learned& learned, const Eigen::VectorXd& p) {
  double max_radius = std::sqrt(static_cast<double>(p.size())) + 4;
  for (Eigen::Index k = 0; k < learned.coordinates.cols(); ++k)
    max_radius = std::max(max_radius, 1.1 * learned.pca.mahalanobis(learned.coordinates.col(k) - p));
  return {{p.data(), p.data() + p.size()}, max_radius};
}

std::vector<ReducedCenter> centers_of(const Learned& learned, const py::object& given) {
  const Index modes = learned.pca.modes();
  std::vector<ReducedCenter> centers;
  const std::string layout = "C x M with M = " + std::to_string(modes) + " modes";
  const Numbers p = numbers_of(given, "centers", {-1, modes}, layout.c_str());
  for (py::ssize_t c = 0; c < p.shape(0); ++c)
    centers.push_back(center_at(learned, Eigen::Map<const Eigen::VectorXd>(p.data() + c * modes, modes)));
  return centers;
}

std::unique_ptr<Shape> build(const Model& model, const py::object& centers, double clearance,
                             const py::object& progress) {
  const Learned& learned = learned_of(model);
  if (!(clearance >= 0) || !std::isfinite(clearance))
    refuse("clearance", "is not a finite number, at least 0", "give another");
  auto made = std::make_unique<Shape>();
  made->charts = model.charts;
  const bool kept =
      centers.is_none() && model.balls && (clearance == 0 || clearance == model.balls->clearance);
  auto list = centers.is_none() ? ball_centers(learned) : centers_of(learned, centers);
  run_long(progress, [&](LongCall& call) {
    if (kept) {
      made->shape = take(kept_balls(model));
      return;
    }
    auto motion = std::make_shared<const ReducedMotion>(
        take(ReducedMotion::make(model.hierarchy(), model.learned->pca)));
    made->shape = std::make_shared<const ReducedShape>(
        take(ReducedShape::build(std::move(motion), std::move(list), {.clearance = clearance},
                                 {.progress = call.progress(), .cancel = call.cancel()})));
  });
  return made;
}

Index center_of(const Shape& self, std::int64_t center) {
  const auto count = static_cast<std::int64_t>(self.shape->centers().size());
  if (center >= 0 && center < count) return static_cast<Index>(center);
  throw py::index_error("center " + std::to_string(center) + " of " + std::to_string(count));
}

Numbers coordinates_of(const Shape& self, const py::handle& p, const char* what) {
  const std::string layout = std::to_string(self.modes()) + " numbers, one per mode";
  return numbers_of(p, what, {self.modes()}, layout.c_str());
}

py::array centers_array(const Shape& self) {
  std::vector<double> p;
  for (const ReducedCenter& center : self.shape->centers())
    p.insert(p.end(), center.p.begin(), center.p.end());
  return owned(std::move(p), {static_cast<py::ssize_t>(self.shape->centers().size()), self.modes()});
}

py::tuple certified(const Shape& self, std::int64_t center, double at_least) {
  const CertifiedRadius found = self.shape->certified(center_of(self, center), at_least);
  py::array_t<UncertifiedPair> uncertified(static_cast<py::ssize_t>(found.uncertified.size()));
  std::copy(found.uncertified.begin(), found.uncertified.end(), uncertified.mutable_data());
  return py::make_tuple(found.radius, uncertified);
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
    result.pose.translation = Vec3::load(numbers_of(translation, "translation", {3}, "3").data());
  return result;
}

py::array positions(const Shape& self, const py::object& p, const py::object& rotation,
                    const py::object& translation) {
  const Placed object = placed(self, py::make_tuple(p, rotation, translation), "p");
  std::vector<double> x(static_cast<std::size_t>(3 * self.vertices()));
  {
    const Unlocked unlocked;
    pose_vertices(*self.shape->motion(), object.pose, x);
  }
  return owned(std::move(x), {self.vertices(), 3});
}

const char* proven_free(Shape& self, const py::object& p0, const py::object& p1) {
  const Numbers from = coordinates_of(self, p0, "p0"), to = coordinates_of(self, p1, "p1");
  const Unlocked unlocked;
  const std::lock_guard lock(self.mutex);
  switch (self.shape->proven_free(span_of(from), span_of(to), self.scratch)) {
    case ReducedProof::Free:
      return "free";
    case ReducedProof::FreeExceptUncertified:
      return "free_except_uncertified";
    default:
      return "unproven";
  }
}

struct PoseChecker {
  std::vector<py::object> shapes;
  std::optional<ReducedChecker> checker;
  std::mutex mutex;
};

std::unique_ptr<PoseChecker> make_pose_checker(const py::object& shapes) {
  auto made = std::make_unique<PoseChecker>();
  std::vector<ReducedChecker::Object> objects;
  for (const auto& item : items_of(shapes)) {
    if (!py::isinstance<Shape>(item))
      throw py::type_error("shapes: expected a foldproof.ReducedShape, or a list of them");
    made->shapes.push_back(py::reinterpret_borrow<py::object>(item));
    const auto& shape = item.cast<const Shape&>();
    objects.emplace_back(shape.shape, shape.charts);
  }
  if (objects.empty()) refuse("shapes", "are none", "give at least one");
  made->checker.emplace(std::move(objects));
  return made;
}

std::vector<Placed> ends_of(const PoseChecker& self, const py::object& given, const char* what) {
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

std::unique_ptr<AnswerFor<StepResult>> check_poses(PoseChecker& self, const py::object& start,
                                                   const py::object& end, const py::kwargs& settings) {
  const auto [step, paper_miss_rate] = settings_of(settings);
  refuse_given("ReducedChecker", {{"explain", step.explain}, {"mode='paper'", paper_miss_rate.has_value()}});
  const auto from = ends_of(self, start, "start"), to = ends_of(self, end, "end");
  const auto poses = [](const std::vector<Placed>& placed) {
    std::vector<ReducedPose> list;
    list.reserve(placed.size());
    for (const Placed& one : placed) list.push_back(one.pose);
    return list;
  };
  const auto x0 = poses(from), x1 = poses(to);
  auto result = std::make_unique<AnswerFor<StepResult>>();
  for (const py::object& shape : self.shapes)
    result->objects.emplace_back(shape.cast<const Shape&>().shape->motion()->hierarchy());
  const Unlocked unlocked;
  const std::lock_guard lock(self.mutex);
  take(self.checker->check(x0, x1, step, *result));
  return result;
}

}  // namespace

void bind_reduced(py::module_& module) {
  PYBIND11_NUMPY_DTYPE(UncertifiedPair, leaf_a, leaf_b, touches, radius);
  py::class_<Shape>(
      module, "ReducedShape",
      "How far the shapes of a model may move without touching themselves: balls in the space of its "
      "M coordinates p that are proven free. Distances are in standard deviations (Mahalanobis).")
      .def(
          py::init(&build), py::arg("model"), py::arg("centers") = py::none(), py::arg("clearance") = 0.0,
          py::kw_only(), py::arg("progress") = py::none(),
          "centers: C x M coordinates, the centers of the balls; None: the mean, and the centers of the "
          "clusters of poses if there are several. clearance: mesh units; features that are proven separated "
          "are farther apart than this; 0: 2^-24 of the mesh's size. progress: called with the share of work "
          "done.\n\nTakes about 20 microseconds per triangle and center, and next to nothing where the model "
          "keeps "
          "the balls (foldproof radius --save). Ctrl-C ends it. Error: wrong "
          "shapes, a model that learned no shapes.")
      .def_property_readonly("modes", &Shape::modes, "M.")
      .def_property_readonly(
          "clearance", [](const Shape& s) { return s.shape->clearance(); }, "Mesh units.")
      .def_property_readonly("centers", &centers_array, "C x M coordinates.")
      .def(
          "radius", [](const Shape& s, std::int64_t c) { return s.shape->radius(center_of(s, c)); },
          py::arg("center") = 0,
          "No p closer to the center makes the surface touch itself, except perhaps in the pairs of patches "
          "that certified() lists.")
      .def("certified", &certified, py::arg("center") = 0, py::arg("at_least") = 0.0,
           "(radius, uncertified): the radius, and the pairs of patches that it says nothing about, a "
           "structured array of leaf_a, leaf_b, touches, radius. Pairs of leaves with a radius below "
           "at_least are among them. The radius can be smaller than at_least, where pairs of larger regions "
           "limit it.")
      .def(
          "distance",
          [](const Shape& s, const py::object& p, std::int64_t c) {
            return s.shape->distance(center_of(s, c), span_of(coordinates_of(s, p, "p")));
          },
          py::arg("p"), py::arg("center") = 0, "From the center to p (M numbers).")
      .def("positions", &positions, py::arg("p"), py::arg("rotation") = py::none(),
           py::arg("translation") = py::none(),
           "The shape x(p) as the checker sees it, V x 3: turned by rotation (3 x 3), then moved by "
           "translation (3, mesh units).")
      .def("proven_free", &proven_free, py::arg("p0"), py::arg("p1"),
           "Whether nothing touches on the way from p0 to p1: 'free', 'free_except_uncertified' (but for "
           "pairs of patches that are certified around no center) or 'unproven'.");
  py::class_<PoseChecker>(
      module, "ReducedChecker",
      "Checks objects that move in reduced coordinates. Where balls prove them free, no vertex is read. "
      "Calls of one checker wait for each other.")
      .def(py::init(&make_pose_checker), py::arg("shapes"),
           "shapes: a ReducedShape, or a list of them. Certificates of their models are used from the first "
           "step on.")
      .def("check", &check_poses, py::arg("start"), py::arg("end"),
           with_settings(
               "What StepChecker.check answers for the vertices at both ends (ReducedShape.positions), "
               "which move straight.\n\n"
               "start, end: p (M numbers), or (p, rotation, translation) of a placed object; a list with "
               "one of these per object. Error: wrong shapes, numbers that are not finite, a matrix that "
               "is no rotation.")
               .c_str());
}

}  // namespace foldproof::python
