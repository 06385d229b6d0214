/// Checks whole motions, step by step, and writes reports of the answer.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "foldproof/check.h"
#include "foldproof/contacts.h"
#include "foldproof/model.h"
#include "report/frame_range.h"

namespace foldproof {

class ReducedTrack;

/// Reads the part of each triangle: a text file with a name per line, in the order of the triangles. Error:
/// it cannot be read, has an empty line or another number of lines.
Result<ObjectParts> read_parts(const std::string& path, const Topology& topology);

struct CheckSettings {
  StepSettings step;
  /// The mode paper, STATISTICAL: certificates are predicted (predict_free_nodes) at this miss rate. Needs a
  /// model for each motion. None: every answer is proven.
  std::optional<double> paper_miss_rate = std::nullopt;
  bool poses = false;  ///< Find crossing triangles of each selected frame, not collisions between frames.
  /// Skip the test for triangles that cross in the first frame. A step without collisions has no new contact,
  /// but triangles that cross at its start may go on crossing. Only both tests together prove that nothing
  /// intersects at any time (docs/soundness.md). Has no effect with `poses`.
  bool steps_only = false;
  /// Join what collides into contacts. Has no effect in the mode paper and with earliest_only, whose answers
  /// are not complete.
  bool contacts = true;
  std::vector<ObjectParts> parts;  ///< One per motion; or empty: those that the files name.
  std::string unit;                ///< Name of a mesh unit, for reports; empty: the files'.
  /// Pairs of objects or parts, by name, that are not tested; {a, a}: within a (docs/reports.md).
  std::vector<std::array<std::string, 2>> ignore;
  /// Test motions that stand still (MotionInfo::still) among themselves as all others. Else that is done in
  /// the first frame only: CheckTotals::still_crossing. Where nothing moves, everything is tested.
  bool still_pairs = false;
  FrameRange frames;
  /// Linear parts that each step between two frames is divided into; at least 1. The poses in between are
  /// rounded to doubles, and what is checked is the path through them.
  Index substeps = 1;
  std::vector<std::shared_ptr<const Model>> models;  ///< One per motion, null for none; or empty.
  /// One per motion, for those without a model. Empty: built from the first selected frame.
  std::vector<std::shared_ptr<const Hierarchy>> hierarchies;
  /// The motions themselves, if coordinates of a subspace describe them: steps are checked in these
  /// coordinates. Else empty. Not with `poses`, paper_miss_rate, explain and substeps.
  std::vector<const ReducedTrack*> reduced;
  double ball_milliseconds = 0;  ///< For the summary: how long the balls of `reduced` took to prove.
};

using Motions = std::span<const std::unique_ptr<Motion>>;

/// The parts of an object: the settings', else those that its file names.
const ObjectParts& parts_of(Index object, Motions motions, const CheckSettings& settings);

/// What a mesh unit is: the settings' name, else the one that the formats of all motions define; or empty.
std::string unit_of(Motions motions, const CheckSettings& settings);

/// The frames that run_check reads. Error: no motions, different frame counts, a range that selects no frame
/// (or only one with CheckSettings::steps_only), `between` alone with a single object.
Result<std::vector<Index>> frames_to_check(Motions motions, const CheckSettings& settings);

/// Loads a model per motion, or none if there are no paths. A single model is used for all motions of its
/// mesh. Error: a model cannot be loaded, or a single model is of none of several meshes.
Result<std::vector<std::shared_ptr<const Model>>> load_models(std::span<const std::string> paths,
                                                              Motions motions);
/// Error: the number of models differs from the number of motions, or a model is of another mesh.
Result<void> require_models_of(Motions motions, const CheckSettings& settings);

/// Number of collisions, by kind.
struct CollisionCounts {
  std::uint64_t vertex_face = 0, edge_edge = 0, triangle_triangle = 0;
  std::uint64_t sum() const { return vertex_face + edge_edge + triangle_triangle; }
};

/// Which step of the motion.
struct StepIndex {
  std::uint64_t number = 0;  ///< Counts the checked steps from 0.
  Index frame = 0;           ///< The step goes from this frame ...
  Index next_frame = 0;      ///< ... to this one; the same for a pose, and for a step without motion.
  Index substep = 0;         ///< Which of the linear parts between them, from 0.
};

/// The answer for one step, as passed to writers. Everything it points to lasts only for the call.
struct CheckedStep {
  StepIndex index;
  CollisionCounts collisions;
  double earliest_toi = 0;  ///< In [0,1] of the step; 1 when nothing collides, 0 for a pose.
  Work work;
  StageTimes milliseconds;
  Positions x0, x1;                          ///< Start and end of the step; the same for a pose.
  const StepResult* step = nullptr;          ///< Null for a pose.
  const StaticResult* pose = nullptr;        ///< Null for a step.
  const Explanation* explanation = nullptr;  ///< Null unless StepSettings::explain is set.
  const ContactFinder* contacts = nullptr;   ///< As of the end of the step; null if they are not found.
  /// With paper_miss_rate: collisions of the proven answer that this one misses, and the time of that answer.
  /// Else 0.
  std::uint64_t missed = 0;
  double proven_milliseconds = 0;

