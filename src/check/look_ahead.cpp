#include "check/look_ahead.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "check/answer.h"

namespace foldproof {
namespace {

// The least slack in the frame, well above its resolution.
constexpr double kLeastInFrame = 0x1p-16;
// What moves less than this, in mean lengths of an edge, stands still.
constexpr double kStill = 0x1p-10;
// Nothing is followed farther than this share of the scene: straight on from there lie poses that will never
// be, where everything meets everything.
constexpr double kFarthest = 0.25;
// What rounding may take from a distance along an axis that is computed in the frame (docs/soundness.md, F1).
constexpr double kRounding = 0x1p-20;
constexpr double kAlongAxis = 0.577;  // less than 1 / sqrt(3)

// About how many microseconds a search takes.
double effort_of(const Work& work, bool ahead) {
  const auto n = [](std::uint64_t count) { return static_cast<double>(count); };
  const double candidates = n(work.candidates_vf + work.candidates_ee);
  return 0.02 * n(work.node_tests) + 0.3 * n(work.certificate_tests) + (ahead ? 3 : 1) * n(work.leaf_pairs) +
         0.03 * candidates;
}

}  // namespace

bool LookAhead::same_search(const StepSettings& settings) const {
  return settings.within == settings_.within && settings.between == settings_.between &&
         settings.thickness == settings_.thickness && settings.tolerance == settings_.tolerance &&
         settings.ahead == settings_.ahead && settings.certificates == settings_.certificates &&
         settings.mode == settings_.mode && !settings.explain;
}

LookAhead::Plan LookAhead::plan(const StepMotion& motion, Positions x0, Positions x1,
                                const StepSettings& settings) {
  // Invalid until the next search is made: an update that fails leaves a motion that nobody searched.
  const bool was_valid = std::exchange(search_valid_, false);
  if (!was_valid || !same_search(settings) || !motion.fits(x0, x1)) return {};
  const StepMotion::Course course = motion.course_of(x0, x1);
  float most = course.off;
  for (int end = 0; end < 2; ++end) times_[end] = std::clamp(course.times[end], 0.f, 1.f);
  const double steps = steps_ * course.times[1];
  constexpr float kLate = 1.01f;  // times are rounded; what is later is another step's
  if (steps_ > 1 && most <= slack_ && course.times[1] < kLate) {
    const KineticTree::Strayed strayed = motion.stray(x0, x1, times_);
    const double side = largest_extent(strayed.bounds);
    most = strayed.bounds.finite ? strayed.most : std::numeric_limits<float>::infinity();
    if (most <= slack_ && settings.thickness + tolerance_for(settings, side) <= distance_) {
      horizon_.served(most / edge_, steps);
      search_valid_ = true;
      return {0, side};
    }
  }
  // The same step again, or a part of it, goes nowhere, unless everything stands still.
  const bool stands = course.way < kStill * edge_;
  const bool onwards = steps_ * course.times[0] > 0.5 && course.times[1] > course.times[0];
  const bool again = !stands && !onwards && most <= kSlack * edge_;
  const double sensible = kFarthest * motion.largest_side() * motion.frame().scale / course.stride;
  const double since = again ? -1 : std::max(steps, stands ? 1.0 : 0.0);
  return {horizon_.search(most / edge_, since, sensible)};
}

// Gives the distance, mesh units, below which pairs are to be found.
double LookAhead::begin(const StepMotion& motion, const StepSettings& settings, double distance) {
  const double scale = motion.frame().scale, edge = motion.mean_edge();
  settings_ = settings;
  edge_ = std::max(edge * scale, 0x1p-20);
  steps_ = motion.ahead();
  distance_ = distance;
  slack_ = 0;
  if (motion.ahead() == 1) return distance;
  const double slack = std::max(kSlack * edge, kLeastInFrame / scale);
  slack_ = static_cast<float>(slack * scale * kAlongAxis - kRounding);
  times_[0] = 0;
  times_[1] = static_cast<float>(1 / steps_);
  distance_ = settings.thickness + tolerance_for(settings, motion.reach() + 2 * slack);
  const double reach = distance_ + 2 * slack;
  reach_ = reach * scale * (1 + 0x1p-40);
  return reach;
}

Result<void> LookAhead::search(Pipeline& pipeline, Positions x0, Positions x1, const StepSettings& settings,
                               double distance, Work& work) {
  const double reach = begin(pipeline.motion, settings, distance);
  if (auto ok = pipeline.find_leaf_pairs(x0, x1, settings, reach, work); !ok) return ok;
  const BroadPhase& found = pipeline.broad_phase;
  if (slack_ > 0) candidates_.gather(found.tasks(), found.leaf_pairs(), reach_, pipeline.chunks);
  search_valid_ =
      settings.ahead && settings.certificates && settings.mode == Mode::Proven && !settings.explain;
  return {};
}

void LookAhead::test(const NarrowStep& step, Pipeline& pipeline, Stopwatch& watch, StepResult& out) {
  if (slack_ > 0) {
    candidates_.test(step, times_, pipeline.chunks, out);
  } else {
    test_leaf_pairs(step, pipeline.broad_phase.leaf_pairs(), pipeline.chunks, watch, out);
  }
  if (out.searched != 0) horizon_.took(effort_of(out.work, steps_ > 1));
}

}  // namespace foldproof
