// Checks of whole motions.
#include "report/report.h"

#include "long_call.h"
#include "module.h"
#include "motions.h"
#include "steps.h"

namespace foldproof::python {
namespace {

struct StepRow {
  std::uint64_t number;
  Index frame, next_frame, substep;
  std::uint64_t vertex_face, edge_edge, crossings;
  double earliest_toi, milliseconds;
};
struct VertexFaceRow {
  std::uint64_t step;
  Index vertex_object, vertex, face_object, face;
  double toi;
  Answer answer;
};
struct EdgeEdgeRow {
  std::uint64_t step;
  Index object_a;
  Edge a;
  Index object_b;
  Edge b;
  double toi;
  Answer answer;
};
struct CrossingRow {
  std::uint64_t step;
  Index object_a, triangle_a, object_b, triangle_b;
};
struct StartCrossingRow {
  Index object_a, triangle_a, object_b, triangle_b;
};

/// The answer of a whole check.
struct CheckResult {
  CheckTotals totals;
  std::vector<StepRow> steps;
  std::vector<VertexFaceRow> vertex_face;
  std::vector<EdgeEdgeRow> edge_edge;
  std::vector<CrossingRow> crossings;
  std::vector<StartCrossingRow> start_crossings;
  bool poses = false;
};

/// Collects the answers of the steps.
class Collector final : public ReportWriter {
 public:
  Collector(CheckResult& into, bool pairs) : into_(into), pairs_(pairs) {}

  Result<void> start(const CheckedStep& pose) override {
    if (!pairs_) return {};
    for (const auto& c : pose.pose->crossings)
      into_.start_crossings.push_back({c.object_a, c.triangle_a, c.object_b, c.triangle_b});
    return {};
  }
  Result<void> step(const CheckedStep& s) override {
    const std::uint64_t n = s.index.number;
    into_.steps.push_back({n, s.index.frame, s.index.next_frame, s.index.substep, s.collisions.vertex_face,
                           s.collisions.edge_edge, s.collisions.triangle_triangle, s.earliest_toi,
                           s.milliseconds.total});
    if (!pairs_) return {};
    if (s.step != nullptr) {
      for (const auto& c : s.step->vertex_face)
        into_.vertex_face.push_back({n, c.vertex_object, c.vertex, c.face_object, c.face, c.toi, c.answer});
      for (const auto& c : s.step->edge_edge)
        into_.edge_edge.push_back({n, c.object_a, c.a, c.object_b, c.b, c.toi, c.answer});
    } else {
      for (const auto& c : s.pose->crossings)
        into_.crossings.push_back({n, c.object_a, c.triangle_a, c.object_b, c.triangle_b});
    }
    return {};
  }
  Result<void> finish(const CheckTotals&) override { return {}; }

