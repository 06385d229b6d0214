#include "check/horizon.h"

#include <algorithm>
#include <cmath>

#include "check/running_mean.h"

namespace foldproof {
namespace {

// Farther ahead there is little left to save.
constexpr double kMostSteps = 32;
// Where trying to look ahead begins.
constexpr double kFewSteps = 4;
// What the first run is taken to be, once it goes on at all.
constexpr double kFirstRun = 12;
// What looking ahead costs on top: charts are drawn for poses that may never come.
constexpr double kSurely = 1.25;

}  // namespace

void Horizon::note_bend(double off, double steps) {
  constexpr double kMost = 1;  // as good as any more, and soon forgotten
  const double now = off / (steps * steps / 2);
  bend_ = std::max(0.8 * bend_, std::min(now, kMost));
}

void Horizon::served(double off, double steps) {
  ++run_;
  ++served_;
  turns_ = 0;
  if (steps >= 1) note_bend(off, steps);
}

// A turn is a step that strays farther than bending explains. When all do, the motion bends.
double Horizon::expect(double off, double steps) {
  if (steps >= 1 && off <= std::max(kSlack, bend_ * steps * steps)) {
    ++run_;
    turns_ = 0;
    note_bend(off, steps);
    return std::max((usual_run_ > 0 ? usual_run_ : kFirstRun) - run_, run_);
  }
  usual_run_ = usual_run_ > 0 ? (usual_run_ + 3 * run_) / 4 : run_;
  run_ = 1;
  if (++turns_ >= 3 && steps >= 1) note_bend(off, steps);
  return usual_run_;
}

Index Horizon::search(double off, double steps, double sensible) {
  if (promised_ > 1) {
    trust_ = (trust_ + std::min(1.0, served_ / promised_)) / 2;
  } else {
    trust_ += (1 - trust_) / 32;
  }
  promised_ = served_ = 1;
  if (steps < 0) return 1;
  const double expected = expect(off, steps);
  // A course that bends leaves the slack when bend * steps^2 / 2 is kSlack; half of that, for it may bend
  // more.
  const double until = bend_ > 0 ? std::sqrt(kSlack / bend_) : kMostSteps;
  const double most = std::ceil(std::min({until, expected, farthest_, sensible})), serves = trust_ * most;
  const double effort = ahead_ > 0 ? ahead_ * std::max(1.0, std::sqrt(most / ahead_steps_)) : 2 * alone_;
  if (serves >= 2 && kSurely * effort / serves < alone_) promised_ = most;
  return static_cast<Index>(promised_);
}

// Farther only by and by: a search for too many steps may take a hundred times as long. What has not been
// done for long may have become cheaper.
void Horizon::took(double effort) {
  if (promised_ == 1) {
    add_to_mean(alone_, effort);
    ahead_ *= 0.98;
    return;
  }
  add_to_mean(ahead_, effort);
  add_to_mean(ahead_steps_, promised_);
  alone_ *= 0.98;
  if (kSurely * effort < alone_ * promised_) {
    farthest_ = std::clamp(2 * promised_, farthest_, kMostSteps);
  } else {
    farthest_ = std::max(std::min(farthest_, promised_ / 2), kFewSteps);
  }
}

}  // namespace foldproof
