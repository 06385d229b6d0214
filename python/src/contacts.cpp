#include "contacts.h"

#include <pybind11/stl.h>

#include <cmath>
#include <limits>
#include <mutex>
#include <optional>
#include <unordered_map>

#include "arrays.h"
#include "filters.h"
#include "module.h"
#include "steps.h"
#include "unlocked.h"

namespace foldproof::python {
namespace {

/// ContactFrame with NaN for what there is not.
struct FrameRow {
  double time;
  std::uint64_t crossings, triangles;
  double curve_length;
  bool closed;
  std::array<double, 2> area;
  double depth;
  bool at_least, touching;
};

double number_or_nan(const std::optional<double>& value) {
  return value.value_or(std::numeric_limits<double>::quiet_NaN());
}

py::object none_or(const std::optional<double>& value) {
  return value ? py::object(py::float_(*value)) : py::none();
}

py::array frame_array(const Contact& contact) {
  std::vector<FrameRow> rows;
  rows.reserve(contact.frames.size());
  for (const ContactFrame& f : contact.frames) {
    rows.push_back({f.time,
                    f.crossings,
                    f.triangles,
                    f.curve_length,
                    f.closed,
                    {number_or_nan(f.area[0]), number_or_nan(f.area[1])},
                    number_or_nan(f.depth),
                    f.at_least,
                    f.touching});
  }
  return owned_rows(std::move(rows));
}

py::array points_of(const std::vector<Vec3>& points) {
  std::vector<double> numbers;
  for (const Vec3& point : points) numbers.insert(numbers.end(), point.begin(), point.end());
  return owned(std::move(numbers), {static_cast<py::ssize_t>(points.size()), 3});
}

py::array array_of(const Vec3& v) { return owned({v.begin(), v.end()}, {3}); }

/// Finds contacts frame by frame. Keeps the last frame, since callers may reuse their arrays.
class Finder {
 public:
  Finder(const py::object& objects, const py::object& parts, const py::object& filter,
         const Settings& settings)
      : objects_(objects_of(objects)),
        settings_(settings.step),
        checker_(objects_, filter_for(filter, objects_)) {
    if (settings.paper_miss_rate || settings_.earliest_only)
      refuse("settings", "do not ask for all collisions", "omit mode='paper' and earliest_only");
    std::vector<const Topology*> topologies;
    std::vector<std::size_t> triangles;
    for (const Object& object : objects_) {
      topologies.push_back(&object.hierarchy()->topology());
      triangles.push_back(topologies.back()->triangles().size());
    }
    parts_ = parts_of(parts, objects, triangles);
    Parts of_triangles;
    for (const ObjectParts& each : parts_) of_triangles.emplace_back(each.of_triangle);
    finder_.emplace(take(
        ContactFinder::make(std::move(topologies), std::move(of_triangles), filter_for(filter, objects_))));
  }

  py::list add(const py::object& x, std::optional<double> time) {
    const Pose pose = pose_of(x, "x", objects_);
    std::vector<Contact> ended;
    {
      const Unlocked unlocked;
      const std::lock_guard lock(mutex_);
      require_open();
      ended = add_frame(pose.spans, time.value_or(time_ ? *time_ + 1 : 0));
    }
    return list_of(ended);
  }

  py::list finish() {
    std::vector<Contact> ended;
    {
      const Unlocked unlocked;
      const std::lock_guard lock(mutex_);
      require_open();
      ended = finder_->finish();
      finished_ = true;
    }
    return list_of(ended);
  }

  std::uint64_t unknown_frames() {
    const Unlocked unlocked;
    const std::lock_guard lock(mutex_);
    return unknown_frames_;
  }

  std::uint64_t unlisted_pairs() {
    const Unlocked unlocked;
    const std::lock_guard lock(mutex_);
    return unlisted_pairs_;
  }

  std::size_t open_count() {
    const Unlocked unlocked;
    const std::lock_guard lock(mutex_);
    return finished_ ? 0 : finder_->open_count();
  }

 private:
  void require_open() const {
    if (finished_) refuse("finder", "has finished", "make another for another motion");
  }

  std::vector<Contact> add_frame(Positions x, double time) {
    if (!std::isfinite(time)) refuse("time", "is not finite", "give a finite number");
    if (time_ && !(time > *time_))
      refuse("time", std::to_string(time) + " is not after the last frame's", "give frames in order");
    if (!time_) {
      take(checker_.check_static(x, settings_, crossings_));
      finder_->start(time, x, crossings_);
    } else {
      std::vector<std::span<const double>> last(last_.begin(), last_.end());
      take(checker_.check(last, x, settings_, step_));
      unlisted_pairs_ +=
          step_.vertex_face_count + step_.edge_edge_count - step_.vertex_face.size() - step_.edge_edge.size();
      const bool asks = !step_.lists_all() || !finder_->is_known();
      if (asks) take(checker_.check_static(x, settings_, crossings_));
      finder_->step(*time_, time, last, x, step_, asks ? &crossings_ : nullptr);
    }
    unknown_frames_ += !finder_->is_known();
    time_ = time;
    last_.resize(x.size());
    for (std::size_t i = 0; i < x.size(); ++i) last_[i].assign(x[i].begin(), x[i].end());
    return finder_->take_ended();
  }

  py::list list_of(const std::vector<Contact>& contacts) const {
    py::list list;
    for (const Contact& contact : contacts) list.append(contact_of(contact, names_of(contact)));
    return list;
  }

  std::array<std::string, 2> names_of(const Contact& contact) const {
    std::array<std::string, 2> names;
    for (std::size_t i = 0; i < 2; ++i) {
      const Contact::Side& side = contact.sides[i];
      names[i] = side.part == kNoIndex ? "object " + std::to_string(side.object)
                                       : parts_[side.object].names[side.part];
    }
    return names;
  }

