/// Exhaustive loops: all floats, all instruction sets.
#pragma once

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <string>
#include <thread>
#include <vector>

#include "arithmetic/ops.h"
#include "oracle/one_target.h"

namespace foldproof::testing {

/// Calls the function on each instruction set that both this machine and the build have.
template <class Function>
void on_every_target(const Function& function) {
  const std::int64_t targets = (hwy::SupportedTargets() | HWY_EMU128 | HWY_SCALAR) & targets_of_build();
  ASSERT_NE(targets, 0);
  for (std::int64_t left = targets; left != 0; left &= left - 1) {
    const OneTarget only(left & -left);
    const std::string name = target_in_use();
    SCOPED_TRACE(name);
    ASSERT_EQ(name, hwy::TargetName(left & -left));
    function();
  }
}

/// Floats in ascending order, -0 before 0: number 0 is -infinity, the last one infinity.
inline constexpr std::uint32_t kInfinity = 0x7f800000, kFloats = 2 * kInfinity + 2;
inline float float_number(std::uint32_t i) {
  return std::bit_cast<float>(i <= kInfinity ? 0x80000000 + (kInfinity - i) : i - kInfinity - 1);
}

inline bool wants_all_floats() {
  const char* all = std::getenv("FOLDPROOF_ALL_FLOATS");
  return all != nullptr && std::string(all) == "1";
}

/// Visits floats in ascending order, from -infinity to infinity, in runs of kRun that overlap by one float.
/// With FOLDPROOF_ALL_FLOATS=1 all of them, unless `never_all`; else those within 64 of powers of two, and
/// every `stride`-th one between.
inline constexpr std::size_t kRun = 4096;
template <class Visit>
void over_floats(std::uint32_t stride, const Visit& visit, bool never_all = false) {
  static const bool all = [] {
    std::puts(wants_all_floats() ? "all floats" : "some floats; all with FOLDPROOF_ALL_FLOATS=1");
    return wants_all_floats();
  }();
  const bool everything = all && !never_all;
  std::vector<float> run;
  const auto put = [&](float x) {
    run.push_back(x);
    if (run.size() < kRun) return;
    visit(std::span<const float>(run));
    run.assign(1, x);
  };
  const auto bits_near = [](std::uint32_t bits) {
    const std::uint32_t rest = bits & 0x7fffff;
    return rest < 64 || rest > 0x7fffff - 64;
  };
  for (std::uint32_t i = 0; i < kFloats;) {
    const float x = float_number(i);
    put(x);
    const std::uint32_t bits = std::bit_cast<std::uint32_t>(x);
    if (everything || bits_near(bits)) {
      ++i;
    } else {  // stop where the next power of two is near
      const std::uint32_t rest = bits & 0x7fffff;
      const std::uint32_t left = bits >> 31 ? rest - 63 : 0x7fffff - 63 - rest;
      i += std::max(1u, std::min(stride, left));
    }
  }
  while (run.size() < kRun) run.push_back(run.back());
  visit(std::span<const float>(run));
}

/// Both signs, all exponents, mantissas at their ends and in the middle, infinities and NaN.
template <class T>
std::vector<T> edge_numbers() {
  using Bits = std::conditional_t<sizeof(T) == 8, std::uint64_t, std::uint32_t>;
  constexpr int kDigits = std::numeric_limits<T>::digits - 1;
  constexpr Bits kTop = (Bits{1} << kDigits) - 1;
  std::vector<T> numbers;
  for (Bits exponent = 0; exponent < Bits{1} << (8 * sizeof(T) - 1 - kDigits); ++exponent) {
    for (const Bits mantissa : {Bits{0}, Bits{1}, kTop / 2, kTop / 2 + 1, kTop - 1, kTop}) {
      const Bits bits = exponent << kDigits | mantissa;
      numbers.push_back(std::bit_cast<T>(bits));
      numbers.push_back(-numbers.back());
    }
  }
  return numbers;
}

/// Equal, including the sign of zero, or both NaN.
template <class T>
bool identical(T a, T b) {
  return std::memcmp(&a, &b, sizeof(T)) == 0 || (a != a && b != b);
}

}  // namespace foldproof::testing
