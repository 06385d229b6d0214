// Models: training, files, and shapes from key points.
#include "models.h"

#include "arrays.h"
#include "long_call.h"
#include "module.h"
#include "motions.h"
#include "steps.h"
#include "unlocked.h"

namespace foldproof::python {
namespace {

double to_double(const py::handle& value) { return value.cast<double>(); }

/// One keyword argument of train.
void set(TrainSettings& s, const std::string& name, const py::handle& value) {
  LearnSettings& learning = s.learning;
  if (name == "references") {
    s.references = static_cast<Index>(whole_number(value, "references"));
  } else if (name == "random_poses") {
    s.random_poses = static_cast<Index>(whole_number(value, "random_poses"));
  } else if (name == "learn") {
    s.learn = value.cast<bool>();
  } else if (name == "modes") {
    learning.size.modes = static_cast<Index>(whole_number(value, "modes"));
  } else if (name == "energy") {
    learning.size.energy = to_double(value);
  } else if (name == "key_points") {
    learning.key_points.max_share = to_double(value);
    learning.key_points.first_share = to_double(value) / 2;
  } else if (name == "subspace") {
    const auto kind = value.cast<std::string>();
    if (kind != "pca" && kind != "kernel-pca")
      refuse("subspace", "'" + kind + "' is not known", "give 'pca' or 'kernel-pca'");
    learning.subspace = kind == "pca" ? SubspaceKind::Pca : SubspaceKind::KernelPca;
  } else {
    refuse_keyword(name, "train",
                   {"references", "random_poses", "learn", "modes", "energy", "key_points", "subspace",
                    "frames", "progress"});
  }
}

TrainSettings train_settings(const py::kwargs& settings) {
  TrainSettings s;
  for (const auto& [key, value] : settings) {
    const auto name = key.cast<std::string>();
    try {
      set(s, name, value);
    } catch (const py::cast_error&) {
      throw py::type_error(name + ": cannot be " + py::repr(value).cast<std::string>());
    }
  }
  return s;
}

std::shared_ptr<Model> train(const py::object& motions, const py::object& frames, const py::object& progress,
                             const py::kwargs& settings) {
  const TrainSettings training = train_settings(settings);
  const FrameRange range = frames_of(frames);
  const auto all = motions_of(motions);
  std::vector<TrainPose> poses;
  for (const auto& motion : all) {
    for (const Index frame : select_frames(range, motion->frame_count()))
      poses.push_back({motion.get(), frame});
  }
  if (poses.empty()) refuse("frames", "select none", "give a motion and select more; frames count from 0");
  std::shared_ptr<Model> model;
  run_long(progress, [&](LongCall& call) {
    model = std::make_shared<Model>(
        take(train_model(poses, training, {.progress = call.progress(), .cancel = call.cancel()})));
  });
  return model;
}

std::shared_ptr<Model> load(const py::object& path) {
  const std::string name = path_of(path);
  const Unlocked unlocked;
  return std::make_shared<Model>(take(load_model(name)));
}

void save(const Model& model, const py::object& path) {
  const std::string name = path_of(path);
  const Unlocked unlocked;
  take(save_model(model, name));
}

py::ssize_t vertices_of(const Model& model) { return model.hierarchy()->topology().vertex_count(); }

std::shared_ptr<Hierarchy> hierarchy_of(const Model& model) {
  return std::const_pointer_cast<Hierarchy>(model.hierarchy());  // Python's class has no way to change it
}

py::array mean_of(const py::object& self) {
  const auto& model = self.cast<const Model&>();
  return view_of(learned_of(model).pca.mean.data(), {vertices_of(model), 3}, self);
}

py::array basis_of(const py::object& self) {
  const auto& model = self.cast<const Model&>();
  const Pca& pca = learned_of(model).pca;
  return view_of(pca.basis.data(), {pca.modes(), vertices_of(model), 3}, self);
}

py::array coordinates_of(const py::object& self) {
  const Eigen::MatrixXd& p = learned_of(self.cast<const Model&>()).coordinates;
  return view_of(p.data(), {p.cols(), p.rows()}, self);
}

py::array numbers_view(const py::object& self, Eigen::VectorXd Pca::*numbers) {
  const Eigen::VectorXd& x = learned_of(self.cast<const Model&>()).pca.*numbers;
  return view_of(x.data(), {x.size()}, self);
}

Eigen::Map<const Eigen::VectorXd> vector_of(const Numbers& x) { return {x.data(), x.size()}; }

py::array project(const Model& model, const py::object& positions) {
  const Pca& pca = learned_of(model).pca;
  const Numbers x = numbers_of(positions, "positions", {vertices_of(model), 3}, "V x 3");
  require_finite(x, "positions");
  const Eigen::VectorXd p = pca.project(vector_of(x));
  return owned({p.data(), p.data() + p.size()}, {p.size()});
}

py::array reconstruct(const Model& model, const py::object& coordinates) {
  const Pca& pca = learned_of(model).pca;
  const Numbers p = numbers_of(coordinates, "p", {pca.modes()}, "one number per mode");
  require_finite(p, "p");
  const Eigen::VectorXd x = pca.reconstruct(vector_of(p));
  return owned({x.data(), x.data() + x.size()}, {vertices_of(model), 3});
}

py::array predict(const Model& model, const py::object& key_positions, const py::object& progress) {
  const auto points = static_cast<py::ssize_t>(learned_of(model).key_points.vertices.size());
  const py::array array = py::array::ensure(key_positions);
  const bool single = array && array.ndim() == 2;
  const std::string layout = "F x K x 3, or K x 3 for one frame, with K = " + std::to_string(points);
  const Numbers keys = single ? numbers_of(key_positions, "key_positions", {points, 3}, layout.c_str())
                              : numbers_of(key_positions, "key_positions", {-1, points, 3}, layout.c_str());
  require_finite(keys, "key_positions");
  const py::ssize_t frames = single ? 1 : keys.shape(0), size = 3 * vertices_of(model);
  std::vector<double> positions(static_cast<std::size_t>(frames * size));
  const double* key = keys.data();
  run_long(progress, [&](LongCall& call) {
    const Predictor predictor(model.learned);
    for (py::ssize_t k = 0; k < frames && !*call.cancel(); ++k) {
      Eigen::Map<Eigen::VectorXd>(&positions[static_cast<std::size_t>(k * size)], size) =
          predictor.from_key_points(Eigen::Map<const Eigen::VectorXd>(key + k * 3 * points, 3 * points));
      call.progress()(static_cast<double>(k + 1) / static_cast<double>(frames));
    }
  });
  std::vector<py::ssize_t> shape{frames, vertices_of(model), 3};
  if (single) shape.erase(shape.begin());
  return owned(std::move(positions), std::move(shape));
}

py::list poses_of(const Model& model) {
  py::list poses;
  for (const TrainedPose& pose : model.poses) {
    py::dict d;
    d["name"] = text_of(pose.name);
    d["reference"] = pose.reference;
    d["proven"] = pose.proven;
    poses.append(d);
  }
  return poses;
}

void bind_learned(py::class_<Model, std::shared_ptr<Model>>& model) {
  model
      .def_property_readonly(
          "learned", [](const Model& m) { return m.learned != nullptr; },
          "Whether shapes were learned. If not, everything below raises Error.")
      .def_property_readonly("mean", &mean_of, "The mean pose, V x 3, mesh units; read-only.")
      .def_property_readonly("basis", &basis_of,
                             "The modes, M x V x 3: x(p) = mean + sum of p[k] * basis[k]; read-only.")
      .def_property_readonly(
          "deviations", [](const py::object& self) { return numbers_view(self, &Pca::deviations); },
          "Standard deviation of the training poses along each mode, M numbers, mesh units.")
      .def_property_readonly(
          "energy", [](const py::object& self) { return numbers_view(self, &Pca::energy); },
          "Share of the variance in the modes up to and including this one, M numbers.")
      .def_property_readonly("coordinates", &coordinates_of,
                             "Subspace coordinates of the poses learned from, a row of M each; read-only.")
      .def_property_readonly(
          "key_points",
          [](const py::object& self) {
            return view_of(learned_of(self.cast<const Model&>()).key_points.vertices, self);
          },
          "Vertices from which predict reconstructs the whole mesh, K ids in the order of its input; "
          "read-only.")
      .def("project", &project, py::arg("positions"),
           "The subspace coordinates p (M numbers) whose shape is nearest to positions (V x 3, mesh units).")
      .def("reconstruct", &reconstruct, py::arg("p"),
           "The shape x(p), V x 3, of subspace coordinates p (M numbers).")
      .def("predict", &predict, py::arg("key_positions"), py::kw_only(), py::arg("progress") = py::none(),
           "The whole mesh from its key points' positions: F x K x 3 gives F x V x 3, K x 3 gives V x 3.\n\n"
           "Mesh units. progress: called with the share that is done. Ctrl-C ends it. Error: wrong shape, "
           "numbers that are not finite, a model that learned no shapes.");
}

}  // namespace

const Learned& learned_of(const Model& model) {
  if (model.learned) return *model.learned;
  refuse(model.name.empty() ? "model" : model.name,
         "has learned no shapes" + (model.not_learned.empty() ? "" : ": " + model.not_learned),
         "train it again with learn=True, from at least 3 poses that differ");
}

std::vector<std::shared_ptr<const Model>> models_of(const py::object& models, std::size_t motions) {
  std::vector<std::shared_ptr<const Model>> out;
  if (models.is_none()) return out;
  for (const auto& model : items_of(models)) {
    if (!model.is_none() && !py::isinstance<Model>(model))
      throw py::type_error("models: expected a foldproof.Model or None, or a list with one per motion");
    out.push_back(model.is_none() ? nullptr : model.cast<std::shared_ptr<Model>>());
  }
  if (out.size() != motions) {
    refuse("models", "are " + std::to_string(out.size()) + " for " + std::to_string(motions) + " motions",
           "give one per motion, or None for motions without one");
  }
  return out;
}

void bind_models(py::module_& module) {
  py::class_<Model, std::shared_ptr<Model>> model(
      module, "Model",
      "What training found out about a mesh: charts, which prove that parts of it do not touch "
      "themselves, and its shapes. A model makes checks faster and never changes an answer.");
  model
      .def_property_readonly(
          "name", [](const Model& m) { return text_of(m.name); }, "The file it was read from, else empty.")
      .def_property_readonly("hierarchy", &hierarchy_of, "The mesh.")
      .def_property_readonly(
          "poses", &poses_of,
          "A dict per training pose: name, reference (charts were built in it), proven (share "
          "of neighborhoods).")
      .def_property_readonly(
          "proven", [](const Model& m) { return summarize(m).proven; },
          "Share of neighborhoods proven free in the training poses, in [0, 1].")
      .def_property_readonly("chart_count", &Model::chart_count, "How many charts it holds.")
      .def("save", &save, py::arg("path"),
           "Writes the model; the file appears whole or not at all. Error: it cannot be written.");
  bind_learned(model);
  module.def(
      "train", &train, py::arg("motions"), py::kw_only(), py::arg("frames") = py::none(),
      py::arg("progress") = py::none(),
      "Trains a Model on poses of one mesh: a Motion or a list of them.\n\n"
      "frames: which of each motion, a slice, an int, 'A:B:STEP' or None for all. progress: called with "
      "the share of the work that is done. Ctrl-C ends it. Error: motions of different meshes, frames "
      "that cannot be read, settings out of range.\n\n"
      "settings, all by keyword:\n"
      "  references=0       poses to build charts in; 0: all, at most 16\n"
      "  random_poses=0     random poses of the subspace to build charts in, too\n"
      "  learn=True         also learn shapes, from at least 3 poses\n"
      "  subspace='pca'     or 'kernel-pca', which keeps shapes near the poses\n"
      "  modes=0            of the subspace; 0: as many as the energy needs\n"
      "  energy=0.999       share of the variance that the subspace keeps\n"
      "  key_points=0.04    key points, at most, as a share of the vertices");
  module.def("load", &load, py::arg("path"),
             "Reads a Model. Error: not a model, a newer format, a damaged file.");
}

}  // namespace foldproof::python