  std::vector<Object> objects_;
  StepSettings settings_;
  StepChecker checker_;
  std::vector<ObjectParts> parts_;
  std::optional<ContactFinder> finder_;
  std::mutex mutex_;
  std::vector<std::vector<double>> last_;
  std::optional<double> time_;  // of last_
  std::uint64_t unknown_frames_ = 0, unlisted_pairs_ = 0;
  bool finished_ = false;
  StepResult step_;
  StaticResult crossings_;
};

}  // namespace

ObjectParts object_parts(const py::handle& names, std::size_t triangles, const std::string& where) {
  ObjectParts parts;
  if (names.is_none()) return parts;
  std::unordered_map<std::string, Index> known;
  for (const py::handle name : names) {
    const auto text = py::str(name).cast<std::string>();
    const auto [at, is_new] = known.try_emplace(text, static_cast<Index>(parts.names.size()));
    if (is_new) parts.names.push_back(text);
    parts.of_triangle.push_back(at->second);
  }
  if (parts.of_triangle.size() == triangles) return parts;
  refuse(where,
         "are " + std::to_string(parts.of_triangle.size()) + " names for " + std::to_string(triangles) +
             " triangles",
         "give one name per triangle");
}

std::vector<ObjectParts> parts_of(const py::object& parts, const py::object& owners,
                                  const std::vector<std::size_t>& triangles) {
  if (parts.is_none()) return {};
  const bool several = py::isinstance<py::list>(owners) || py::isinstance<py::tuple>(owners);
  const py::list entries = several ? py::list(parts) : py::list(py::make_tuple(parts));
  if (entries.size() != triangles.size()) {
    refuse("parts",
           "are of " + std::to_string(entries.size()) + " objects, not " + std::to_string(triangles.size()),
           "give a list with an entry per object: a name per triangle, or None");
  }
  std::vector<ObjectParts> all;
  for (std::size_t k = 0; k < entries.size(); ++k)
    all.push_back(object_parts(entries[k], triangles[k], "parts of object " + std::to_string(k)));
  return all;
}

py::object contact_of(const Contact& contact, const std::array<std::string, 2>& names) {
  const py::module_ module = py::module_::import("foldproof");
  py::list sides, curves;
  for (std::size_t i = 0; i < 2; ++i) {
    const Contact::Side& side = contact.sides[i];
    sides.append(module.attr("ContactSide")(side.object, text_of(names[i]), owned_rows(side.triangles),
                                            owned_rows(side.inside)));
  }
  for (const auto& curve : contact.curves) curves.append(points_of(curve));
  const bool crosses = !contact.frames.empty();
  py::dict fields;
  fields["number"] = contact.number;
  fields["joined"] = py::tuple(py::cast(contact.joined));
  fields["sides"] = py::tuple(sides);
  fields["folded"] = contact.folded;
  fields["pierces"] = contact.pierces;
  fields["from_start"] = contact.from_start;
  fields["healed"] = contact.healed;
  fields["first_time"] = contact.first_time;
  fields["last_time"] = contact.last_time;
  fields["pairs"] = contact.pairs;
  fields["depth"] = none_or(contact.depth());
  fields["at_least"] = contact.at_least();
  fields["touching"] = contact.touching();
  fields["worst"] = crosses ? py::object(py::float_(contact.frames[contact.worst].time)) : py::none();
  fields["point"] = array_of(contact.point);
  fields["box"] = points_of({contact.low, contact.high});
  fields["normal"] = array_of(contact.normal);
  fields["frames"] = frame_array(contact);
  fields["curves"] = py::tuple(curves);
  return module.attr("Contact")(**fields);
}

void bind_contacts(py::module_& module) {
  PYBIND11_NUMPY_DTYPE(FrameRow, time, crossings, triangles, curve_length, closed, area, depth, at_least,
                       touching);
  py::class_<Finder>(
      module, "ContactFinder",
      "Finds contacts while frames come, with memory for the meshes, one step and the contacts "
      "that have not ended.\n\nCalls of one finder wait for each other.")
      .def(py::init([](const py::object& objects, const py::object& parts, const py::object& filter,
                       const py::kwargs& settings) {
             return std::make_unique<Finder>(objects, parts, filter,
                                             settings_of(settings, {"parts", "filter"}));
           }),
           py::arg("objects"), py::kw_only(), py::arg("parts") = py::none(), py::arg("filter") = py::none(),
           "objects: a Hierarchy, a Model, or a list of them. parts: names for the sides, one per triangle; "
           "for a list of objects a list with an entry for each, which may be None. filter: as in "
           "StepChecker. settings: as in "
           "StepChecker.check, without mode and earliest_only.")
      .def(
          "add", &Finder::add, py::arg("x"), py::arg("time") = py::none(),
          "The next frame. Returns the contacts that have ended before it: a list of Contact.\n\n"
          "x: V x 3, mesh units, or a list of one array per object; it is copied. time: of this frame; None: "
          "one more than the last, from 0. Error: wrong shapes, numbers that are not finite, a time that is "
          "not after the last one.")
      .def("finish", &Finder::finish,
           "Ends the motion, and with it all contacts. Returns those that were open: a list of Contact.")
      .def_property_readonly("open_count", &Finder::open_count, "How many contacts have not ended.")
      .def_property_readonly(
          "unknown_frames", &Finder::unknown_frames,
          "Of how many frames so far it is not known what crosses, because it has more pairs "
          "than max_listed.")
      .def_property_readonly(
          "unlisted_pairs", &Finder::unlisted_pairs,
          "How many colliding pairs so far were not listed (max_listed), and are in no contact.");
}

}  // namespace foldproof::python
