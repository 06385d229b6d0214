#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "base/stopwatch.h"
#include "base/try.h"
#include "check/answer.h"
#include "report/coincidences.h"
#include "report/ignored.h"
#include "report/motion_contacts.h"
#include "report/reduced_track.h"
#include "report/report.h"

namespace foldproof {
namespace {

/// Positions of all objects at one time.
class Pose {
 public:
  explicit Pose(Motions motions) {
    for (const auto& motion : motions)
      objects_.emplace_back(std::size_t{motion->topology().vertex_count()} * 3);
    for (const auto& object : objects_) spans_.emplace_back(object);
  }
  Pose(Pose&&) = default;
  Pose& operator=(Pose&&) = default;
  Pose(const Pose&) = delete;
  Pose& operator=(const Pose&) = delete;

  Positions positions() const { return spans_; }

  Result<void> read(Motions motions, Index frame) {
    for (std::size_t i = 0; i < objects_.size(); ++i) {
      FOLDPROOF_TRY(motions[i]->read_frame(frame, objects_[i]));
    }
    return {};
  }

  /// The pose at time `t` in [0,1] between `a` and `b`. A vertex that does not move keeps its exact position.
  void blend(const Pose& a, const Pose& b, double t) {
    for (std::size_t i = 0; i < objects_.size(); ++i) {
      for (std::size_t k = 0; k < objects_[i].size(); ++k) {
        objects_[i][k] = std::lerp(a.objects_[i][k], b.objects_[i][k], t);
      }
    }
  }

 private:
  // Moving a vector keeps its heap block, so the spans stay valid.
  std::vector<std::vector<double>> objects_;
  std::vector<std::span<const double>> spans_;
};

Result<std::vector<Object>> make_objects(Motions motions, const CheckSettings& settings, const Pose& first) {
  std::vector<Object> objects;
  for (std::size_t i = 0; i < motions.size(); ++i) {
    if (!settings.models.empty() && settings.models[i]) {
      objects.push_back(settings.models[i]->object());
      continue;
    }
    if (!settings.hierarchies.empty()) {
      objects.emplace_back(settings.hierarchies[i]);
      continue;
    }
    auto hierarchy = Hierarchy::build(motions[i]->topology(), first.positions()[i]);
    if (!hierarchy) {
      Error error = hierarchy.error();
      error.where = motions[i]->name() + ": " + error.where;
      return tl::unexpected(std::move(error));
    }
    objects.emplace_back(std::move(*hierarchy));
  }
  for (std::size_t i = 0; i < motions.size(); ++i) objects[i].set_layered(motions[i]->info().layered);
  return objects;
}

// Only models predict certificates.
Result<void> require_predictions(Motions motions, const CheckSettings& settings) {
  if (!settings.paper_miss_rate) return {};
  for (std::size_t i = 0; i < motions.size(); ++i) {
    const Model* model = settings.models.empty() ? nullptr : settings.models[i].get();
    if (model && model->learned && model->learned->certificates) continue;
    return fail(ErrorCode::NotLearned, motions[i]->name(),
                "has no model that predicts its certificates, and the mode paper needs one",
                "give --model one trained on at least 3 poses that differ");
  }
  return {};
}

void add_counts(CollisionCounts& sum, const CollisionCounts& more) {
  sum.vertex_face += more.vertex_face;
  sum.edge_edge += more.edge_edge;
  sum.triangle_triangle += more.triangle_triangle;
}

}  // namespace

// Stages follow each other; each call of advance() does a part of one.
class MotionCheck::Impl {
 public:
  Impl(Motions motions, const CheckSettings& settings, Writers writers, std::vector<Index> frames)
      : motions_(motions),
        settings_(settings),
        writers_(writers),
        frames_(std::move(frames)),
        from_(motions),
        to_(motions),
        coincidences_(motions) {
    totals_.first_frame = frames_.front();
    totals_.last_frame = frames_.back();
    totals_.steps_expected = expected_steps();
    totals_.still = still_objects(motions, settings, frames_.size());
  }

  CheckTotals& totals() { return totals_; }

  const char* next() const {
    switch (stage_) {
      case Stage::FirstFrame:
        return "building the hierarchy";
      case Stage::Crossings:
        return "finding what crosses in the first frame";
      case Stage::Steps:
        return settings_.poses ? "checking frames" : "checking steps";
      case Stage::End:
        return writers_.empty() ? "joining contacts" : "joining contacts and writing reports";
    }
    return "";
  }

