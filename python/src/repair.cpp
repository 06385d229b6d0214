// Repair of motions.
#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <algorithm>

#include "arrays.h"
#include "contacts.h"
#include "long_call.h"
#include "models.h"
#include "module.h"
#include "motions.h"
#include "report/repair_motions.h"
#include "report/repair_report.h"

namespace foldproof::python {
namespace {

struct RepairedRow {
  double time, correction;
  bool late;
  RepairLimit limit;
};

py::list contacts_of(std::vector<Contact> contacts, Motions motions, const CheckSettings& settings) {
  std::ranges::sort(contacts, is_worse);
  py::list out;
  for (const Contact& contact : contacts)
    out.append(contact_of(contact, side_names(contact, motions, settings)));
  return out;
}

/// The fields of the Python class foldproof.RepairResult.
py::dict fields_of(const RepairedMotions& done, Motions motions, const RepairRequest& request) {
  const CheckSettings& settings = request.check;
  py::dict d;
  d["verdict"] = repair_verdict(motions, request, done.report).sentence.text();
  d["free"] = done.report.free;
  d["unchanged"] = done.report.unchanged;
  py::list repaired;
  for (Index i = 0; i < motions.size() && done.report.written; ++i)
    repaired.append(py::cast(std::make_shared<SharedMotion>(done.motion(i))));
  d["motions"] = repaired;
  std::vector<RepairedRow> rows;
  for (const RepairedFrame& f : done.report.frames) rows.push_back({f.time, f.correction, f.late, f.limit});
  d["frames"] = owned_rows(std::move(rows));
  d["falloff"] = done.report.falloff;
  d["clearance"] = done.report.clearance;
  d["before"] = contacts_of(done.report.before, motions, settings);
  d["remaining"] = contacts_of(done.report.remaining, motions, settings);
  d["left"] = contacts_of(done.report.left, motions, settings);
  d["among_fixed"] = contacts_of(done.report.among_fixed, motions, settings);
  d["unit"] = unit_of(motions, settings);
  return d;
}

}  // namespace

void bind_repair(py::module_& module) {
  PYBIND11_NUMPY_DTYPE(RepairedRow, time, correction, late, limit);
  const auto repair = [](const py::object& motions, double thickness, double falloff,
                         std::vector<std::string> fixed, std::vector<std::vector<Index>> fixed_vertices,
                         std::vector<std::string> only, std::vector<std::array<std::string, 2>> ignore,
                         std::vector<std::array<std::string, 2>> contacts, const py::object& frames,
                         std::vector<double> start, const py::object& models, bool single_precision,
                         bool calm, const py::object& progress) {
    const auto all = motions_of(motions);
    RepairRequest request;
    request.check.frames = frames_of(frames);
    request.check.step.thickness = thickness;
    request.check.ignore = std::move(ignore);
    request.check.models = models_of(models, all.size());
    request.repair.falloff = falloff;
    request.repair.start = std::move(start);
    request.repair.single_precision = single_precision;
    request.repair.calm = calm;
    request.fixed = std::move(fixed);
    request.only = std::move(only);
    request.fixed_vertices = std::move(fixed_vertices);
    request.between = std::move(contacts);
    std::optional<RepairedMotions> done;
    run_long(progress, [&](LongCall& call) {
      request.repair.interrupted = [cancel = call.cancel()] { return cancel->load(); };
      request.repair.progress = call.progress();
      done = take(repair_motions(all, request));
    });
    return fields_of(*done, all, request);
  };
  // foldproof.repair has the documentation.
  module.def("repair", repair, py::arg("motions"), py::kw_only(), py::arg("thickness"), py::arg("falloff"),
             py::arg("fixed"), py::arg("fixed_vertices"), py::arg("only"), py::arg("ignore"),
             py::arg("contacts"), py::arg("frames"), py::arg("start"), py::arg("models"),
             py::arg("single_precision"), py::arg("calm"), py::arg("progress"));
}

}  // namespace foldproof::python
