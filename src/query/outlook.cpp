#include "query/outlook.h"

#include <algorithm>
#include <cmath>

namespace foldproof {
namespace {

// Farther ahead there is little left to save.
constexpr double kMostSteps = 32;
// What the first run is taken to be, once it goes on at all.
constexpr double kFirstRun = 12;
// What looking ahead costs on top: charts are drawn for poses that may never come.
constexpr double kSurely = 1.25;

}  // namespace

void Outlook::note_bend(double off, double steps) {
  constexpr double kMost = 1;  // as good as any more, and soon forgotten
  const double now = off / (steps * steps / 2);
  bend_ = std::max(0.8 * bend_, std::min(now, kMost));
}

void Outlook::served(double off, double steps) {
  ++run_;
  ++served_;
  turns_ = 0;
  if (steps >= 1) note_bend(off, steps);
}

// A turn is a step that strays farther than bending explains. When all do, the motion bends.
double Outlook::expect(double off, double steps) {
  if (steps >= 1 && off <= std::max(kRoom, bend_ * steps * steps)) {
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

Index Outlook::search(double off, double steps) {
  if (promised_ > 1) {
    trust_ = (trust_ + std::min(1.0, served_ / promised_)) / 2;
  } else {
    trust_ += (1 - trust_) / 32;
  }
  const double expected = expect(off, steps);
  // A course that bends leaves the room when bend * steps^2 / 2 is kRoom; half of that, for it may bend more.
  const double until = bend_ > 0 ? std::sqrt(kRoom / bend_) : kMostSteps;
  const double most = std::min({until, expected, kMostSteps}), serves = trust_ * most;
  const double ahead = ahead_ > 0 ? ahead_ : 2 * alone_;
  const bool pays = serves >= 2 && kSurely * ahead / serves < alone_;
  promised_ = pays ? std::ceil(most) : 1;
  served_ = 1;
  return static_cast<Index>(promised_);
}

// What has not been done for long may have become cheaper.
void Outlook::took(double effort) {
  double &known = promised_ > 1 ? ahead_ : alone_, &other = promised_ > 1 ? alone_ : ahead_;
  known = known > 0 ? (known + effort) / 2 : effort;
  other *= 0.98;
}

}  // namespace foldproof