  /// Number of collisions that the answer lists (StepSettings::max_listed).
  CollisionCounts listed() const;
};

/// Totals over the whole check.
struct CheckTotals {
  Index first_frame = 0, last_frame = 0;
  std::uint64_t steps = 0, steps_with_collisions = 0;
  std::uint64_t steps_expected = 0;  ///< More than `steps` if the check was cancelled.
  /// Pairs of triangles that cross in the first frame. None if not tested: CheckSettings::poses or
  /// steps_only, or cancelled before.
  std::optional<std::uint64_t> starts_crossing;
  /// Objects that stand still and were tested among each other, and with themselves, in the first frame only.
  std::vector<Index> still;
  /// Pairs of triangles that cross among them; not in starts_crossing. None if not tested: steps_only.
  std::optional<std::uint64_t> still_crossing;
  struct StillCrossing {
    Index object_a, object_b;
    std::uint64_t crossings;
  };
  std::vector<StillCrossing> still_crossings;  ///< Of each two objects, by ids; those that are listed.
  StageTimes start_milliseconds;               ///< Times of that test; `milliseconds` excludes them.
  CollisionCounts collisions;
  std::uint64_t start_listed = 0;  ///< Of starts_crossing, those that the first frame's answer lists.
  CollisionCounts listed;          ///< Collisions that the steps' answers list.
  std::optional<StepIndex> worst;  ///< The step with the most collisions, the first of several.
  CollisionCounts worst_collisions;
  std::optional<StepIndex> earliest;  ///< The first step with a collision, and its time of impact.
  double earliest_toi = 0;
  double tolerance = 0;  ///< The largest tolerance of a step, mesh units.
  Work work;
  StageTimes milliseconds;         ///< Sums over the steps.
  double slowest_step = 0;         ///< Milliseconds.
  ReasonCounts leaf_pairs{};       ///< Explanation::leaf_pairs, sums over the steps; zeros without explain.
  std::uint64_t missed = 0;        ///< With paper_miss_rate: sum over the steps.
  double proven_milliseconds = 0;  ///< With paper_miss_rate: sum over the steps.
  bool cancelled = false;          ///< Stopped by request; the numbers cover the steps until then.

  /// What collides and crosses, joined into contacts, the worst first; their times are frames, with fractions
  /// between them. Complete at the end of the check.
  std::vector<Contact> contacts;
  bool contacts_found = false;  ///< Whether they were looked for (CheckSettings::contacts).
  /// Frames of which is not known which triangles cross: too many pairs (StepSettings::max_listed), or
  /// CheckSettings::steps_only.
  std::uint64_t contact_unknown_frames = 0;
  double contact_milliseconds = 0;  ///< Time to find contacts; not in `milliseconds`.
  /// More that is not in `milliseconds`: building hierarchies and checkers, reading frames, writing reports.
  double build_milliseconds = 0, read_milliseconds = 0, write_milliseconds = 0;

  /// What to know before the contacts, found during the check. Complete at its end.
  struct Notice {
    Index object;
    std::string text;  ///< For users, without the object's name.
  };
  std::vector<Notice> notices;

  /// The check is complete and found nothing. With starts_crossing: no two triangles intersect at any time,
  /// apart from those that were ignored, and those among `still`.
  bool clean() const {
    return !cancelled && collisions.sum() == 0 && missed == 0 && starts_crossing.value_or(0) == 0;
  }
  /// Whether the steps' answers list all that they count.
  bool lists_all() const { return listed.sum() == collisions.sum(); }
  /// Adds the crossings of the first frame.
  void start(const CheckedStep& pose);
  /// Adds a step; steps come in order.
  void add(const CheckedStep& step);
};

/// What was ignored by name: "pairs of coat and body were ignored"; empty: nothing.
std::string ignored_pairs(const CheckSettings& settings);
/// What is known about pairs of what stands still: "s1.obj and s2.obj stand still and cross each other at 18
/// pairs of triangles"; empty where they neither cross nor could collide.
std::string still_pairs(Motions motions, const CheckSettings& settings, const CheckTotals& totals);

/// Whether frames between the first and the last were left out.
bool skips_frames(const CheckSettings& settings, const CheckTotals& totals);

/// What was not tested, by the settings or because readers left it out, for the end of the verdict: "pairs of
/// two meshes were not tested", "5 vertices in no face were not checked". With several objects their names
/// come first.
std::vector<std::string> untested(Motions motions, const CheckSettings& settings, const CheckTotals& totals);

/// Receives the answers of steps in order. A file appears only after `finish`.
class ReportWriter {
 public:
  virtual ~ReportWriter() = default;
  /// Called once, before all steps, with the triangles that cross in the first frame in `pose.pose`;
  /// `pose.explanation` is null. Not called if that was not tested (CheckTotals::starts_crossing).
  virtual Result<void> start(const CheckedStep& /*pose*/) { return {}; }
  virtual Result<void> step(const CheckedStep& step) = 0;
  virtual Result<void> finish(const CheckTotals& totals) = 0;
};
using Writers = std::span<const std::unique_ptr<ReportWriter>>;

struct CheckHooks {
  /// Called after every step with the totals so far and the expected number of steps.
  std::function<void(const CheckTotals&, std::uint64_t)> progress;
  /// Called before what may take long and is no step, and before the first step, with MotionCheck::next().
  std::function<void(const char*)> stage = {};
  /// Read before every step; true stops the check without finishing the writers.
  const std::atomic<bool>* cancel = nullptr;
};

/// A check of motions whose caller decides when it goes on; run_check does it at once. Passes each answer to
/// all writers: first the triangles that cross in the first frame, exactly and in every mode, then the
/// collisions of each step. A single frame has one step without motion, which finds pairs as close as the
/// thickness. With paper_miss_rate every step is checked a second time, proven, to count misses. Memory holds
/// two frames per object (four with substeps) and one answer.
class MotionCheck {
 public:
  /// All arguments must outlive the check. Error: those of frames_to_check, a model of another mesh, a name
  /// in CheckSettings::ignore that nothing has.
  static Result<MotionCheck> make(Motions motions, const CheckSettings& settings, Writers writers);
  MotionCheck(MotionCheck&&) noexcept;
  MotionCheck& operator=(MotionCheck&&) noexcept;
  ~MotionCheck();

