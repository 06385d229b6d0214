#include "motions.h"

#include <pybind11/stl.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numeric>
#include <optional>

#include "arrays.h"
#include "contacts.h"
#include "io/readers.h"
#include "module.h"
#include "unlocked.h"

namespace foldproof::python {
namespace {

/// A motion whose frames are an array of the caller, used in place.
class ArrayMotion final : public Motion {
 public:
  ArrayMotion(std::string name, Topology topology, Numbers frames, MotionInfo info)
      : name_(std::move(name)),
        topology_(std::move(topology)),
        frames_(std::move(frames)),
        info_(std::move(info)) {
    positions_ = span_of(frames_);
  }
  const std::string& name() const override { return name_; }
  const Topology& topology() const override { return topology_; }
  const MotionInfo& info() const override { return info_; }
  Index frame_count() const override {
    return static_cast<Index>(positions_.size() / topology_.vertex_count() / 3);
  }
  // Called without Python's lock: touches no Python object.
  Result<void> read_frame(Index k, std::span<double> out) override {
    const auto frame = positions_.subspan(k * out.size(), out.size());
    std::copy(frame.begin(), frame.end(), out.begin());
    const auto bad = std::find_if(out.begin(), out.end(), [](double x) { return !std::isfinite(x); });
    if (bad == out.end()) return {};
    return fail(
        ErrorCode::NonFinite,
        name_ + ", frame " + std::to_string(k) + ", vertex " + std::to_string((bad - out.begin()) / 3),
        "a coordinate is not finite", "give finite numbers");
  }

 private:
  std::string name_;
  Topology topology_;
  Numbers frames_;
  MotionInfo info_;
  std::span<const double> positions_;
};

/// Some frames of another motion.
class SlicedMotion final : public Motion {
 public:
  SlicedMotion(SharedMotion whole, py::ssize_t begin, py::ssize_t step, py::ssize_t count)
      : whole_(std::move(whole)), begin_(begin), step_(step), count_(count) {}
  const std::string& name() const override { return whole_.name(); }
  const Topology& topology() const override { return whole_.topology(); }
  const MotionInfo& info() const override { return whole_.info(); }
  Index frame_count() const override { return static_cast<Index>(count_); }
  Result<void> read_frame(Index k, std::span<double> out) override {
    return whole_.read_frame(static_cast<Index>(begin_ + static_cast<py::ssize_t>(k) * step_), out);
  }

