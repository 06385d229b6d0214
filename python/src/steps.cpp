// StepChecker and its answers.
#include "steps.h"

#include <mutex>
#include <optional>

#include "filters.h"
#include "foldproof/solver.h"
#include "module.h"
#include "report/report.h"
#include "unlocked.h"

namespace foldproof::python {
namespace {

using StepAnswer = AnswerFor<StepResult>;
using StaticAnswer = AnswerFor<StaticResult>;

/// Objects that move together, with a lock, since checks run without Python's lock.
struct Checker {
  std::vector<Object> objects;
  std::vector<std::shared_ptr<const foldproof::Model>> models;  // null for a Hierarchy
  std::optional<StepChecker> checker;
  std::vector<std::vector<std::uint8_t>> predicted_free;
  std::mutex mutex;

  /// Mode 'paper': for a step, or for a pose.
  StepSettings predict(const Settings& settings, const Pose& from, const Pose& to) {
    StepSettings step = settings.step;
    if (!settings.paper_miss_rate) return step;
    step.declared_free = &predicted_free;
    if (step.within)
      take(predict_free_nodes(models, from.spans, to.spans, *settings.paper_miss_rate, predicted_free));
    return step;
  }
};

std::unique_ptr<Checker> make_checker(const py::object& objects, const py::object& filter) {
  auto made = std::make_unique<Checker>();
  made->objects = objects_of(objects, &made->models);
  made->checker.emplace(made->objects, filter_for(filter, made->objects));
  return made;
}

std::unique_ptr<StepAnswer> check(Checker& self, const py::object& x0, const py::object& x1,
                                  const py::kwargs& settings) {
  const Settings asked = settings_of(settings);
  const Pose from = pose_of(x0, "x0", self.objects), to = pose_of(x1, "x1", self.objects);
  auto result = std::make_unique<StepAnswer>();
  result->objects = self.objects;
  result->statistical = asked.paper_miss_rate.has_value();
  const Unlocked unlocked;
  const std::lock_guard lock(self.mutex);
  take(self.checker->check(from.spans, to.spans, self.predict(asked, from, to), *result));
  return result;
}

std::unique_ptr<StaticAnswer> check_static(Checker& self, const py::object& x, const py::kwargs& settings) {
  const Settings asked = settings_of(settings);
  require_static_fits("check_static", asked.step);
  const Pose pose = pose_of(x, "x", self.objects);
  auto result = std::make_unique<StaticAnswer>();
  result->objects = self.objects;
  result->statistical = asked.paper_miss_rate.has_value();
  const Unlocked unlocked;
  const std::lock_guard lock(self.mutex);
  take(self.checker->check_static(pose.spans, self.predict(asked, pose, pose), *result));
  return result;
}

py::list explanation_of(const Explanation& explanation, const py::object& owner) {
  py::list objects;
  for (const auto& object : explanation.objects) {
    py::dict d;
    d["level"] = view_of(object.level, owner);
    d["reason"] = view_of(reinterpret_cast<const std::uint8_t*>(object.reason.data()),
                          {static_cast<py::ssize_t>(object.reason.size())}, owner);
    objects.append(d);
  }
  return objects;
}

template <class Answer>
py::array colliding_faces_of(const Answer& answer, const Hierarchy& hierarchy, Index object) {
  if (object >= answer.objects.size()) {
    refuse("object",
           std::to_string(object) + " is none of the " + std::to_string(answer.objects.size()) +
               " that were checked",
           "count them from 0");
  }
  if (hierarchy.topology() != answer.objects[object].hierarchy()->topology())
    refuse("hierarchy", "is not that of object " + std::to_string(object), "give the one that was checked");
  const auto marks = colliding_faces(hierarchy.topology(), object, answer);
  py::array_t<bool> faces(static_cast<py::ssize_t>(marks.size()));
  std::copy(marks.begin(), marks.end(), faces.mutable_data());
  return faces;
}

template <class Class>
void bind_answer(Class& answer) {
  using Answer = typename Class::type;
  answer.def_property_readonly("clean", &Answer::clean, "Whether nothing collides.")
      .def_readonly("statistical", &Answer::statistical, "Mode 'paper', which can miss collisions.")
      .def_property_readonly(
          "work", [](const Answer& a) { return work_of(a.work); },
          "Work counters: refits, node_tests, certificate_tests, certificate_passes, leaf_pairs, "
          "candidates_vf, candidates_ee, undecided.")
      .def_property_readonly(
          "milliseconds", [](const Answer& a) { return milliseconds_of(a.milliseconds); },
          "Wall time: total, update, traverse, narrow.")
      .def_property_readonly(
          "explanation",
          [](const py::object& self) { return explanation_of(self.cast<const Answer&>().explanation, self); },
          "With explain=True, per object a dict of 'level' (T, int8) and 'reason' (T, uint8; names in "
          "foldproof.REASONS); else empty.")
      .def("colliding_faces", &colliding_faces_of<Answer>, py::arg("hierarchy"), py::arg("object") = 0,
           "T booleans: the object's triangles that collide, including those around a colliding vertex or "
           "edge.\n\nhierarchy: of the object. Error: another mesh than was checked.");
}

void bind_answers(py::module_& module) {
  py::class_<StepAnswer> step(
      module, "StepResult",
      "Answer of a step: every pair that touches, sorted by ids. Its arrays are views "
      "that keep it alive.");
  bind_answer(step);
  step.def_property_readonly(
          "vertex_face",
          [](const py::object& self) { return view_of(self.cast<const StepAnswer&>().vertex_face, self); },
          "Structured array: vertex_object, vertex, face_object, face (ids), toi (in [0, 1] of the step; the "
          "pair does not touch before), answer (HIT or UNDECIDED).")
      .def_property_readonly(
          "edge_edge",
          [](const py::object& self) { return view_of(self.cast<const StepAnswer&>().edge_edge, self); },
          "Structured array: object_a, a (2 vertex ids), object_b, b (2 vertex ids), toi, answer.")
      .def_readonly("vertex_face_count", &StepResult::vertex_face_count,
                    "The number of vertex-face pairs, listed (max_listed) or not.")
      .def_readonly("edge_edge_count", &StepResult::edge_edge_count, "The number of edge-edge pairs.")
      .def_readonly("tolerance", &StepResult::tolerance, "The tolerance used, mesh units.")
      .def_readonly("search_steps", &StepResult::search_steps,
                    "How many steps the search of this step covers, this one included; 0: an earlier search "
                    "covered it.")
      .def_readonly("earliest_toi", &StepResult::earliest_toi, "In [0, 1]; 1 when nothing collides.");
  py::class_<StaticAnswer> pose(module, "StaticResult",
                                "Answer for one pose: every two triangles that cross.");
  bind_answer(pose);
  pose.def_property_readonly(
          "crossings",
          [](const py::object& self) { return view_of(self.cast<const StaticAnswer&>().crossings, self); },
          "Structured array: object_a, triangle_a, object_b, triangle_b.")
      .def_readonly("crossing_count", &StaticResult::crossing_count,
                    "The number of crossings, listed (max_listed) or not.");
}

}  // namespace

std::vector<Object> objects_of(const py::object& objects,
                               std::vector<std::shared_ptr<const foldproof::Model>>* models) {
  std::vector<Object> all;
  for (const auto& object : items_of(objects)) {
    if (py::isinstance<Model>(object)) {
      const auto model = object.cast<std::shared_ptr<Model>>();
      all.push_back(model->object());
      if (models != nullptr) models->push_back(model);
    } else if (py::isinstance<Hierarchy>(object)) {
      all.emplace_back(std::shared_ptr<const Hierarchy>(object.cast<std::shared_ptr<Hierarchy>>()));
      if (models != nullptr) models->push_back(nullptr);
    } else if (py::isinstance<CollisionMesh>(object)) {
      all.emplace_back(object.cast<std::shared_ptr<CollisionMesh>>()->hierarchy());
      if (models != nullptr) models->push_back(nullptr);
    } else {
      throw py::type_error("objects: expected a foldproof.Hierarchy or a foldproof.Model, or a list of them");
    }
  }
  if (all.empty()) refuse("objects", "are none", "give at least one");
  return all;
}

Pose pose_of(const py::object& x, const char* what, const std::vector<Object>& objects) {
  const py::list items = items_of(x);
  if (items.size() != objects.size()) {
    refuse(
        what,
        "has " + std::to_string(items.size()) + " arrays for " + std::to_string(objects.size()) + " objects",
        "give a list with one array V x 3 per object");
  }
  Pose pose;
  for (std::size_t k = 0; k < items.size(); ++k) {
    const Index vertices = objects[k].hierarchy()->topology().vertex_count();
    const std::string layout = "V x 3 with V = " + std::to_string(vertices);
    pose.arrays.push_back(numbers_of(items[k], what, {vertices, 3}, layout.c_str()));
    pose.spans.push_back(span_of(pose.arrays.back()));
  }
  return pose;
}

void register_collision_types() {
  PYBIND11_NUMPY_DTYPE(VertexFaceCollision, vertex_object, vertex, face_object, face, toi, answer);
  PYBIND11_NUMPY_DTYPE(EdgeEdgeCollision, object_a, a, object_b, b, toi, answer);
  PYBIND11_NUMPY_DTYPE(TriangleCrossing, object_a, triangle_a, object_b, triangle_b);
}

void bind_steps(py::module_& module) {
  register_collision_types();
  module.attr("HIT") = static_cast<int>(Answer::Hit);
  module.attr("UNDECIDED") = static_cast<int>(Answer::Undecided);
  py::tuple reasons(kReasonNames.size());
  for (std::size_t k = 0; k < kReasonNames.size(); ++k) reasons[k] = kReasonNames[k];
  module.attr("REASONS") = reasons;
  bind_answers(module);
  py::class_<Checker>(module, "StepChecker",
                      "Checks a fixed set of objects step by step, reusing results of earlier steps.\n\n"
                      "Calls of one checker wait for each other; use one checker per thread.")
      .def(py::init(&make_checker), py::arg("objects"), py::kw_only(), py::arg("filter") = py::none(),
           "objects: a Hierarchy, a Model (its certificates are used from the first step on), or a list of "
           "them. filter: a PairFilter for them, of pairs that are not tested.")
      .def(
          "check", &check, py::arg("x0"), py::arg("x1"),
          with_settings(
              "Every vertex-face and edge-edge pair that collides while all vertices move along "
              "straight lines from x0 to x1. No pair that touches is missing.\n\n"
              "x0, x1: V x 3 in mesh units, or a list of one array per object; float64 in C order is used in "
              "place. Error: wrong shapes, numbers that are not finite.")
              .c_str())
      .def("check_static", &check_static, py::arg("x"),
           "Every two triangles that cross in the pose x (as in check), decided exactly.\n\n"
           "settings: within, between, certificates, max_listed, explain, and mode ('paper' can miss "
           "crossings). Error: as in check.");
}

}  // namespace foldproof::python