  /// Does the next part: reads the first frame; finds what crosses in it; then a step per call; at last joins
  /// contacts and finishes the writers. False after that; do not call it again. Error: a frame that cannot be
  /// read, a writer's error.
  Result<bool> advance();
  /// What the next call of advance() does: "building the hierarchy", "checking the first step".
  const char* next() const;
  /// Of what is done so far.
  CheckTotals& totals();

 private:
  class Impl;
  explicit MotionCheck(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// A MotionCheck from its beginning to its end. Error: those of MotionCheck.
Result<CheckTotals> run_check(Motions motions, const CheckSettings& settings, Writers writers,
                              const CheckHooks& hooks = {});

/// Input of a report besides the motions.
struct ReportInfo {
  CheckSettings settings;
  ReadOptions read;
  bool pairs = false;  ///< JSON only: list every colliding pair.
};

/// The JSON report (docs/reports.md). Steps are written as they come.
Result<std::unique_ptr<ReportWriter>> json_report(const std::string& path, Motions motions,
                                                  const ReportInfo& info);

/// A row per collision: frame,substep,kind,object_a,a0,a1,object_b,b0,b1,toi,answer. Kind vf: a0 is the
/// vertex, b0 the face; ee: a0 a1 and b0 b1 are the edges' vertices; tt: a0 and b0 are triangles that cross
/// in the first frame or in a pose, without toi.
Result<std::unique_ptr<ReportWriter>> csv_report(const std::string& path);

/// A row per contact and frame in which it crosses; a contact that only touches has one row, without a frame
/// (docs/contacts.md).
Result<std::unique_ptr<ReportWriter>> contacts_csv(const std::string& path, Motions motions,
                                                   const CheckSettings& settings);

/// The names of the two sides of a contact: their parts where there are any, else their objects (short_name).
std::array<std::string, 2> side_names(const Contact& contact, Motions motions, const CheckSettings& settings);

/// All objects in one PLY. Mark 1: faces that cross or are inside in the frame; 2: faces that meet others
/// before the next, including those around a vertex or edge that does; 3: both. Without '%' in `path`, one
/// file: the frame in which something is deepest inside; if nothing is in any frame, the pose of the first
/// contact of the step with the most collisions, or the first frame. With "%d" or "%04d" in `path`, one file
/// for every frame with marks; the number is frame x substeps + substep.
Result<std::unique_ptr<ReportWriter>> ply_report(const std::string& path, Motions motions,
                                                 const CheckSettings& settings);

/// For ParaView: `path` ends in .pvd and refers to a mesh per step, stepNNNNNN.vtp in a directory of the same
/// name without .pvd. All objects are joined, in the pose at the step's start, with `collides`: what
/// crosses or is inside in it, and `meets`: what meets others during the step (docs/reports.md). File and
/// directory appear when the check is finished, and replace older ones. Error: another extension, a directory
/// with other files in it, more than 2^31 corners.
Result<std::unique_ptr<ReportWriter>> vtk_report(const std::string& path, Motions motions,
                                                 const CheckSettings& settings);

/// Per face of an object, 1 when it crosses another or is inside, at the end of a step or in a pose. None:
/// that is not known.
std::optional<std::vector<std::uint8_t>> inside_faces(const Topology& topology, Index object,
                                                      const CheckedStep& step);

/// Per face of an object, 1 when it collides, including those around a colliding vertex or edge.
/// Precondition: `answer` is about an object `object` of this topology.
std::vector<std::uint8_t> colliding_faces(const Topology& topology, Index object, const StepResult& answer);
std::vector<std::uint8_t> colliding_faces(const Topology& topology, Index object, const StaticResult& answer);

}  // namespace foldproof
