/// Reports: a check of whole motions, step by step, and the files that hold its answer.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "foldproof/check.h"
#include "foldproof/model.h"

namespace foldproof {

/// Frames as a Python slice selects them: `begin` counts, `end` does not, negative ones count from the end,
/// ends beyond the motion are cut.
struct FrameRange {
  std::optional<std::int64_t> begin, end;
  Index step = 1;  ///< At least 1.
};

/// Reads "A:B", "A:B:STEP" with any of them left out, or a single frame "A". Error: anything else.
Result<FrameRange> parse_frame_range(const std::string& text);

/// The selected frames, ascending. Empty when the range selects none.
std::vector<Index> select_frames(const FrameRange& range, Index frame_count);

struct CheckSettings {
  StepSettings step;
  bool poses = false;  ///< Crossing triangles of each selected frame, instead of collisions between frames.
  /// Do not ask which triangles cross in the first frame. A step without collisions is free of contact, not
  /// of what crosses from the start: only the answer for both says that nothing goes through anything at any
  /// time (docs/soundness.md). Has no effect with `poses`.
  bool steps_only = false;
  FrameRange frames;
  Index substeps = 1;  ///< Linear parts that each step between two frames is cut into; at least 1.
  std::vector<std::shared_ptr<const Model>> models;  ///< One per motion, null where there is none; or empty.
  /// One per motion, for those without a model; or empty: they are built in the first selected frame.
  std::vector<std::shared_ptr<const Hierarchy>> hierarchies;
};

using Motions = std::span<const std::unique_ptr<Motion>>;

/// What run_check goes through. Error: no motions, different frame counts, a range that selects no frame (or
/// just one with CheckSettings::steps_only), nothing between objects where there is but one.
Result<std::vector<Index>> frames_to_check(Motions motions, const CheckSettings& settings);
/// Error: a number of models that does not fit, or one of another mesh.
Result<void> require_models_of(Motions motions, const CheckSettings& settings);

/// How many collisions, by kind.
struct CollisionCounts {
  std::uint64_t vertex_face = 0, edge_edge = 0, triangle_triangle = 0;
  std::uint64_t sum() const { return vertex_face + edge_edge + triangle_triangle; }
};

/// Where in the motion a step stands.
struct StepPlace {
  std::uint64_t number = 0;  ///< Counts the checked steps from 0.
  Index frame = 0;           ///< The step goes from this frame ...
  Index next_frame = 0;      ///< ... to this one; the same for a pose, and for a step that stands still.
  Index substep = 0;         ///< Which of the linear parts between them, from 0.
};

/// One answered step, as writers see it. Everything it points to lasts only for the call.
struct CheckedStep {
  StepPlace place;
  CollisionCounts collisions;
  double earliest_toi = 0;  ///< In [0,1] of the step; 1 when nothing collides, 0 for a pose.
  Work work;
  StageTimes milliseconds;
  Positions x0, x1;                          ///< Ends of the step; the same for a pose.
  const StepResult* step = nullptr;          ///< Null for a pose.
  const StaticResult* pose = nullptr;        ///< Null for a step.
  const Explanation* explanation = nullptr;  ///< Null unless StepSettings::explain is set.
  /// Mode::Paper: collisions of the proven answer that this one misses, and what that answer took. Else 0.
  std::uint64_t missed = 0;
  double proven_milliseconds = 0;

  /// How many of the collisions the answer lists (StepSettings::max_listed).
  CollisionCounts listed() const;
};

/// The whole check in numbers.
struct CheckTotals {
  Index first_frame = 0, last_frame = 0;
  std::uint64_t steps = 0, steps_with_collisions = 0;
  std::uint64_t steps_expected = 0;  ///< How many there were to be: more than `steps` after a stop.
  /// Pairs of triangles that cross in the first frame. Nothing where it was not asked: CheckSettings::poses
  /// or steps_only, or a stop before.
  std::optional<std::uint64_t> starts_crossing;
  StageTimes start_milliseconds;  ///< What that answer took; `milliseconds` is without it.
  CollisionCounts collisions;
  CollisionCounts listed;          ///< Of them, those that the steps' answers list.
  std::optional<StepPlace> worst;  ///< The step with the most collisions, the first of several.
  CollisionCounts worst_collisions;
  std::optional<StepPlace> earliest;  ///< The first step with a collision, and its time of impact.
  double earliest_toi = 0;
  double tolerance = 0;  ///< The largest that a step used, mesh units.
  Work work;
  StageTimes milliseconds;    ///< Sums over the steps.
  double slowest_step = 0;    ///< Milliseconds.
  ReasonCounts leaf_pairs{};  ///< Explanation::leaf_pairs, sums over the steps; zeros when none was wanted.
  std::uint64_t missed = 0;   ///< Mode::Paper: sums over the steps.
  double proven_milliseconds = 0;  ///< The same.
  bool cancelled = false;          ///< Stopped by request; the numbers cover what was done until then.

