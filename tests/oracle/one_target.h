/// One instruction set at a time, of those that Highway chooses among.
#pragma once

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <cinttypes>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <utility>
#include <vector>

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

/// A number for what was answered: numbers, pairs of these, lists of these.
template <class T>
std::uint64_t hash_of(const T& number) {
  return std::hash<T>()(number);
}
template <class A, class B>
std::uint64_t hash_of(const std::pair<A, B>& pair) {
  return hash_of(pair.first) * 31 + hash_of(pair.second);
}
template <class T>
std::uint64_t hash_of(const std::vector<T>& list) {
  std::uint64_t hash = list.size();
  for (const T& one : list) hash = (hash ^ hash_of(one)) * 0x9e3779b97f4a7c15 + (hash >> 29);
  return hash;
}

/// Expects the same answer of `answers` with all of them.
template <class Answers>
void expect_all_targets_agree(const Answers& answers) {
  const auto expected = answers();
  // Programs that are built for other instruction sets are held against this line (tools/same_answers.cmake).
  const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
  std::printf("answers of %s.%s: %016" PRIx64 "\n", test->test_suite_name(), test->name(), hash_of(expected));
  on_each_target([&] { EXPECT_TRUE(answers() == expected); });
}

}  // namespace foldproof::testing