  Result<bool> advance() {
    Stopwatch watch;
    switch (stage_) {
      case Stage::FirstFrame:
        FOLDPROOF_TRY(read(from_, frames_[0]));
        watch.lap();
        FOLDPROOF_TRY(prepare());
        totals_.build_milliseconds = watch.lap();
        FOLDPROOF_TRY(test_still());
        stage_ = settings_.poses || settings_.steps_only ? Stage::Steps : Stage::Crossings;
        return true;
      case Stage::Crossings:
        FOLDPROOF_TRY(start());
        stage_ = Stage::Steps;
        return true;
      case Stage::Steps:
        FOLDPROOF_TRY(step(totals_.steps));
        if (totals_.steps == totals_.steps_expected) stage_ = Stage::End;
        return true;
      case Stage::End:
        break;
    }
    if (contacts_) contacts_->finish(totals_);
    totals_.notices = coincidences_.notices();
    watch.lap();
    for (const auto& writer : writers_) {
      FOLDPROOF_TRY(writer->finish(totals_));
    }
    totals_.write_milliseconds += watch.lap();
    return false;
  }

 private:
  enum class Stage : std::uint8_t { FirstFrame, Crossings, Steps, End };

  Result<void> read(Pose& pose, Index frame) {
    Stopwatch watch;
    FOLDPROOF_TRY(pose.read(motions_, frame));
    totals_.read_milliseconds += watch.lap();
    return {};
  }

  Result<void> step(std::uint64_t number) {
    if (settings_.poses) return pose(number);
    return settings_.reduced.empty() ? linear_step(number) : reduced_step(number);
  }

  Result<void> pose(std::uint64_t number) {
    const Index frame = frames_[number];
    if (number > 0) FOLDPROOF_TRY(read(from_, frame));
    FOLDPROOF_TRY(predict(from_, from_));
    StaticResult& result = static_result_;
    FOLDPROOF_TRY(checker_->check_static(from_.positions(), step_settings_, result));
    if (proven_) {
      FOLDPROOF_TRY(proven_->check_static(from_.positions(), proven_settings_, proven_static_result_));
    }
    CheckedStep step{.index = {number, frame, frame, 0},
                     .collisions = {.triangle_triangle = result.crossing_count},
                     .work = result.work,
                     .milliseconds = result.milliseconds,
                     .x0 = from_.positions(),
                     .x1 = from_.positions(),
                     .pose = &result,
                     .explanation = explanation_in(result),
                     .missed = proven_ ? proven_static_result_.crossing_count - result.crossing_count : 0,
                     .proven_milliseconds = proven_static_result_.milliseconds.total};
    if (contacts_) {
      contacts_->pose(step);
      step.contacts = &contacts_->finder();
    }
    return deliver(step);
  }

  Result<void> linear_step(std::uint64_t number) {
    if (frames_.size() == 1) return check({0, frames_[0], frames_[0], 0}, from_, from_);
    const std::uint64_t i = number / settings_.substeps;
    const auto part = static_cast<Index>(number % settings_.substeps);
    const bool first = part == 0, last = part + 1 == settings_.substeps;
    if (first) FOLDPROOF_TRY(read(to_, frames_[i + 1]));
    if (!last) part_end_->blend(from_, to_, static_cast<double>(part + 1) / settings_.substeps);
    FOLDPROOF_TRY(check({number, frames_[i], frames_[i + 1], part}, first ? from_ : *part_start_,
                        last ? to_ : *part_end_));
    std::swap(part_start_, part_end_);
    if (last) std::swap(from_, to_);
    return {};
  }

  // Vertices are computed only for steps in which somebody reads them.
  Result<void> reduced_step(std::uint64_t number) {
    const StepIndex index{number, frames_[number],
                          frames_[std::min<std::size_t>(number + 1, frames_.size() - 1)], 0};
    FOLDPROOF_TRY(reduced_checker_->check(reduced_poses(index.frame), reduced_poses(index.next_frame),
                                          settings_.step, result_));
    if (reads_positions()) {
      FOLDPROOF_TRY(read(from_, index.frame));
      FOLDPROOF_TRY(read(to_, index.next_frame));
    }
    return answer(index, from_, to_);
  }

  std::vector<ReducedPose> reduced_poses(Index frame) const {
    std::vector<ReducedPose> poses;
    for (const ReducedTrack* track : settings_.reduced) poses.push_back(track->pose(frame));
    return poses;
  }

