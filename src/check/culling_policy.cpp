#include "check/culling_policy.h"

#include <algorithm>
#include <utility>

#include "check/running_mean.h"

namespace foldproof::internal {
namespace {

// Steps that build charts before they are judged.
constexpr int kWarmUpSteps = 3;
// The minimum share of the cost that certificates must save: building charts is not counted, and a chart may
// soon be out of date.
constexpr double kMinGain = 0.2;
// A cost without certificates is up to date for this many steps.
constexpr int kMaxCostAge = 16;
// Pairs per leaf in a first step above which charts are not worth building yet. A surface has about four, a
// leaf with itself and with its neighbors, and charts prove hardly any others. Leaves that move far have more
// pairs, in proportion to the growth of their boxes, but charts do prove those.
constexpr double kDensePairsPerLeaf = 10;
constexpr int kMinBackOff = 32, kMaxBackOff = 512, kBackOffGrowth = 4;

// In microseconds, approximately.
double cost_of(const CullingPolicy::Counts& c) {
  const auto n = [](std::uint64_t count) { return static_cast<double>(count); };
  return 0.015 * n(c.node_tests) + 0.25 * n(c.leaf_pairs) + 0.007 * n(c.chart_triangles) +
         0.15 * n(c.planes) + n(c.failed_planes);
}

}  // namespace

bool CullingPolicy::begin_step(bool pay_at_once) {
  const bool first = !std::exchange(begun_, true);
  used_ = (!first || pay_at_once) && back_off_ == 0;
  if (back_off_ > 0) --back_off_;
  return used_;
}

void CullingPolicy::end_step(const Counts& counts) {
  if (used_) {
    since_without_ = std::min(since_without_ + 1, kMaxCostAge + 1);
    used_steps_ = std::min(used_steps_ + 1, kWarmUpSteps + 1);
    if (used_steps_ <= kWarmUpSteps) return;
    add_to_mean(cost_with_, cost_of(counts));
    return judge();
  }
  since_without_ = 0;
  const bool first = is_unmeasured();
  add_to_mean(cost_without_, cost_of(counts));
  const auto pairs = static_cast<double>(counts.leaf_pairs), leaves = static_cast<double>(counts.leaves);
  if (first && pairs > kDensePairsPerLeaf * leaves * counts.swept_extent_ratio) return back_off();
  if (cost_without_ < cost_at_back_off_ / 2) back_off_ = next_back_off_ = 0;  // the contact has ended
  if (back_off_ == 0 && cost_with_ > 0) judge();
}

// Where certificates seem to save too little but the cost without them is unknown or out of date, one step
// without them measures it.
void CullingPolicy::judge() {
  const bool known = cost_without_ > 0;
  if (known ? cost_with_ < (1 - kMinGain) * cost_without_ : since_without_ <= kMaxCostAge) {
    next_back_off_ = 0;
  } else if (since_without_ > kMaxCostAge) {
    back_off_ = 1;
  } else {
    back_off();
  }
}

void CullingPolicy::back_off() {
  back_off_ = std::clamp(next_back_off_, kMinBackOff, kMaxBackOff);
  next_back_off_ = kBackOffGrowth * back_off_;
  cost_at_back_off_ = cost_without_;
  cost_with_ = used_steps_ = 0;
}

}  // namespace foldproof::internal
