/// Models: what training finds out about a mesh, stored in a file. A model holds a hierarchy, charts (proofs
/// that patches of the surface do not touch themselves: docs/soundness.md, Theorem 2) built in reference
/// poses, so that checks have certificates from their first step on, and what was learned about the mesh's
/// shapes (learned.h). No model, whatever it holds, changes an answer: charts are validated exactly when a
/// file is read. Only balls (reduced.h) that a file keeps are taken on trust, once they are found undamaged
/// and this model's.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "foldproof/check.h"
#include "foldproof/io.h"
#include "foldproof/learned.h"
#include "foldproof/reduced.h"

namespace foldproof {

struct TrainSettings {
  Index references = 0;        ///< Poses to build charts in, chosen to differ most. 0: all poses, at most 16.
  Index max_triangles = 4096;  ///< Of a patch; larger ones hardly ever face one plane.
  /// Random poses to sample from the learned subspace, distributed as the training poses are. Charts are
  /// built in them, too, where the other charts do not hold. Ignored when nothing is learned.
  Index random_poses = 0;
  bool learn = true;  ///< Fill in Model::learned; needs at least 3 poses.
  LearnSettings learning = {};
};

/// Why no chart proved that a leaf does not touch itself.
enum class Obstacle : std::uint8_t {
  TooCurved,    ///< There is no plane that all its triangles face, or a triangle has no area.
  Overlapping,  ///< Its projection overlaps itself, is in several pieces, or has a fan of triangles.
  TooThin,      ///< It has a chart, but so narrow that rounding leaves nothing to prove.
};

/// A leaf that neither its own charts nor those of a node above it proved in some reference poses.
struct HardLeaf {
  Index leaf;
  Index references;   ///< Number of these poses; at least 1.
  Obstacle obstacle;  ///< In the last of them.
};

/// A pose that the model was trained on.
struct TrainedPose {
  std::string name;  ///< For messages: file and frame.
  bool reference;    ///< Charts were built in it.
  /// Share of neighborhoods that the charts prove in this pose, in [0, 1]. Neighborhoods: each leaf with
  /// itself, and each pair of leaves with a common vertex.
  float proven;
};

/// Immutable; any number of queries may use it.
struct Model {
  std::string name;     ///< For messages: the file it was read from, else empty.
  std::string program;  ///< Version of the library that trained it.
  TrainSettings settings;
  std::vector<TrainedPose> poses;
  std::vector<HardLeaf> hard_leaves;           ///< By leaf, ascending.
  std::shared_ptr<const ChartLibrary> charts;  ///< Never null. A chart's source is the index of its pose.
  std::shared_ptr<const Learned> learned;      ///< Null when nothing was learned.
  std::shared_ptr<const ReducedBalls> balls;   ///< Around ball_centers, to be kept in the file; or null.
  std::string not_learned;  ///< For messages: why training learned nothing. Not stored in the file.