  bool reads_positions() const {
    if (!writers_.empty() || result_.count() > 0) return true;
    return contacts_ && (contacts_->finder().open_count() > 0 || !contacts_->finder().is_known());
  }

  std::uint64_t expected_steps() const {
    if (settings_.poses) return frames_.size();
    if (frames_.size() == 1) return 1;  // without motion
    return (frames_.size() - 1) * std::uint64_t{settings_.substeps};
  }

  Result<void> prepare() {
    objects_ = FOLDPROOF_TRY(make_objects(motions_, settings_, from_));
    filter_ = FOLDPROOF_TRY(filter_for(motions_, settings_, objects_, totals_.still, TestedPairs::Moving));
    contacts_ = FOLDPROOF_TRY(MotionContacts::make(motions_, settings_, objects_, filter_));
    prepare_comparison();
    if (settings_.reduced.empty()) {
      checker_.emplace(objects_, filter_);
    } else {
      std::vector<ReducedChecker::Object> objects;
      for (const ReducedTrack* track : settings_.reduced) objects.push_back(track->object());
      reduced_checker_.emplace(std::move(objects));
    }
    if (settings_.substeps > 1) {
      part_start_.emplace(motions_);
      part_end_.emplace(motions_);
    }
    return {};
  }

  // What crosses in the first frame, exactly and in every mode.
  Result<StaticResult> first_crossings(StepChecker& checker, StepSettings exact,
                                       std::uint64_t max_listed) const {
    exact.explain = false;
    exact.max_listed = max_listed;
    StaticResult result;
    FOLDPROOF_TRY(checker.check_static(from_.positions(), exact, result));
    return result;
  }

  // By a checker that is asked once. Charts of its own would pay from its second pose on.
  Result<StaticResult> first_crossings_once(std::shared_ptr<const PairFilter> filter,
                                            std::uint64_t max_listed) const {
    StepSettings once = settings_.step;
    once.certificates &= std::ranges::any_of(objects_, [](const Object& o) { return o.charts() != nullptr; });
    StepChecker checker(objects_, std::move(filter));
    return first_crossings(checker, once, max_listed);
  }

  Result<void> test_still() {
    if (totals_.still.empty() || (settings_.steps_only && !settings_.poses)) return {};
    auto filter =
        FOLDPROOF_TRY(filter_for(motions_, settings_, objects_, totals_.still, TestedPairs::AmongStill));
    const auto result = FOLDPROOF_TRY(first_crossings_once(std::move(filter), StepSettings().max_listed));
    totals_.still_crossing = result.crossing_count;
    still_milliseconds_ = result.milliseconds;
    std::map<std::pair<Index, Index>, std::uint64_t> counts;
    for (const TriangleCrossing& c : result.crossings) ++counts[{c.object_a, c.object_b}];
    for (const auto& [objects, count] : counts)
      totals_.still_crossings.push_back({objects.first, objects.second, count});
    return {};
  }

  Result<void> start() {
    // Where the steps have a checker of the same kind, the charts of the first pose serve them, too.
    const std::uint64_t listed = settings_.step.max_listed;
    const auto result =
        FOLDPROOF_TRY(checker_ && !proven_ ? first_crossings(*checker_, settings_.step, listed)
                                           : first_crossings_once(filter_, listed));
    CheckedStep pose{.index = {0, frames_[0], frames_[0], 0},
                     .collisions = {.triangle_triangle = result.crossing_count},
                     .work = result.work,
                     .milliseconds = result.milliseconds,
                     .x0 = from_.positions(),
                     .x1 = from_.positions(),
                     .pose = &result};
    totals_.start(pose);
    totals_.start_milliseconds += still_milliseconds_;
    if (contacts_) {
      contacts_->pose(pose);
      pose.contacts = &contacts_->finder();
    }
    for (const auto& writer : writers_) {
      FOLDPROOF_TRY(writer->start(pose));
    }
    return {};
  }

  Result<void> check(const StepIndex& index, const Pose& x0, const Pose& x1) {
    FOLDPROOF_TRY(predict(x0, x1));
    FOLDPROOF_TRY(checker_->check(x0.positions(), x1.positions(), step_settings_, result_));
    if (proven_) {
      FOLDPROOF_TRY(proven_->check(x0.positions(), x1.positions(), proven_settings_, proven_result_));
    }
    return answer(index, x0, x1);
  }