  /// Everything that was asked is answered, and nothing was found. With starts_crossing: no two triangles
  /// cross at any time.
  bool clean() const {
    return !cancelled && collisions.sum() == 0 && missed == 0 && starts_crossing.value_or(0) == 0;
  }
  /// Counts what crosses in the first frame.
  void start(const CheckedStep& pose);
  /// Counts a step; steps come in order.
  void add(const CheckedStep& step);
};

/// Takes answered steps in order. A file writer leaves a file only after `finish`.
class ReportWriter {
 public:
  virtual ~ReportWriter() = default;
  /// Once, before all steps: which triangles of the first frame cross, in `pose.pose`; `pose.explanation` is
  /// null. Not called where nobody asked (CheckTotals::starts_crossing).
  virtual Result<void> start(const CheckedStep& /*pose*/) { return {}; }
  virtual Result<void> step(const CheckedStep& step) = 0;
  virtual Result<void> finish(const CheckTotals& totals) = 0;
};
using Writers = std::span<const std::unique_ptr<ReportWriter>>;

struct CheckHooks {
  /// Called after every step with the totals so far and the number of steps there will be.
  std::function<void(const CheckTotals&, std::uint64_t)> progress;
  /// Looked at before every step; true stops the check without finishing the writers.
  const std::atomic<bool>* cancel = nullptr;
};

/// Checks `motions` and hands each answer to all writers: first which triangles cross in the first frame,
/// exactly and in every mode, then what collides in each step. A single frame has one step, which stands
/// still: it tells what is as close as the thickness. With Mode::Paper every step is answered a second
/// time, proven, to count what was missed. Memory holds two frames per object (four with
/// substeps) and one answer. Error: as frames_to_check's, a model of another mesh, a frame that cannot be
/// read, a writer's error.
Result<CheckTotals> run_check(Motions motions, const CheckSettings& settings, Writers writers,
                              const CheckHooks& hooks = {});

/// What a report says about its input, besides the motions.
struct ReportInfo {
  CheckSettings settings;
  ReadOptions read;
  bool pairs = false;  ///< JSON only: list every colliding pair.
};

/// The JSON report (docs/reports.md). Steps go to the file as they come.
Result<std::unique_ptr<ReportWriter>> json_report(const std::string& path, Motions motions,
                                                  const ReportInfo& info);

/// A row per collision: frame,substep,kind,object_a,a0,a1,object_b,b0,b1,toi,answer. Kind vf: a0 is the
/// vertex, b0 the face; ee: a0 a1 and b0 b1 are the edges' vertices; tt: a0 and b0 are triangles, without
/// toi; of the first frame, or of poses.
Result<std::unique_ptr<ReportWriter>> csv_report(const std::string& path);

/// All objects in one PLY, in the pose of the step's first contact; marked 1 are faces that take part in a
/// collision, those around a colliding vertex or edge included, 2 those that cross in the first frame, 3
/// both. Without '%' in `path` one file: the worst step, or the first frame when nothing collides. With "%d"
/// or "%04d" in `path` one file for every step with collisions, and for a first frame with crossings; the
/// number is frame x substeps + substep.
Result<std::unique_ptr<ReportWriter>> ply_report(const std::string& path, Motions motions,
                                                 const CheckSettings& settings);

/// For ParaView: `path` ends in .pvd and names a mesh for each step, stepNNNNNN.vtp in the directory beside
/// it of that name without .pvd; all objects joined, in the pose at the step's begin, with `collides`,
/// `starts_crossing` where that was asked, and maybe what an Explanation says per triangle (docs/reports.md).
/// Files and directory appear when the check is finished, in place of older ones. Error: another ending, a
/// directory that holds other things, more than 2^31 corners.
Result<std::unique_ptr<ReportWriter>> vtk_report(const std::string& path, Motions motions,
                                                 const CheckSettings& settings);

/// What certificates did, per triangle and step (docs/reports.md). `path` ends in .npz: everything; .csv:
/// counts; .ply: the worst step, coloured. Precondition: settings.step.explain. Error:
/// another ending.
Result<std::unique_ptr<ReportWriter>> explain_report(const std::string& path, Motions motions,
                                                     const CheckSettings& settings);

/// Per face of an object, 1 when it takes part in a collision; those around a colliding vertex or edge do,
/// too.
std::vector<std::uint8_t> colliding_faces(const Topology& topology, Index object, const StepResult& answer);
std::vector<std::uint8_t> colliding_faces(const Topology& topology, Index object, const StaticResult& answer);

/// Red, green and blue for what an Explanation says of a face. Certified is blue, the paler the deeper the
/// level; pale grey when nothing had to be proven on the way down. The rest are colours that remain apart for
/// the colour-blind (Okabe and Ito, Color Universal Design, 2008).
std::array<std::uint8_t, 3> explanation_colour(Reason reason, int level);

}  // namespace foldproof
