// Checks of whole motions.
#include "report/report.h"

#include <pybind11/stl.h>

#include <algorithm>
#include <set>

#include "contacts.h"
#include "io/named_files.h"
#include "io/numbered.h"
#include "long_call.h"
#include "models.h"
#include "module.h"
#include "motions.h"
#include "report/assumed.h"
#include "report/verdict.h"
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

/// The answer of a whole check, before it becomes Python's.
struct Found {
  CheckTotals totals;
  std::vector<StepRow> steps;
  std::vector<VertexFaceRow> vertex_face;
  std::vector<EdgeEdgeRow> edge_edge;
  std::vector<CrossingRow> crossings;
  std::vector<StartCrossingRow> start_crossings;
};

/// Collects the answers of the steps. Before the other writers, so that reports appear only if the caller has
/// not cancelled until then.
class Collector final : public ReportWriter {
 public:
  Collector(Found& into, bool pairs, LongCall& call) : into_(into), pairs_(pairs), call_(call) {}

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
  Result<void> finish(const CheckTotals&) override {
    if (call_.commit()) return {};
    return fail(ErrorCode::Interrupted, "cancelled", "the check was ended", "no report was written");
  }

 private:
  Found& into_;
  bool pairs_;
  LongCall& call_;
};

/// The arguments of a check, converted from Python.
struct Request {
  std::vector<std::unique_ptr<Motion>> motions;
  CheckSettings settings;
  std::vector<std::string> reports;
  bool keep;
};

/// Of the first motion; `weld`: of the first that differs from the default.
ReadOptions read_options(const Request& request) {
  const auto read_of = [](const auto& motion) { return static_cast<const SharedMotion&>(*motion).read(); };
  ReadOptions read;
  if (!request.motions.empty()) read = read_of(request.motions.front());
  for (const auto& motion : request.motions) {
    if (read.weld == Weld::ByFormat) read.weld = read_of(motion).weld;
  }
  return read;
}

/// Pairs of names from a list of tuples.
std::vector<std::array<std::string, 2>> name_pairs(const py::object& pairs) {
  std::vector<std::array<std::string, 2>> out;
  for (const auto& pair : pairs) {
    if (py::isinstance<py::str>(pair) || !py::isinstance<py::sequence>(pair) || py::len(pair) != 2)
      throw py::type_error("ignore: expected a list of pairs of names, such as [('coat', 'body')]");
    const auto names = py::reinterpret_borrow<py::sequence>(pair);
    out.push_back({names[0].cast<std::string>(), names[1].cast<std::string>()});
  }
  return out;
}

/// Refused: settings without effect on the poses of frames, and, as by the program, what does not go with a
/// statistical answer.
void require_kind_fits(const Request& request) {
  const CheckSettings& settings = request.settings;
  const StepSettings& step = settings.step;
  if (settings.poses) {
    refuse_given("static", {{"steps_only", settings.steps_only}, {"substeps", settings.substeps != 1}});
    require_static_fits("static", step);
  }
  if (!settings.paper_miss_rate) return;
  refuse_given("mode='paper'", {{"explain", step.explain},
                                {"earliest_only", step.earliest_only},
                                {"certificates=False", !step.certificates}});
  for (const std::string& report : request.reports) {
    if (extension_of(report) != ".json")
      refuse(report, "does not go with mode='paper'", "write .json, which labels its answer as statistical");
  }
}

/// All files that a report replaces or may write; the first has its name.
std::vector<std::string> files_of_report(const std::string& path) {
  std::vector<std::string> files{path};
  const auto pattern = io::number_pattern(path);
  if (!pattern || extension_of(path) != ".ply") return files;
  std::error_code ignored;
  files = io::numbered_files(*pattern, ignored);
  files.insert(files.begin(), pattern->name(0));
  return files;
}

/// Whether a report, which may have a number in its name, may write the file of another.
bool writes_file_of(const std::string& report, const std::string& other) {
  const std::string name = io::canonical(report), file = io::canonical(files_of_report(other)[0]);
  const auto pattern = io::number_pattern(name);
  return name == file || (pattern && extension_of(report) == ".ply" && io::is_numbered(file, *pattern));
}