  // Passes result_ on.
  Result<void> answer(const StepIndex& index, const Pose& x0, const Pose& x1) {
    CheckedStep step{.index = index,
                     .collisions = {result_.vertex_face_count, result_.edge_edge_count, 0},
                     .earliest_toi = result_.earliest_toi,
                     .work = result_.work,
                     .milliseconds = result_.milliseconds,
                     .x0 = x0.positions(),
                     .x1 = x1.positions(),
                     .step = &result_,
                     .explanation = explanation_in(result_),
                     .missed = proven_ ? proven_result_.count() - result_.count() : 0,
                     .proven_milliseconds = proven_result_.milliseconds.total};
    if (contacts_) {
      FOLDPROOF_TRY(contacts_->step(step));
      step.contacts = &contacts_->finder();
    }
    return deliver(step);
  }

  // The mode paper: makes the checker to compare with. The statistical answer is a subset of the proven one,
  // since both pass the same pairs to the same narrow phase. So counts are enough.
  void prepare_comparison() {
    if (!settings_.paper_miss_rate) return;
    step_settings_.declared_free = &predicted_free_;
    proven_settings_ = settings_.step;
    proven_settings_.max_listed = 0;
    proven_.emplace(objects_, filter_);
  }

  Result<void> predict(const Pose& x0, const Pose& x1) {
    if (!proven_ || !settings_.step.within) return {};
    return predict_free_nodes(settings_.models, x0.positions(), x1.positions(), *settings_.paper_miss_rate,
                              predicted_free_);
  }

  template <class Answer>
  const Explanation* explanation_in(const Answer& answer) const {
    return settings_.step.explain ? &answer.explanation : nullptr;
  }

  Result<void> deliver(const CheckedStep& step) {
    totals_.add(step);
    look_for_coincidences(step);
    Stopwatch watch;
    for (const auto& writer : writers_) {
      FOLDPROOF_TRY(writer->step(step));
    }
    totals_.write_milliseconds += watch.lap();
    return {};
  }

  // They collide in the first frame, if at all.
  void look_for_coincidences(const CheckedStep& step) {
    if (step.index.number == 0)
      follows_coincidences_ = settings_.step.within && settings_.reduced.empty() && !totals_.clean();
    if (!follows_coincidences_) return;
    if (step.index.number == 0 || step.pose) coincidences_.add(step.index.frame, step.x0);
    if (!step.pose && step.index.substep + 1 == settings_.substeps)
      coincidences_.add(step.index.next_frame, step.x1);
  }

