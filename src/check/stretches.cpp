#include "check/stretches.h"

#include <algorithm>
#include <cmath>

#include "check/answer.h"

namespace foldproof::internal {
namespace {

// A step is long where leaves' boxes are this many times as large as at its start.
constexpr double kLongRatio = 4;
// Stretches become longer by this factor while boxes hardly grow or leaves have few candidates, shorter while
// they have many.
constexpr double kGrowth = 3, kShortRatio = 2, kFewCandidates = 48, kManyCandidates = 384;
// F2: positions are interpolated with an error of at most 26 * 2^-53 times the largest coordinate.
constexpr double kInterpolationRounding = 0x1p-47;

// The mean displacement of all vertices; any will do.
Vec3 mean_displacement(const StepMotion& motion, Positions x0, Positions x1) {
  Vec3 sum;
  double count = 0;
  for (Index i = 0; i < motion.size(); ++i) {
    for (const Index v : motion.hierarchy(i).vertex_ids()) sum += position(x1[i], v) - position(x0[i], v);
    count += static_cast<double>(motion.hierarchy(i).vertex_ids().size());
  }
  return sum / std::max(1.0, count);
}

double largest_coordinate(Positions x0, Positions x1) {
  double largest = 0;
  for (const Positions& x : {x0, x1}) {
    for (std::size_t i = 0; i < x.size(); ++i) {
      for (const double c : x[i]) largest = std::max(largest, std::abs(c));
    }
  }
  return largest;
}

}  // namespace

bool is_long(const StepMotion& motion) {
  constexpr double kMaxExtent = 1e280;  // far from overflow
  return motion.step_extent() < kMaxExtent && motion.swept_extent_ratio() > kLongRatio;
}

// Whatever collides until the end of the last stretch is among the pairs that were tested, with the times of
// the whole step. So a collision that is no later is the earliest one, and later ones need no search
// (docs/soundness.md, F2).
Result<void> find_earliest(Pipeline& pipeline, Positions x0, Positions x1, const StepSettings& settings,
                           bool any_will_do, StepResult& out) {
  StepMotion& motion = pipeline.motion;
  const Vec3 drift = mean_displacement(motion, x0, x1);
  const double distance =
      settings.thickness + out.tolerance + kInterpolationRounding * largest_coordinate(x0, x1);
  double from = 0, length = 1, ratio = 1;
  bool is_too_long = false;
  const auto update = [&]() -> Result<void> {
    const double to = std::min({1.0, out.earliest_toi, from + length});
    pipeline.stretch.interpolate(x0, x1, {from, to}, drift);
    FOLDPROOF_TRY(motion.update(pipeline.stretch.start(), pipeline.stretch.end()));
    out.work.refits += motion.size();
    ratio = motion.swept_extent_ratio();
    is_too_long = length == 1 && ratio > kLongRatio;  // the first one: tells how long it may be
    if (!is_too_long) from = to;
    return {};
  };
  const auto search = [&]() -> Result<void> {
    return is_too_long ? Result<void>{} : pipeline.find_leaf_pairs(settings, distance, out.work);
  };
  const auto narrow = [&]() -> Result<void> {
    if (is_too_long) return {};
    NarrowStep step(settings, out.tolerance, motion.bvhs(), pipeline.broad_phase.tasks(), x0, x1);
    step.filter = pipeline.filter;
    step.earliest->store(out.earliest_toi, std::memory_order_relaxed);
    test_leaf_pairs(step, pipeline.broad_phase.leaf_pairs(), pipeline.narrow, out);
    return {};
  };
  while (from < std::min(1.0, out.earliest_toi) && !(any_will_do && out.count() > 0)) {
    const std::uint64_t before = out.work.candidates_vf + out.work.candidates_ee;
    FOLDPROOF_TRY(run_stages(out.milliseconds, update, search, narrow));
    const auto candidates = static_cast<double>(out.work.candidates_vf + out.work.candidates_ee - before);
    const double per_leaf = candidates / static_cast<double>(motion.leaf_count());
    if (is_too_long) {
      length = 1 / (ratio - 1);
    } else if (ratio < kShortRatio || per_leaf < kFewCandidates) {
      length *= kGrowth;
    } else if (per_leaf > kManyCandidates) {
      length /= 2;
    }
  }
  finish(settings, out);
  return {};
}

}  // namespace foldproof::internal
