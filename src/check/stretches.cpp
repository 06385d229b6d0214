#include "check/stretches.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "check/answer.h"

namespace foldproof::internal {
namespace {

// A step is long where leaves' boxes are this many times as large as at its start.
constexpr double kLongRatio = 4;
// The first stretch is as long as boxes grow by this share. While a leaf has few pairs, or not many more than
// in the last stretch, the next one is longer by a factor; otherwise it is tried again, shorter by another.
// Where boxes hardly grow, shorter stretches would have as many pairs.
constexpr double kFirstGrowth = 0.5, kFewPairs = 4, kMorePairs = 2, kLonger = 2, kShorter = 4;
constexpr double kLeastGrowth = 1.0 / 16;
constexpr double kShortest = 1.0 / 256;  // is tested however many pairs it has
// F2: distances are off by at most 52 * 2^-53 times the largest coordinate.
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

double largest_coordinate(const StepMotion& motion, Positions x0, Positions x1) {
  double largest = 0;
  for (Index i = 0; i < motion.size(); ++i) {
    for (const Index v : motion.hierarchy(i).vertex_ids()) {
      for (const Positions& x : {x0, x1})
        largest = std::max(largest, position(x[i], v).cwiseAbs().maxCoeff());
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
// the whole step. So a collision that is no later is the earliest one, and later ones need no search; and
// each collision is found in the stretch that has its time (docs/soundness.md, F2).
Result<void> check_in_stretches(const Query& query, Positions x0, Positions x1, const StepSettings& settings,
                                StepResult& out) {
  Pipeline& pipeline = query.pipeline;
  StepMotion& motion = pipeline.motion;
  const Vec3 drift = mean_displacement(motion, x0, x1);
  const double distance =
      query.search_distance(settings, out) + kInterpolationRounding * largest_coordinate(motion, x0, x1);
  const auto leaves = static_cast<double>(motion.leaf_count());
  double from = 0, to = 0, length = 1, pairs = 0, last_pairs = 0, ratio = 1;
  bool is_first = true, is_too_long = false;
  UndecidedPairs undecided;
  const auto end = [&] { return settings.earliest_only ? std::min(1.0, out.earliest_toi) : 1.0; };
  const auto update = [&]() -> Result<void> {
    to = std::min(end(), from + length);
    pipeline.stretch.interpolate(motion, {x0, x1}, {from, to}, drift);
    FOLDPROOF_TRY(motion.update(pipeline.stretch.start(), pipeline.stretch.end()));
    out.work.refits += motion.size();
    ratio = motion.swept_extent_ratio();
    is_too_long = is_first && ratio > kLongRatio;
    return {};
  };
  const auto search = [&]() -> Result<void> {
    if (is_too_long) return {};
    FOLDPROOF_TRY(pipeline.find_leaf_pairs(settings, distance, out.work));
    pairs = static_cast<double>(pipeline.broad_phase.leaf_pairs().size());
    is_too_long = length > kShortest && ratio > 1 + kLeastGrowth &&
                  pairs > std::max(kFewPairs * leaves, kMorePairs * last_pairs);
    return {};
  };
  const auto narrow = [&]() -> Result<void> {
    if (is_too_long) return {};
    NarrowStep step(settings, out.tolerance, motion.bvhs(), pipeline.broad_phase.tasks(), x0, x1);
    query.set_pairs(settings, step);
    if (settings.earliest_only) {
      step.earliest->store(out.earliest_toi, std::memory_order_relaxed);
    } else {
      step.from = from;
      if (to < 1) step.to = step.ccd.latest = to;
      step.undecided = &undecided;
    }
    test_leaf_pairs(step, pipeline.broad_phase.leaf_pairs(), pipeline.narrow, out);
    from = to;
    last_pairs = pairs;
    return {};
  };
  while (from < end() && !(query.any_will_do && out.count() > 0)) {
    FOLDPROOF_TRY(run_stages(out.milliseconds, update, search, narrow));
    if (std::exchange(is_first, false) && is_too_long) {
      length = std::max(kShortest, std::min(length / kShorter, kFirstGrowth / (ratio - 1)));
    } else {
      length = is_too_long ? std::max(kShortest, length / kShorter) : kLonger * length;
    }
  }
  finish(settings, out);
  return {};
}

}  // namespace foldproof::internal