  Motions motions_;
  const CheckSettings& settings_;
  Writers writers_;
  std::vector<Index> frames_;
  Stage stage_ = Stage::FirstFrame;
  Pose from_, to_;
  std::optional<Pose> part_start_, part_end_;  // with substeps
  std::vector<Object> objects_;
  std::shared_ptr<const PairFilter> filter_;  // null: all pairs are tested
  std::unique_ptr<MotionContacts> contacts_;  // null: not looked for
  std::optional<StepChecker> checker_;
  std::optional<ReducedChecker> reduced_checker_;  // in place of checker_
  StepResult result_, proven_result_;
  StaticResult static_result_, proven_static_result_;
  std::optional<StepChecker> proven_;  // the mode paper
  StepSettings step_settings_ = settings_.step, proven_settings_;
  std::vector<std::vector<std::uint8_t>> predicted_free_;
  StageTimes still_milliseconds_;
  CheckTotals totals_;
  Coincidences coincidences_;
  bool follows_coincidences_ = false;
};

Result<std::vector<Index>> frames_to_check(Motions motions, const CheckSettings& settings) {
  if (motions.empty()) return fail(ErrorCode::InvalidArgument, "motions", "none given", "name at least one");
  const Index count = motions[0]->frame_count();
  for (const auto& motion : motions) {
    if (motion->frame_count() == count) continue;
    return fail(ErrorCode::InvalidArgument, motion->name(),
                fmt::format("has {} frame{}, but {} has {}", motion->frame_count(),
                            motion->frame_count() == 1 ? "" : "s", motions[0]->name(), count),
                "objects that are checked together need equally many frames");
  }
  if (settings.step.between && !settings.step.within && motions.size() < 2) {
    return fail(ErrorCode::InvalidArgument, motions[0]->name(),
                "is the only object, so there is nothing between objects to check",
                "name a second motion, or leave --between out; numbered meshes are one, unless --separate");
  }
  FOLDPROOF_TRY(check_settings(settings.step, motions.size()));
  if (!settings.reduced.empty() && !settings.ignore.empty())
    return fail(ErrorCode::InvalidArgument, "ignore", "does not go with coordinates of a subspace",
                "leave it out, or check the motion that 'foldproof predict' writes");
  if (settings.substeps == 0)
    return fail(ErrorCode::InvalidArgument, "substeps", "must not be 0", "give 1 or more");
  std::vector<Index> frames = select_frames(settings.frames, count);
  const std::size_t needed = settings.steps_only && !settings.poses ? 2 : 1;
  if (frames.size() >= needed) return frames;
  if (count < needed) {
    return fail(ErrorCode::InvalidArgument, motions[0]->name(),
                "has 1 frame, and a step goes from one frame to the next",
                "check it without --steps-only: its crossing triangles are found");
  }
  return fail(ErrorCode::InvalidArgument, "--frames",
              fmt::format("selects {} of {} frames, and {} needed", frames.size(), count,
                          needed == 1 ? "one is" : "two are"),
              "select more; frames count from 0 and the end of A:B is not included");
}

CollisionCounts CheckedStep::listed() const {
  if (pose) return {0, 0, pose->crossings.size()};
  return {step->vertex_face.size(), step->edge_edge.size(), 0};
}

void CheckTotals::start(const CheckedStep& pose) {
  starts_crossing = pose.collisions.triangle_triangle;
  start_listed = pose.listed().triangle_triangle;
  start_milliseconds = pose.milliseconds;
}

void CheckTotals::add(const CheckedStep& step) {
  ++steps;
  add_counts(collisions, step.collisions);
  add_counts(listed, step.listed());
  if (step.collisions.sum() > 0) {
    ++steps_with_collisions;
    if (!earliest) {
      earliest = step.index;
      earliest_toi = step.earliest_toi;
    }
    if (step.collisions.sum() > worst_collisions.sum()) {
      worst = step.index;
      worst_collisions = step.collisions;
    }
  }
  if (step.step) tolerance = std::max(tolerance, step.step->tolerance);
  work += step.work;
  for (std::size_t i = 0; step.explanation && i < leaf_pairs.size(); ++i)
    leaf_pairs[i] += step.explanation->leaf_pairs[i];
  missed += step.missed;
  proven_milliseconds += step.proven_milliseconds;
  milliseconds += step.milliseconds;
  slowest_step = std::max(slowest_step, step.milliseconds.total);
}

MotionCheck::MotionCheck(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
MotionCheck::MotionCheck(MotionCheck&&) noexcept = default;
MotionCheck& MotionCheck::operator=(MotionCheck&&) noexcept = default;
MotionCheck::~MotionCheck() = default;

Result<MotionCheck> MotionCheck::make(Motions motions, const CheckSettings& settings, Writers writers) {
  auto frames = FOLDPROOF_TRY(frames_to_check(motions, settings));
  FOLDPROOF_TRY(require_models_of(motions, settings));
  FOLDPROOF_TRY(require_predictions(motions, settings));
  FOLDPROOF_TRY(check_names(motions, settings));
  return MotionCheck(std::make_unique<Impl>(motions, settings, writers, std::move(frames)));
}

Result<bool> MotionCheck::advance() { return impl_->advance(); }
const char* MotionCheck::next() const { return impl_->next(); }
CheckTotals& MotionCheck::totals() { return impl_->totals(); }

Result<CheckTotals> run_check(Motions motions, const CheckSettings& settings, Writers writers,
                              const CheckHooks& hooks) {
  auto check = FOLDPROOF_TRY(MotionCheck::make(motions, settings, writers));
  CheckTotals& totals = check.totals();
  const char* stage = nullptr;  // of the last call
  for (bool more = true; more;) {
    totals.cancelled = hooks.cancel && hooks.cancel->load(std::memory_order_relaxed);
    if (totals.cancelled) break;
    const std::uint64_t steps = totals.steps;
    const char* const last = std::exchange(stage, check.next());
    if (hooks.stage && stage != last) hooks.stage(stage);
    more = FOLDPROOF_TRY(check.advance());
    if (hooks.progress && totals.steps > steps) hooks.progress(totals, totals.steps_expected);
  }
  return std::move(totals);
}

}  // namespace foldproof
