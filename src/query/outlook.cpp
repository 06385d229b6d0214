#include "query/outlook.h"

#include <algorithm>
#include <cmath>

namespace foldproof {
namespace {

// Farther ahead there is little left to save.
constexpr double kMostSteps = 32;
// What the first run is taken to be, once it goes on at all.
constexpr double kFirstRun = 12;
// More room makes proofs fail, less serves fewer steps.
constexpr double kLeastRoom = 0x1p-10;
// What looking ahead costs on top: charts are drawn for poses that may never come.
constexpr double kSurely = 1.25;

}  // namespace

double Outlook::room_of(int kind) { return kind == 0 ? 0 : std::ldexp(kLeastRoom, kind - 1); }

// Until a bent course leaves its room: off = bend * steps^2 / 2.
double Outlook::steps_of(int kind, double expected) const {
  if (kind == 0) return 1;
  const double until = bend_ > 0 ? std::sqrt(room_of(kind) / bend_) : kMostSteps;
  return std::min({until, expected, kMostSteps});
}

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
  if (steps >= 1 && off <= std::max(kLeastRoom, bend_ * steps * steps)) {
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

void Outlook::settle() {
  if (kind_ > 0) {
    trust_ = (trust_ + std::min(1.0, served_ / promised_)) / 2;
  } else {
    trust_ += (1 - trust_) / 32;
  }
}

Outlook::Choice Outlook::search(double off, double steps) {
  settle();
  const double expected = expect(off, steps);
  // A kind that has not been tried is taken to cost a bit more than the one before.
  double effort = 0, least = 0;
  kind_ = 0;
  for (int kind = 0; kind < kKinds; ++kind) {
    effort = efforts_[kind] > 0 ? efforts_[kind] : effort * (kind == 1 ? 2 : 1.25);
    const double serves = std::max(1.0, trust_ * steps_of(kind, expected));
    if (kind > 0 && (serves < 2 || kSurely * effort / serves >= least)) continue;
    least = effort / serves;
    kind_ = kind;
  }
  promised_ = steps_of(kind_, expected);
  served_ = 1;
  return {static_cast<Index>(std::ceil(promised_)), room_of(kind_)};
}

// What has not been done for long may have become cheaper.
void Outlook::took(double effort) {
  for (double& e : efforts_) e *= 0.98;
  double& known = efforts_[kind_];
  known = known > 0 ? (known + effort) / 2 : effort;
}

}  // namespace foldproof
