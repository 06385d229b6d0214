#include "check/gain.h"

#include <algorithm>
#include <utility>

#include "check/running_mean.h"

namespace foldproof {
namespace {

// Steps that build charts before they are judged.
constexpr int kLearning = 3;
// The least share of the effort that certificates must save: building charts is not counted, and a chart may
// soon be out of date.
constexpr double kLeastGain = 0.2;
// For so many steps an effort without certificates counts as current.
constexpr int kFresh = 16;
// Pairs per leaf in a first step from which on charts are not worth building yet. A surface has about four, a
// leaf with itself and with its neighbours, and charts prove hardly any others. Leaves that move far have
// more of them, in proportion to how much their boxes grow, but of pairs that charts do prove.
constexpr double kDense = 10;
constexpr int kLeastBackOff = 32, kMostBackOff = 512, kBackOffGrowth = 4;

// About how many microseconds.
double effort_of(const CullingGain::Counts& c) {
  const auto n = [](std::uint64_t count) { return static_cast<double>(count); };
  return 0.015 * n(c.node_tests) + 0.25 * n(c.leaf_pairs) + 0.007 * n(c.chart_triangles) +
         0.15 * n(c.planes) + n(c.failed_planes);
}

}  // namespace

bool CullingGain::begin(bool trained) {
  const bool first = !std::exchange(begun_, true);
  used_ = (!first || trained) && back_off_ == 0;
  if (back_off_ > 0) --back_off_;
  return used_;
}

void CullingGain::took(const Counts& counts) {
  if (used_) {
    ++since_without_;
    if (++used_steps_ <= kLearning) return;
    add_to_mean(with_, effort_of(counts));
    return judge();
  }
  since_without_ = 0;
  const bool first = knows_nothing();
  add_to_mean(without_, effort_of(counts));
  const auto pairs = static_cast<double>(counts.leaf_pairs), leaves = static_cast<double>(counts.leaves);
  if (first && pairs > kDense * leaves * counts.sweep_growth) return back_off();
  if (without_ < effort_at_back_off_ / 2) back_off_ = next_back_off_ = 0;  // contact has ended
  if (back_off_ == 0 && with_ > 0) judge();
}

// Where certificates save too little compared with an effort without them that is not current, or not known,
// one step without them measures it.
void CullingGain::judge() {
  const bool known = without_ > 0;
  if (known ? with_ < (1 - kLeastGain) * without_ : since_without_ <= kFresh) {
    next_back_off_ = 0;
  } else if (since_without_ > kFresh) {
    back_off_ = 1;
  } else {
    back_off();
  }
}

void CullingGain::back_off() {
  back_off_ = std::clamp(next_back_off_, kLeastBackOff, kMostBackOff);
  next_back_off_ = kBackOffGrowth * back_off_;
  effort_at_back_off_ = without_;
  with_ = used_steps_ = 0;
}

}  // namespace foldproof