/// Refused: reports that would replace each other or what the motions are read from, or become a part of it.
void require_reports_apart(const Request& request) {
  std::set<std::string> inputs;
  for (const auto& motion : request.motions) {
    const auto& paths = static_cast<const SharedMotion&>(*motion).paths();
    inputs.insert(paths.begin(), paths.end());
  }
  std::set<io::FileId> read;
  for (const std::string& input : inputs) {
    for (const auto& file : io::files_of(input)) {
      if (const auto id = io::file_id(file)) read.insert(*id);
    }
  }
  for (std::size_t i = 0; i < request.reports.size(); ++i) {
    const std::string& report = request.reports[i];
    const auto files = files_of_report(report);
    for (const std::string& file : files) {
      const auto id = io::file_id(file);
      if (id && read.contains(*id))
        refuse(report, "would write over '" + file + "', which is read", "name another file to write");
    }
    for (const std::string& other : std::span(request.reports).first(i)) {
      if (writes_file_of(report, other) || writes_file_of(other, report))
        refuse(report, "is named for two reports", "give each its own file");
    }
    for (const std::string& input : inputs) {
      if (io::will_read(input, files[0]))
        refuse(report, "would be a frame of what is read ('" + input + "')", "name a file elsewhere");
    }
  }
}

std::vector<std::unique_ptr<ReportWriter>> writers_of(const Request& request) {
  std::vector<std::unique_ptr<ReportWriter>> writers;
  for (const std::string& path : request.reports) {
    const std::string extension = extension_of(path);
    if (extension == ".json") {
      writers.push_back(
          take(json_report(path, request.motions,
                           {.settings = request.settings, .read = read_options(request), .pairs = true})));
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

std::vector<std::size_t> triangle_counts(const std::vector<std::unique_ptr<Motion>>& motions) {
  std::vector<std::size_t> counts;
  counts.reserve(motions.size());
  for (const auto& motion : motions) counts.push_back(motion->topology().triangles().size());
  return counts;
}

Found run(const Request& request, const py::object& progress) {
  Found found;
  run_long(progress, [&](LongCall& call) {
    auto writers = writers_of(request);
    writers.insert(writers.begin(), std::make_unique<Collector>(found, request.keep, call));
    CheckHooks hooks;
    hooks.cancel = call.cancel();
    hooks.progress = [report = call.progress()](const CheckTotals& totals, std::uint64_t steps) {
      report(static_cast<double>(totals.steps) / static_cast<double>(steps));
    };
    found.totals = take(run_check(request.motions, request.settings, writers, hooks));
  });
  return found;
}

/// Colliding pairs of steps that are in no contact, since they are not listed.
std::uint64_t unlisted_pairs(const Request& request, const CheckTotals& totals) {
  if (!totals.contacts_found || request.settings.poses) return 0;
  return totals.collisions.sum() - totals.listed.sum();
}

/// What the check left out, a sentence each.
py::list untested_by(const Request& request, const CheckTotals& totals) {
  const CheckSettings& settings = request.settings;
  py::list untested;
  for (const std::string& part : foldproof::untested(request.motions, settings, totals))
    untested.append(message_of(part));
  if (const std::string still = still_pairs(request.motions, settings, totals); !still.empty())
    untested.append(message_of(still));
  if (settings.poses) untested.append("motion between frames was not tested");
  if (settings.step.earliest_only) untested.append("only the earliest pair of each step was looked for");
  const std::uint64_t found = totals.collisions.sum(), unlisted = unlisted_pairs(request, totals);
  if (unlisted > 0) {
    untested.append("contacts join only the " + std::to_string(found - unlisted) + " of " +
                    std::to_string(found) + " colliding pairs that are listed (max_listed)");
  }
  if (totals.contact_unknown_frames > 0 && !settings.steps_only) {
    untested.append("what crosses is not known in frames with more pairs than max_listed: " +
                    std::to_string(totals.contact_unknown_frames));
  }
  return untested;
}

/// The fields of the Python class foldproof.CheckResult.
py::dict fields_of(Found found, const Request& request) {
  const CheckTotals& totals = found.totals;
  py::dict d;
  d["clean"] = totals.clean();
  d["first_frame"] = totals.first_frame;
  py::list notes;
  for (const auto& [object, text] : totals.notices)
    notes.append(text_of(request.motions[object]->name() + ": ") + message_of(text));
  for (const auto& motion : request.motions) {
    for (const std::string& note : motion->info().notes)
      notes.append(text_of(motion->name() + ": ") + message_of(note));
  }
  d["notes"] = notes;
  d["verdict"] = message_of(verdict(request.motions, request.settings, totals).sentence.text());
  d["untested"] = untested_by(request, totals);
  d["assumed"] = message_of(assumed(request.motions, request.settings.poses));
  d["statistical"] = request.settings.paper_miss_rate.has_value();
  d["starts_crossing"] = totals.starts_crossing;
  d["still_crossing"] = totals.still_crossing;
  d["start_crossings"] = owned_rows(std::move(found.start_crossings));
  d["steps"] = owned_rows(std::move(found.steps));
  d["vertex_face"] = owned_rows(std::move(found.vertex_face));
  d["edge_edge"] = owned_rows(std::move(found.edge_edge));
  d["crossings"] = owned_rows(std::move(found.crossings));
  d["collisions"] = totals.collisions.sum();
  d["missed"] = totals.missed;
  d["tolerance"] = totals.tolerance;
  d["work"] = work_of(totals.work);
  d["milliseconds"] = milliseconds_of(totals.milliseconds);
  py::list contacts;
  for (const Contact& contact : totals.contacts)
    contacts.append(contact_of(contact, side_names(contact, request.motions, request.settings)));
  d["contacts"] = totals.contacts_found ? py::object(contacts) : py::none();
  d["unit"] = unit_of(request.motions, request.settings);
  d["unknown_frames"] = totals.contact_unknown_frames;
  d["unlisted_pairs"] = unlisted_pairs(request, totals);
  return d;
}

}  // namespace

void bind_checks(py::module_& module) {
  PYBIND11_NUMPY_DTYPE(StepRow, number, frame, next_frame, substep, vertex_face, edge_edge, crossings,
                       earliest_toi, milliseconds);
  PYBIND11_NUMPY_DTYPE(VertexFaceRow, step, vertex_object, vertex, face_object, face, toi, answer);
  PYBIND11_NUMPY_DTYPE(EdgeEdgeRow, step, object_a, a, object_b, b, toi, answer);
  PYBIND11_NUMPY_DTYPE(CrossingRow, step, object_a, triangle_a, object_b, triangle_b);
  PYBIND11_NUMPY_DTYPE(StartCrossingRow, object_a, triangle_a, object_b, triangle_b);
  const auto check = [](const py::object& motions, const py::object& models, const py::object& frames,
                        bool poses, bool steps_only, const py::object& substeps, bool keep, bool contacts,
                        const py::object& parts, const std::string& unit, const py::object& reports,
                        const py::object& ignore, bool still_pairs, const py::object& progress,
                        const py::kwargs& settings) {
    Request request{motions_of(motions), {}, {}, keep};
    request.settings.models = models_of(models, request.motions.size());
    request.settings.frames = frames_of(frames);
    request.settings.poses = poses;
    request.settings.steps_only = steps_only;
    request.settings.substeps = static_cast<Index>(whole_number(substeps, "substeps", 1));
    request.settings.contacts = contacts;
    request.settings.parts = parts_of(parts, motions, triangle_counts(request.motions));
    request.settings.unit = unit;
    request.settings.ignore = name_pairs(ignore);
    request.settings.still_pairs = still_pairs;
    const Settings asked =
        settings_of(settings, {"models", "frames", "static", "steps_only", "substeps", "keep", "contacts",
                               "parts", "unit", "reports", "ignore", "still_pairs", "progress"});
    request.settings.step = asked.step;
    request.settings.paper_miss_rate = asked.paper_miss_rate;
    for (const auto& path : items_of(reports)) request.reports.push_back(path_of(path));
    require_kind_fits(request);
    require_reports_apart(request);
    return fields_of(run(request, progress), request);
  };
  // foldproof.check has the documentation.
  module.attr("SETTINGS") = settings_documentation();
  module.def("check", check, py::arg("motions"), py::kw_only(), py::arg("models"), py::arg("frames"),
             py::arg("static"), py::arg("steps_only"), py::arg("substeps"), py::arg("keep"),
             py::arg("contacts"), py::arg("parts"), py::arg("unit"), py::arg("reports"), py::arg("ignore"),
             py::arg("still_pairs"), py::arg("progress"));
}

}  // namespace foldproof::python
