#include "check/look_ahead.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/try.h"
#include "check/answer.h"

namespace foldproof::internal {
namespace {

// The minimum slack in the frame, well above its resolution.
constexpr double kMinSlack = 0x1p-16;
// A motion of less than this many mean edge lengths is at rest.
constexpr double kMaxRestDisplacement = 0x1p-10;
// The maximum extrapolation, as a share of the scene's extent: straight continuations beyond it lead to poses
// that will never occur, in which everything overlaps.
constexpr double kMaxExtrapolation = 0.25;
// What rounding takes from a distance along an axis in the frame (docs/soundness.md, F1).
constexpr double kRounding = 0x1p-20;
constexpr double kAlongAxis = 0.577;  // less than 1 / sqrt(3)

// Of a search, in microseconds, approximately.
double cost_of(const Work& work, bool looks_ahead) {
  const auto n = [](std::uint64_t count) { return static_cast<double>(count); };
  const double candidates = n(work.candidates_vf + work.candidates_ee);
  return 0.02 * n(work.node_tests) + 0.3 * n(work.certificate_tests) +
         (looks_ahead ? 2 : 1) * n(work.leaf_pairs) + 0.03 * candidates;
}

// The settings that a search depends on; what only its later steps ask for is as by default.
StepSettings for_search(StepSettings settings) {
  const StepSettings usual;
  settings.max_listed = usual.max_listed;
  settings.earliest_only = usual.earliest_only;
  return settings;
}

}  // namespace

LookAhead::Plan LookAhead::plan(const StepMotion& motion, Positions x0, Positions x1,
                                const StepSettings& settings) {
  // Invalid until the next search is complete: an update that fails leaves a motion without one.
  const bool was_valid = std::exchange(search_valid_, false);
  if (!was_valid || for_search(settings) != settings_ || !motion.fits(x0, x1)) return {};
  const StepMotion::StepLocation location = motion.locate(x0, x1);
  float deviation = location.deviation;  // of a sample, until all vertices are tested
  for (int end = 0; end < 2; ++end) times_[end] = std::clamp(location.times[end], 0.f, 1.f);
  const double steps = steps_ * location.times[1];
  constexpr float kMaxTime = 1.01f;  // times are rounded; a step that ends later is beyond the motion
  if (steps_ > 1 && deviation <= slack_ && location.times[1] < kMaxTime) {
    const KineticBvh::Deviation of_all = motion.deviation(x0, x1, times_);
    const double extent = largest_extent(of_all.bounds);
    deviation = of_all.bounds.finite ? of_all.max : std::numeric_limits<float>::infinity();
    if (deviation <= slack_ && settings.thickness + tolerance_for(settings, extent) <= distance_) {
      policy_.note_hit(deviation / edge_length_, steps);
      search_valid_ = true;
      return {0, extent};
    }
  }
  // A step that repeats the last one, or a part of it, tells nothing, unless everything is at rest.
  const bool rests = location.motion_displacement < kMaxRestDisplacement * edge_length_;
  const bool continues = steps_ * location.times[0] > 0.5 && location.times[1] > location.times[0];
  const bool repeats = !rests && !continues && deviation <= kSlack * edge_length_;
  const double max_steps =
      kMaxExtrapolation * motion.step_extent() * motion.frame().scale / location.step_displacement;
  const auto since_search = repeats ? std::nullopt : std::optional(std::max(steps, rests ? 1.0 : 0.0));
  return {policy_.choose_steps(deviation / edge_length_, since_search, max_steps)};
}

// Returns the distance, mesh units, within which the search must find pairs.
double LookAhead::begin_search(const StepMotion& motion, const StepSettings& settings, double distance) {
  const double scale = motion.frame().scale, edge_length = motion.mean_edge_length();
  settings_ = for_search(settings);
  edge_length_ = std::max(edge_length * scale, 0x1p-20);
  steps_ = motion.steps();
  distance_ = distance;
  slack_ = 0;
  if (motion.steps() == 1) return distance;
  const double slack = std::max(kSlack * edge_length, kMinSlack / scale);
  slack_ = static_cast<float>(slack * scale * kAlongAxis - kRounding);
  times_[0] = 0;
  times_[1] = static_cast<float>(1 / steps_);
  distance_ = settings.thickness + tolerance_for(settings, motion.motion_extent() + 2 * slack);
  const double search_distance = distance_ + 2 * slack;
  candidate_distance_ = search_distance * scale * (1 + 0x1p-40);
  return search_distance;
}

Result<void> LookAhead::search(Pipeline& pipeline, const StepSettings& settings, double distance,
                               Work& work) {
  const double search_distance = begin_search(pipeline.motion, settings, distance);
  FOLDPROOF_TRY(pipeline.find_leaf_pairs(settings, search_distance, work));
  const BroadPhase& found = pipeline.broad_phase;
  if (slack_ > 0) candidates_.fill(found.tasks(), found.leaf_pairs(), candidate_distance_);
  search_valid_ =
      settings.look_ahead && settings.certificates && settings.declared_free == nullptr && !settings.explain;
  return {};
}

void LookAhead::test(const NarrowStep& step, Pipeline& pipeline, StepResult& out) {
  if (slack_ > 0) {
    candidates_.test(step, times_, pipeline.narrow, out);
  } else {
    test_leaf_pairs(step, pipeline.broad_phase.leaf_pairs(), pipeline.narrow, out);
  }
  if (out.search_steps != 0) policy_.note_cost(cost_of(out.work, steps_ > 1));
}

}  // namespace foldproof::internal