 private:
  CheckResult& into_;
  bool pairs_;
};

/// The arguments of a check, converted from Python.
struct Request {
  std::vector<std::unique_ptr<Motion>> motions;
  CheckSettings settings;
  std::vector<std::string> reports;
  bool keep;
};

void add_models(const py::object& models, Request& request) {
  if (models.is_none()) return;
  for (const auto& model : items_of(models)) {
    if (!model.is_none() && !py::isinstance<Model>(model))
      throw py::type_error("models: expected a foldproof.Model or None, or a list with one per motion");
    request.settings.models.push_back(model.is_none() ? nullptr : model.cast<std::shared_ptr<Model>>());
  }
  if (request.settings.models.size() != request.motions.size()) {
    refuse("models",
           "are " + std::to_string(request.settings.models.size()) + " for " +
               std::to_string(request.motions.size()) + " motions",
           "give one per motion, or None for motions without one");
  }
}

std::vector<std::unique_ptr<ReportWriter>> writers_of(const Request& request) {
  std::vector<std::unique_ptr<ReportWriter>> writers;
  for (const std::string& path : request.reports) {
    const std::string extension = extension_of(path);
    if (extension == ".json") {
      writers.push_back(take(
          json_report(path, request.motions, {.settings = request.settings, .read = {}, .pairs = true})));
    } else if (extension == ".csv") {
      writers.push_back(take(csv_report(path)));
    } else if (extension == ".ply") {
      writers.push_back(take(ply_report(path, request.motions, request.settings)));
    } else {
      refuse(path, "is not a known kind of report", "give .json, .csv or .ply");
    }
  }
  return writers;
}

std::unique_ptr<CheckResult> run(const Request& request, const py::object& progress) {
  auto result = std::make_unique<CheckResult>();
  result->poses = request.settings.poses;
  run_long(progress, [&](LongCall& call) {
    auto writers = writers_of(request);
    writers.push_back(std::make_unique<Collector>(*result, request.keep));
    CheckHooks hooks;
    hooks.cancel = call.cancel();
    hooks.progress = [report = call.progress()](const CheckTotals& totals, std::uint64_t steps) {
      report(static_cast<double>(totals.steps) / static_cast<double>(steps));
    };
    result->totals = take(run_check(request.motions, request.settings, writers, hooks));
  });
  return result;
}

template <class Row>
auto rows(std::vector<Row> CheckResult::*member) {
  return [member](const py::object& self) { return view_of(self.cast<const CheckResult&>().*member, self); };
}

/// "12 collisions in 3 of 32 steps; frame 0 starts with 4 crossing pairs of triangles"
std::string text_of(const CheckResult& result) {
  const CheckTotals& totals = result.totals;
  const auto many = [](std::uint64_t count, const char* noun) {
    return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
  };
  std::string text = many(totals.collisions.sum(), "collision") + " in " +
                     std::to_string(totals.steps_with_collisions) + " of " +
                     many(totals.steps, result.poses ? "frame" : "step");
  if (result.poses) return text;
  const std::string frame = "; frame " + std::to_string(totals.first_frame);
  if (!totals.starts_crossing) return text + frame + " was not tested for crossings";
  return text + frame + " starts with " + many(*totals.starts_crossing, "crossing pair") + " of triangles";
}

void bind_result(py::module_& module) {
  py::class_<CheckResult>(module, "CheckResult",
                          "Answer of a whole check. Its arrays are views that keep it alive.")
      .def_property_readonly(
          "clean", [](const CheckResult& r) { return r.totals.clean(); },
          "Whether no triangles cross in the first frame and nothing collides in any step, so that nothing "
          "intersects at any time. With steps_only or static, only what they test counts.")
      .def("__repr__", [](const CheckResult& r) { return "<foldproof.CheckResult: " + text_of(r) + ">"; })
      .def_property_readonly(
          "starts_crossing",
          [](const CheckResult& r) -> py::object {
            if (!r.totals.starts_crossing) return py::none();
            return py::int_(*r.totals.starts_crossing);
          },
          "The number of pairs of triangles that cross in the first frame, exact; None with steps_only or "
          "static, which do not test it.")
      .def_property_readonly("start_crossings", rows(&CheckResult::start_crossings),
                             "These pairs, as StaticResult.crossings; empty with keep=False.")
      .def_property_readonly(
          "steps", rows(&CheckResult::steps),
          "Structured array, a row per step: number, frame, next_frame, substep; vertex_face, "
          "edge_edge, crossings (how many); earliest_toi (in [0, 1], 1 when nothing collides), "
          "milliseconds.")
      .def_property_readonly(
          "vertex_face", rows(&CheckResult::vertex_face),
          "As StepResult.vertex_face, with the step's number in front; empty with keep=False.")
      .def_property_readonly(
          "edge_edge", rows(&CheckResult::edge_edge),
          "As StepResult.edge_edge, with the step's number in front; empty with keep=False.")
      .def_property_readonly(
          "crossings", rows(&CheckResult::crossings),
          "As StaticResult.crossings, with the step's number in front; empty with keep=False.")
      .def_property_readonly(
          "collisions", [](const CheckResult& r) { return r.totals.collisions.sum(); },
          "The number of colliding pairs, over all steps.")
      .def_property_readonly(
          "missed", [](const CheckResult& r) { return r.totals.missed; },
          "Mode 'paper': collisions of the proven answer that it misses, over all steps.")
      .def_property_readonly(
          "tolerance", [](const CheckResult& r) { return r.totals.tolerance; },
          "The largest tolerance of a step, mesh units.")
      .def_property_readonly(
          "work", [](const CheckResult& r) { return work_of(r.totals.work); },
          "Sums over the steps, as StepResult.work.")
      .def_property_readonly(
          "milliseconds", [](const CheckResult& r) { return milliseconds_of(r.totals.milliseconds); },
          "Sums over the steps, as StepResult.milliseconds.");
}

}  // namespace

void bind_checks(py::module_& module) {
  PYBIND11_NUMPY_DTYPE(StepRow, number, frame, next_frame, substep, vertex_face, edge_edge, crossings,
                       earliest_toi, milliseconds);
  PYBIND11_NUMPY_DTYPE(VertexFaceRow, step, vertex_object, vertex, face_object, face, toi, answer);
  PYBIND11_NUMPY_DTYPE(EdgeEdgeRow, step, object_a, a, object_b, b, toi, answer);
  PYBIND11_NUMPY_DTYPE(CrossingRow, step, object_a, triangle_a, object_b, triangle_b);
  PYBIND11_NUMPY_DTYPE(StartCrossingRow, object_a, triangle_a, object_b, triangle_b);
  bind_result(module);
  const auto check = [](const py::object& motions, const py::object& models, const py::object& frames,
                        bool poses, bool steps_only, Index substeps, bool keep, const py::object& reports,
                        const py::object& progress, const py::kwargs& settings) {
    Request request{motions_of(motions), {}, {}, keep};
    add_models(models, request);
    request.settings.frames = frames_of(frames);
    request.settings.poses = poses;
    if (poses && steps_only) refuse("steps_only", "does not go with static", "omit one of them");
    request.settings.steps_only = steps_only;
    request.settings.substeps = substeps;
    request.settings.step = step_settings(settings);
    for (const auto& path : items_of(reports)) request.reports.push_back(path_of(path));
    return run(request, progress);
  };
  module.def(
      "check", check, py::arg("motions"), py::kw_only(), py::arg("models") = py::none(),
      py::arg("frames") = py::none(), py::arg("static") = false, py::arg("steps_only") = false,
      py::arg("substeps") = 1, py::arg("keep") = true, py::arg("reports") = py::tuple(),
      py::arg("progress") = py::none(),
      with_settings(
          "Checks a Motion, or several that move together (a list): the triangles that cross in the first "
          "frame, then every step. No pair that touches is missing.\n\n"
          "models: a Model, or a list with one per motion (None for motions without one). frames: a slice, "
          "'A:B:STEP' or None for all. static: find the triangles that cross in each frame, instead of "
          "collisions in steps. steps_only: do not test the first frame for crossings. substeps: linear "
          "parts that a step is divided into. keep: keep every colliding pair (some 40 bytes each); else "
          "only counts. reports: path or paths to write, .json, .csv or .ply, which appear complete or not "
          "at all. progress: called with the share that is done. Ctrl-C cancels it. Error: motions that do "
          "not fit together, frames that cannot be read, a report that cannot be written.")
          .c_str());
}

}  // namespace foldproof::python
