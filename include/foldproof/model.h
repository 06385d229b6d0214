/// Models: what training found out about a mesh, kept in a file. A model is a hierarchy with charts
/// (certificate.h) drawn in reference poses, so that a query knows from its first step on what it can prove
/// free, and with what was learned about the mesh's shapes (learned.h). A model never changes an answer,
/// whatever is in it: charts are checked exactly when a file is read.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "foldproof/certificate.h"
#include "foldproof/io.h"
#include "foldproof/learned.h"

namespace foldproof {

struct TrainSettings {
  Index references = 0;         ///< Poses to draw charts in, chosen to differ most. 0: all poses, at most 16.
  Index most_triangles = 4096;  ///< Of a patch; larger ones hardly ever lie in one plane.
  /// Shapes made from the learned subspace, at random as the poses are distributed in it, to draw charts in
  /// as well where those of the poses prove too little. None where nothing is learned.
  Index made = 0;
  bool learn = true;  ///< Model::learned too, where there are at least 3 poses.
  LearnSettings learning = {};
};

/// Why no chart proved a leaf free of contact with itself.
enum class Obstacle : std::uint8_t {
  TooCurved,  ///< No plane that all its triangles face, or a triangle without area.
  Tangled,    ///< Drawn in the plane it overlaps itself, is in several pieces, or has a fan of triangles.
  TooThin,    ///< Drawn, but so narrow that rounding leaves nothing to prove.
};

/// A leaf that neither its own charts nor those of a node above it proved in some reference poses.
struct HardLeaf {
  Index leaf;
  Index references;   ///< In how many of them; at least 1.
  Obstacle obstacle;  ///< In the last of them.
};

/// A pose that training looked at.
struct TrainedPose {
  std::string name;  ///< For people: file and frame.
  bool reference;    ///< Charts were drawn in it.
  float proven;  ///< Share of neighbourhoods that all charts together prove in this pose: of all leaves with
                 ///< themselves and all pairs of leaves with a common vertex. In [0,1].
};

/// Immutable once made; any number of queries may use it.
struct Model {
  std::string name;     ///< For people: the file it was read from, empty when it was not.
  std::string program;  ///< Version of the library that trained it.
  TrainSettings settings;
  std::vector<TrainedPose> poses;
  std::vector<HardLeaf> hard_leaves;           ///< By leaf, ascending.
  std::shared_ptr<const ChartLibrary> charts;  ///< Never null. A chart's source is the number of its pose.
  std::shared_ptr<const Learned> learned;      ///< Null when nothing was learned.
  std::string not_learned;                     ///< For people, right after training: why nothing was.

  const std::shared_ptr<const Hierarchy>& hierarchy() const { return charts->slots()->hierarchy(); }
  /// For a checker: the charts, and what predicts certificates where it was learned.
  Object object() const { return {charts, predicted_certificates(learned)}; }
};

/// Tells meshes apart: FNV-1a over the number of vertices and the triangles.
std::uint64_t topology_hash(const Topology& topology);

/// Whether a model is one of this mesh: same vertex count, same triangles in the same order. Error: says how
/// they differ; `mesh` names the mesh.
Result<void> require_model_of(const Model& model, const Topology& topology, const std::string& mesh);

/// A frame of a motion to learn from.
struct TrainPose {
  Motion* motion;
  Index frame;
};

struct TrainHooks {
  std::function<void(double)> progress = {};  ///< Called with the share of the work that is done.
  const std::atomic<bool>* cancel =
      nullptr;  ///< Looked at before every pose; true ends training in an error.
};

/// Draws charts, and learns what learned.h tells of. The same input gives the same model for any number of
/// threads. Memory holds one pose and one short descriptor per pose when references have to be chosen; to
/// learn, as many poses as fit into 512 MB, at most LearnSettings::most_poses, evenly taken, and working
/// space of about four times as much. Poses from which nothing can be learned (all the same, or far too large
/// to compute with) get a model without. Error: no poses, poses of different topologies, a mesh beyond a
/// model's limits (docs/model.md), a frame that cannot be read, settings beyond their range.
Result<Model> train_model(std::span<const TrainPose> poses, const TrainSettings& settings,
                          const TrainHooks& hooks = {});

/// Writes a file that appears whole or not at all (docs/model.md). Error: it cannot be written, or would
/// exceed 2 GB.
Result<void> save_model(const Model& model, const std::string& path);

/// Reads a model. Error: no model, a newer format, anything that is not as it should be.
Result<Model> load_model(const std::string& path);

/// What is inside a model, in numbers.
struct ModelSummary {
  struct Level {
    Index slots = 0;                          ///< Nodes, or pairs of leaves.
    Index charted = 0;                        ///< How many of them have a chart.
    Index charts = 0;                         ///< Theirs, together.
    double kappa_median = 0, kappa_most = 0;  ///< Of these charts (chart_kappa); 0 without any.
  };
  std::vector<Level> levels;  ///< From the root down.
  Level pairs;                ///< Pairs of leaves with a common vertex in place of nodes.
  Index references = 0;
  double proven = 0;  ///< Mean of TrainedPose::proven.
};

/// Cost: one pass over all charts.
ModelSummary summarize(const Model& model);

/// A chart's steepness as it was drawn, rounded up: no path on the surface is longer than kappa times the
/// straight line below it in the picture.
double chart_kappa(const ChartLibrary& library, const ChartLibrary::Chart& chart);

}  // namespace foldproof
