#include "check/look_ahead_policy.h"

#include <algorithm>
#include <cmath>

#include "check/running_mean.h"

namespace foldproof::internal {
namespace {

// Looking farther ahead saves little more.
constexpr double kMaxSteps = 32;
// The limit at the start, and the smallest one later.
constexpr double kMinStepLimit = 4;
// The assumed number of straight steps before the first turn is seen.
constexpr double kInitialStraightSteps = 12;
// A search for several steps costs more than its counts: charts are built for poses that may never occur.
constexpr double kCostFactor = 1.25;

}  // namespace

void LookAheadPolicy::update_curvature(double deviation, double steps) {
  constexpr double kMaxCurvature = 1;  // forgotten soon, and as prohibitive as any larger one
  const double now = deviation / (steps * steps / 2);
  curvature_ = std::max(0.8 * curvature_, std::min(now, kMaxCurvature));
}

void LookAheadPolicy::note_hit(double deviation, double steps) {
  ++straight_steps_;
  ++covered_steps_;
  turns_ = 0;
  if (steps >= 1) update_curvature(deviation, steps);
}

// A step turns when it deviates by more than the curvature explains. When several steps in a row turn, the
// curvature is larger than assumed.
double LookAheadPolicy::expected_straight_steps(double deviation, double steps) {
  if (steps >= 1 && deviation <= std::max(kSlack, curvature_ * steps * steps)) {
    ++straight_steps_;
    turns_ = 0;
    update_curvature(deviation, steps);
    const double usual = mean_straight_steps_ > 0 ? mean_straight_steps_ : kInitialStraightSteps;
    return std::max(usual - straight_steps_, straight_steps_);
  }
  mean_straight_steps_ =
      mean_straight_steps_ > 0 ? (mean_straight_steps_ + 3 * straight_steps_) / 4 : straight_steps_;
  straight_steps_ = 1;
  if (++turns_ >= 3 && steps >= 1) update_curvature(deviation, steps);
  return mean_straight_steps_;
}

Index LookAheadPolicy::choose_steps(double deviation, std::optional<double> steps, double max_steps) {
  if (planned_steps_ > 1) {
    covered_share_ = (covered_share_ + std::min(1.0, covered_steps_ / planned_steps_)) / 2;
  } else {
    covered_share_ += (1 - covered_share_) / 32;
  }
  planned_steps_ = covered_steps_ = 1;
  if (!steps) return 1;
  const double straight = expected_straight_steps(deviation, *steps);
  // A curved motion leaves the slack when curvature * steps^2 / 2 is kSlack. Half of that, since the
  // curvature may grow.
  const double within_slack = curvature_ > 0 ? std::sqrt(kSlack / curvature_) : kMaxSteps;
  const double planned = std::ceil(std::min({within_slack, straight, step_limit_, max_steps}));
  const double covered = covered_share_ * planned;
  const double cost =
      multi_cost_ > 0 ? multi_cost_ * std::max(1.0, std::sqrt(planned / multi_steps_)) : 2 * single_cost_;
  if (covered >= 2 && kCostFactor * cost / covered < single_cost_) planned_steps_ = planned;
  return static_cast<Index>(planned_steps_);
}

// The limit only doubles, because a search for too many steps may cost a hundred times as much. A cost that
// has not been measured for long decays, since it may have become lower.
void LookAheadPolicy::note_cost(double cost) {
  constexpr double kDecay = 0.98;
  if (planned_steps_ == 1) {
    add_to_mean(single_cost_, cost);
    multi_cost_ *= kDecay;
    return;
  }
  add_to_mean(multi_cost_, cost);
  add_to_mean(multi_steps_, planned_steps_);
  single_cost_ *= kDecay;
  if (kCostFactor * cost < single_cost_ * planned_steps_) {
    step_limit_ = std::clamp(2 * planned_steps_, step_limit_, kMaxSteps);
  } else {
    step_limit_ = std::max(std::min(step_limit_, planned_steps_ / 2), kMinStepLimit);
  }
}

}  // namespace foldproof::internal