  const std::shared_ptr<const Hierarchy>& hierarchy() const;
  std::size_t chart_count() const;
  /// For a checker.
  Object object() const { return charts; }
};

/// Identifies a mesh: FNV-1a over the vertex count and the triangles.
std::uint64_t topology_hash(const Topology& topology);

/// Error when the model is of another mesh: another vertex count, or other triangles or another order of
/// them. It says how they differ; `mesh` is the mesh's name.
Result<void> require_model_of(const Model& model, const Topology& topology, const std::string& mesh,
                              std::span<const Index> merged = {});

/// Error when nothing was learned: Model::learned is null.
Result<void> require_learned(const Model& model);

/// A frame of a motion to learn from.
struct TrainPose {
  Motion* motion;
  Index frame;
};

struct TrainHooks {
  std::function<void(double)> progress = {};  ///< Called with the share of the work that is done.
  const std::atomic<bool>* cancel = nullptr;  ///< Polled before every pose; true ends training with an error.
  /// Called when another part of the work begins: "building charts in pose 3 of 16".
  std::function<void(const std::string&)> stage = {};
};

/// Builds charts and learns what learned.h describes. The same input gives the same model for any number of
/// threads. Memory: one pose; when references are chosen, a short descriptor per pose; to learn, an evenly
/// spaced selection of the poses, at most LearnSettings::max_poses and 512 MB, and about four times as much
/// for working. When nothing can be learned (the poses are equal, or their numbers too large to compute
/// with), Model::learned is null. Error: no poses, poses of different topologies, a mesh beyond a model's
/// limits (docs/model.md), a frame that cannot be read, a setting out of range.
Result<Model> train_model(std::span<const TrainPose> poses, const TrainSettings& settings,
                          const TrainHooks& hooks = {});

/// The mode of the paper (Eq. 3 and 8), STATISTICAL: which nodes the key points at the start and the end of a
/// step predict not to touch themselves, as StepSettings::declared_free takes it; one model per object.
/// Accepts only as many predictions as would have been wrong about at most the share `miss_rate`, in [0,1],
/// of unproven nodes in training poses (CertificateMap::CalibrationPoint); new motions miss more. Error: a
/// model has learned no certificates, wrong sizes.
Result<void> predict_free_nodes(std::span<const std::shared_ptr<const Model>> models, Positions x0,
                                Positions x1, double miss_rate, std::vector<std::vector<std::uint8_t>>& out);

/// Which shapes sample_shapes draws.
struct SampleSettings {
  Index count = 10;        ///< Number of shapes, at least 1.
  std::uint64_t seed = 1;  ///< The same seed gives the same shapes.
  double spread = 1;       ///< Factor of the learned standard deviations; positive.
  /// Changes a shape that crosses itself, vertex_count x 3, so that it does not; false: it could not. Its
  /// error is returned. Null: such shapes are refused.
  std::function<Result<bool>(std::span<double> x)> repair = nullptr;
};

/// What sample_shapes has drawn.
struct Samples {
  std::unique_ptr<Motion> shapes;  ///< A frame per shape, computed when it is read.
  std::uint64_t drawn = 0;         ///< How many were drawn, refused ones included.
  std::uint64_t repaired = 0;      ///< How many of the shapes were.
};

/// Draws shapes from what the model has learned: each mode's coordinate from a normal distribution with the
/// deviation of the training poses. Repairs or refuses those in which two triangles cross, so that all others
/// are proven free of that (StepChecker::check_static). Vertices are rounded to single precision before, so
/// that files of any format hold the shapes that were checked. Error: nothing is learned, a setting out of
/// range, cancelled, more than 1000 draws of which less than one in a hundred is free.
Result<Samples> sample_shapes(const Model& model, const SampleSettings& settings,
                              const TrainHooks& hooks = {});

/// The mean of the poses, and the center of each cluster if there are several. Their balls may grow as large
/// as the farthest training pose.
std::vector<ReducedCenter> ball_centers(const Learned& learned);

/// Proves the balls around ball_centers. Precondition: model.learned. Error and cost: as ReducedShape::build.
Result<std::shared_ptr<const ReducedShape>> prove_balls(const Model& model, double clearance = 0,
                                                        const ReducedHooks& hooks = {});

/// The shape of Model::balls, in little time. Precondition: model.learned and model.balls.
Result<std::shared_ptr<const ReducedShape>> kept_balls(const Model& model);

/// Writes a file (docs/model.md), which appears whole or not at all. Error: it cannot be written, or would
/// exceed 2 GB.
Result<void> save_model(const Model& model, const std::string& path);

/// Reads a model. Error: not a model, a newer format, or content that fails a check of docs/model.md.
Result<Model> load_model(const std::string& path);

/// Statistics of a model.
struct ModelSummary {
  struct Level {
    Index slots = 0;    ///< Nodes, or pairs of leaves.
    Index charted = 0;  ///< Those with a chart.
    Index charts = 0;   ///< All their charts.
    /// Of these charts' steepness in the poses they were built in, rounded up: no path on the surface is
    /// longer than kappa times the straight line below it in the chart. 0 without any.
    double kappa_median = 0, kappa_max = 0;
  };
  std::vector<Level> levels;  ///< From the root down.
  Level pairs;                ///< Of pairs of leaves with a common vertex.
  Index references = 0;
  double proven = 0;  ///< Mean of TrainedPose::proven.
};

/// Cost: one pass over all charts.
ModelSummary summarize(const Model& model);

}  // namespace foldproof