 private:
  SharedMotion whole_;
  py::ssize_t begin_, step_, count_;
};

/// How many of the last triangles are lines (a, b, b), then points (p, p, p).
struct Codimensional {
  Index lines = 0, points = 0;
};

Topology topology_of(const py::handle& triangles, py::ssize_t vertex_count, const Codimensional& last) {
  std::vector<Triangle> faces = triangles_of(triangles);
  std::vector<Edge> lines;
  std::vector<Index> points;
  const std::size_t first_point = faces.size() - last.points, first_line = first_point - last.lines;
  for (std::size_t t = first_line; t < first_point; ++t) lines.push_back({faces[t][0], faces[t][1]});
  for (std::size_t t = first_point; t < faces.size(); ++t) points.push_back(faces[t][0]);
  faces.resize(first_line);
  return take(Topology::make(static_cast<Index>(vertex_count), std::move(faces), lines, points));
}

std::unique_ptr<Motion> motion_of_arrays(const py::handle& triangles, const py::handle& frames,
                                         std::string name, const py::object& parts, MotionInfo info,
                                         const Codimensional& last = {}) {
  py::object array = py::reinterpret_borrow<py::object>(frames);
  if (py::isinstance<py::array>(array) && array.attr("ndim").cast<int>() == 2)
    array = array[py::make_tuple(py::none(), py::ellipsis())];  // a single pose
  Numbers numbers = numbers_of(array, "frames", {-1, -1, 3}, "F x V x 3, or V x 3 for one");
  if (numbers.size() == 0) refuse("frames", "are empty", "give at least one frame of one vertex");
  require_finite(numbers, "frames");
  Topology topology = topology_of(triangles, numbers.shape(1), last);
  info.parts = object_parts(parts, topology.triangles().size(), "parts");
  return std::make_unique<ArrayMotion>(std::move(name), std::move(topology), std::move(numbers),
                                       std::move(info));
}

std::shared_ptr<SharedMotion> array_motion(const py::handle& triangles, const py::handle& frames,
                                           std::string name, const py::object& parts) {
  auto motion = motion_of_arrays(triangles, frames, std::move(name), parts, {});
  return std::make_shared<SharedMotion>(take(io::with_loose_vertices(std::move(motion), false)));
}

std::vector<std::shared_ptr<SharedMotion>> open_all(const py::args& paths, const ReadOptions& options) {
  std::vector<std::string> arguments;
  for (const auto& path : paths) arguments.push_back(path_of(path));
  if (!(options.fps > 0) || !std::isfinite(options.fps))
    refuse("fps", "is not a finite, positive number", "give another");
  std::vector<std::unique_ptr<Motion>> motions;
  {
    const Unlocked unlocked;
    motions = take(open_motions(arguments, options));
  }
  std::vector<std::shared_ptr<SharedMotion>> shared;
  shared.reserve(motions.size());
  for (std::string& path : arguments) path = std::filesystem::absolute(path).string();
  for (auto& motion : motions)
    shared.push_back(std::make_shared<SharedMotion>(std::move(motion), options, arguments));
  return shared;
}

/// None: by the format.
Weld weld_of(std::optional<bool> weld) {
  if (!weld) return Weld::ByFormat;
  return *weld ? Weld::Always : Weld::Never;
}

MeshFiles mesh_files_of(bool sequence, bool separate) {
  if (sequence && separate) refuse("sequence", "does not go with separate", "leave one of them out");
  return sequence ? MeshFiles::Sequence : separate ? MeshFiles::Separate : MeshFiles::ByName;
}

py::list open_list(const py::args& paths, double fps, std::optional<bool> weld, bool sequence, bool separate,
                   bool still, const std::string& clip, bool points) {
  py::list list;
  for (auto& motion : open_all(paths, {.fps = fps,
                                      .weld = weld_of(weld),
                                      .mesh_files = mesh_files_of(sequence, separate),
                                      .still = still,
                                      .points = points,
                                      .clip = clip}))
    list.append(std::move(motion));
  return list;
}

std::shared_ptr<SharedMotion> open_one(const py::args& paths, double fps, std::optional<bool> weld,
                                       bool sequence, const std::string& clip, bool points) {
  auto motions = open_all(paths, {.fps = fps,
                                  .weld = weld_of(weld),
                                  .mesh_files = mesh_files_of(sequence, false),
                                  .points = points,
                                  .clip = clip});
  if (motions.size() != 1)
    refuse("paths", "are " + std::to_string(motions.size()) + " motions",
           "give one, sequence=True if they are its frames, or use open_motions");
  return std::move(motions.front());
}

py::array read_frame(SharedMotion& motion, std::int64_t k) {
  const std::int64_t count = motion.frame_count();
  const std::int64_t frame = k < 0 ? k + count : k;
  if (frame < 0 || frame >= count) {
    throw py::index_error("frame " + std::to_string(k) + " of " + std::to_string(count));
  }
  const py::ssize_t vertices = motion.topology().vertex_count();
  std::vector<double> positions(static_cast<std::size_t>(vertices) * 3);
  {
    const Unlocked unlocked;
    take(motion.read_frame(static_cast<Index>(frame), positions));
  }
  return owned(std::move(positions), {vertices, 3});
}

py::object item_of(SharedMotion& motion, const py::object& index) {
  if (!PySlice_Check(index.ptr())) {
    const py::ssize_t frame = PyNumber_AsSsize_t(index.ptr(), PyExc_IndexError);
    if (frame == -1 && PyErr_Occurred() != nullptr) throw py::error_already_set();
    return read_frame(motion, frame);
  }
  py::ssize_t begin = 0, end = 0, step = 0, count = 0;
  const auto slice = index.cast<py::slice>();
  if (!slice.compute(motion.frame_count(), &begin, &end, &step, &count)) throw py::error_already_set();
  if (count == 0)
    refuse("slice", "selects none of " + std::to_string(motion.frame_count()) + " frames",
           "select at least one");
  return py::cast(std::make_shared<SharedMotion>(std::make_unique<SlicedMotion>(motion, begin, step, count),
                                                 motion.read(), motion.paths()));
}

py::array triangles_of_motion(const py::object& self) {
  const Topology& topology = self.cast<const SharedMotion&>().topology();
  return view_of(topology.triangles()[0].data(), {static_cast<py::ssize_t>(topology.triangles().size()), 3},
                 self);
}

py::object parts_of_motion(const SharedMotion& motion) {
  const ObjectParts& parts = motion.info().parts;
  if (parts.of_triangle.empty()) return py::none();
  py::list names;
  for (const std::string& name : parts.names) names.append(text_of(name));
  return py::array(names)[owned_rows(parts.of_triangle)];
}

/// `to_python`: text_of for names, which are given back; message_of for what people read.
template <class ToPython>
py::list list_of(const std::vector<std::string>& lines, const ToPython& to_python) {
  py::list list;
  for (const std::string& line : lines) list.append(to_python(line));
  return list;
}

py::array merged_of_motion(const SharedMotion& motion) {
  std::vector<Index> merged = motion.info().merged;
  if (merged.empty()) {
    merged.resize(motion.topology().vertex_count());
    std::iota(merged.begin(), merged.end(), Index{0});
  }
  return owned_rows(std::move(merged));
}

/// What pickle keeps: all frames, and how they were read.
py::tuple state_of(const py::object& self) {
  const auto& motion = self.cast<const SharedMotion&>();
  const ReadOptions& read = motion.read();
  const auto bytes_of = [](const std::vector<std::string>& texts) {
    py::list list;
    for (const std::string& text : texts) list.append(py::bytes(text));
    return list;
  };
  return py::make_tuple(triangles_of_motion(self), py::module_::import("numpy").attr("stack")(py::list(self)),
                        py::bytes(motion.name()), parts_of_motion(motion), py::bytes(motion.info().unit),
                        bytes_of(motion.info().notes), read.fps, static_cast<int>(read.weld),
                        static_cast<int>(read.mesh_files),
                        owned_rows(std::vector<Index>(motion.info().merged)), motion.info().layered,
                        py::bytes(motion.info().taken_as), bytes_of(motion.info().unchecked),
                        motion.topology().line_count(), motion.topology().point_count());
}

std::shared_ptr<SharedMotion> motion_of_state(const py::tuple& state) {
  if (state.size() != 15) refuse("motion", "was pickled by another version", "pickle it again");
  const auto merged = state[9].cast<py::array_t<Index>>();
  MotionInfo info{.unit = state[4].cast<std::string>(),
                  .notes = state[5].cast<std::vector<std::string>>(),
                  .taken_as = state[11].cast<std::string>(),
                  .unchecked = state[12].cast<std::vector<std::string>>(),
                  .merged = std::vector<Index>(merged.data(), merged.data() + merged.size()),
                  .layered = state[10].cast<bool>()};
  const ReadOptions read{.fps = state[6].cast<double>(),
                         .weld = static_cast<Weld>(state[7].cast<int>()),
                         .mesh_files = static_cast<MeshFiles>(state[8].cast<int>())};
  return std::make_shared<SharedMotion>(
      motion_of_arrays(state[0], state[1], state[2].cast<std::string>(), state[3], std::move(info),
                       {state[13].cast<Index>(), state[14].cast<Index>()}),
      read);
}

}  // namespace

std::vector<std::unique_ptr<Motion>> motions_of(const py::handle& motions) {
  std::vector<std::unique_ptr<Motion>> all;
  const auto add = [&](const py::handle& motion) {
    if (!py::isinstance<SharedMotion>(motion)) {
      throw py::type_error(
          "expected a foldproof.Motion, or a list of them; make one with Motion(triangles, "
          "frames) or open_motion(path)");
    }
    all.push_back(std::make_unique<SharedMotion>(motion.cast<const SharedMotion&>()));
  };
  if (py::isinstance<py::list>(motions) || py::isinstance<py::tuple>(motions)) {
    for (const auto& motion : motions) add(motion);
  } else {
    add(motions);
  }
  return all;
}

FrameRange frames_of(const py::handle& frames) {
  if (frames.is_none()) return {};
  if (py::isinstance<py::str>(frames)) return take(parse_frame_range(frames.cast<std::string>()));
  if (py::isinstance<py::int_>(frames)) return take(parse_frame_range(py::str(frames).cast<std::string>()));
  if (!PySlice_Check(frames.ptr())) throw py::type_error("frames: expected a slice, an int, a str or None");
  FrameRange range;
  const auto read = [&](const char* name) {
    const py::object end = frames.attr(name);
    return end.is_none() ? std::nullopt : std::optional(end.cast<std::int64_t>());
  };
  range.begin = read("start");
  range.end = read("stop");
  const std::int64_t step = read("step").value_or(1);
  if (step < 1 || step >= kNoIndex)
    refuse("frames", "have a step of " + std::to_string(step), "give 1 or more");
  range.step = static_cast<Index>(step);
  return range;
}

namespace {

void bind_files(py::module_& module) {
  module.def(
      "open_motion", &open_one, py::arg("fps") = 24.0, py::arg("weld") = py::none(),
      py::arg("sequence") = false, py::arg("clip") = "", py::arg("points") = false,
      "Opens one motion: a mesh (with .pc2 or .mdd); several meshes as a directory, a glob or a name "
      "with %d; glTF, GLB, NPZ, PVD; a pair of .npy.\n\n"
      "fps: sampling rate of animated glTF. weld: which vertices become one, in the triangles alone: "
      "None for the seams of glTF and STL, True for all that coincide in the first frame, False for none. "
      "sequence: several meshes are its frames, whatever their names and places are; without it, frames "
      "have names that differ in nothing but one number, and an Error asks where they look like bodies. "
      "clip: the animation of a glTF, one of Motion.clips, or 'animations[1]'; the longest without it. "
      "points: vertices in no face and no line are checked as points; without it they are in 'unchecked'. "
      "Error: as for the program (docs/formats.md).");
  module.def(
      "open_motions", &open_list, py::arg("fps") = 24.0, py::arg("weld") = py::none(),
      py::arg("sequence") = false, py::arg("separate") = false, py::arg("still") = false,
      py::arg("clip") = "", py::arg("points") = false,
      "Opens any number of motions: a list.\n\n"
      "separate: several mesh files are bodies, each a motion of its own, whatever their names are. still: "
      "motions of a single frame stand still as long as the longest of the others lasts, and files that are "
      "more or fewer than the others have frames are bodies. Otherwise as open_motion.");
  module.def(
      "write_motion",
      [](const py::object& path, SharedMotion& motion) {
        const std::string name = path_of(path);
        const Unlocked unlocked;
        take(write_motion(name, motion));
      },
      py::arg("path"), py::arg("motion"),
      "Writes .npz, .obj (with a .pc2 beside it for several frames) or .ply (one frame; with %d in the name, "
      "a file per frame).\n\n"
      "The file appears complete or not at all. Error: it cannot be written.");
}

using MotionClass = py::class_<SharedMotion, std::shared_ptr<SharedMotion>>;

void bind_properties(MotionClass& motion) {
  motion
      .def_property_readonly(
          "name", [](const SharedMotion& m) { return text_of(m.name()); },
          "For messages: the file, or 'array'.")
      .def_property_readonly("parts", &parts_of_motion,
                             "T names, the part of each triangle; None where the file names none.")
      .def_property_readonly(
          "unit", [](const SharedMotion& m) { return text_of(m.info().unit); },
          "What a mesh unit is, where the format defines it ('m' for glTF); else empty.")
      .def_property_readonly(
          "taken_as", [](const SharedMotion& m) { return message_of(m.info().taken_as); },
          "What its files were taken for, where they may mean something else: '3 frames of one mesh'; else "
          "empty.")
      .def_property_readonly(
          "clips", [](const SharedMotion& m) { return list_of(m.info().clips, text_of); },
          "Names of the file's animations, as open_motion(clip=) takes them; empty if it has none.")
      .def_property_readonly(
          "notes", [](const SharedMotion& m) { return list_of(m.info().notes, message_of); },
          "What the reader left out or assumed, a line each; empty if nothing.")
      .def_property_readonly(
          "merged", &merged_of_motion,
          "Per vertex, the one that triangles name in its place, uint32: itself, or the one "
          "that it was merged into.")
      .def_property_readonly(
          "unchecked", [](const SharedMotion& m) { return list_of(m.info().unchecked, message_of); },
          "What of it is not checked, a line each: '5 vertices in no face were not checked'.")
      .def_property_readonly("triangles", &triangles_of_motion,
                             "T x 3 vertex ids, uint32; read-only. The faces, then line_count lines as (a, "
                             "b, b), then point_count "
                             "points as (p, p, p).")
      .def_property_readonly(
          "line_count", [](const SharedMotion& m) { return m.topology().line_count(); },
          "How many lines in no face there are.")
      .def_property_readonly(
          "point_count", [](const SharedMotion& m) { return m.topology().point_count(); },
          "How many points there are, in no face and no line.")
      .def_property_readonly(
          "vertex_count", [](const SharedMotion& m) { return m.topology().vertex_count(); }, "V.");
}

}  // namespace

void bind_motions(py::module_& module) {
  MotionClass motion(
      module, "Motion",
      "Triangles, and positions of their vertices in every frame; frames are read on demand.\n\n"
      "motion[k] is frame k, motion[10:20] and motion[::2] are motions of these frames; iterating over a "
      "motion yields its frames. Motions are equal when triangles and positions are. Thread-safe.");
  motion
      .def(py::init(&array_motion), py::arg("triangles"), py::arg("frames"), py::arg("name") = "array",
           py::kw_only(), py::arg("parts") = py::none(),
           "From arrays: triangles T x 3 vertex ids (integers), frames F x V x 3 in mesh units.\n\n"
           "Float64 in C order is used in place, so do not change it while a call runs; everything else is "
           "converted once. One pose may be V x 3. parts: a name per triangle, for the sides of contacts. "
           "Error: "
           "other shapes, ids beyond V, numbers that are not finite.")
      .def(py::pickle(&state_of, &motion_of_state))
      .def("__len__", &SharedMotion::frame_count)
      .def("__getitem__", &item_of, py::arg("index"),
           "A frame: V x 3 float64, a new array, in mesh units; negative numbers count from the end. For a "
           "slice: a Motion of these frames, which are read on demand.\n\n"
           "Error: the frame cannot be read; the slice selects none. IndexError: the frame does not exist.");
  bind_properties(motion);
  bind_files(module);
}

}  // namespace foldproof::python
