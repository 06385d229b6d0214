/// One instruction set at a time, of those that Highway chooses among.
#pragma once

#include <gtest/gtest.h>
#include <hwy/targets.h>

namespace foldproof::testing {

/// While it lives, only this one is used.
struct OneTarget {
  explicit OneTarget(std::int64_t target) {
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  }
  ~OneTarget() {
    hwy::SetSupportedTargetsForTest(0);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  }
};

/// Calls `visit` with every instruction set of this machine in turn, plain scalar code included.
template <class Visit>
void on_each_target(const Visit& visit) {
  int targets = 0;
  const std::int64_t supported = hwy::SupportedTargets() | HWY_EMU128 | HWY_SCALAR;
  for (std::int64_t target = 1; target <= supported && target > 0; target <<= 1) {
    if ((supported & target) == 0) continue;
    const OneTarget only(target);
    SCOPED_TRACE(hwy::TargetName(target));
    visit();
    ++targets;
  }
  EXPECT_GE(targets, 2);
}

/// Expects the same answer of `answers` with all of them.
template <class Answers>
void expect_all_targets_agree(const Answers& answers) {
  const auto expected = answers();
  on_each_target([&] { EXPECT_TRUE(answers() == expected); });
}

}  // namespace foldproof::testing
