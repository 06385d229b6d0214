// The assumptions about conversions between number types, over all floats.
#include "arithmetic/everything.h"
#include "reduced/pose.h"

namespace foldproof::testing {
namespace {

// B4: cells on a grid. The integer part, saturated beyond the range of integers, so the cell is monotone.
TEST(Conversions, FloatToIntTruncatesAndSaturates) {
  on_every_target([] {
    std::vector<std::int32_t> to(kRun);
    std::uint64_t wrong = 0;
    over_floats(251, [&](std::span<const float> from) {
      float_to_int(from, to);
      for (std::size_t i = 0; i < from.size(); ++i) {
        const double x = std::max(-0x1p31, std::min(double{from[i]}, 0x1p31 - 1));
        wrong += to[i] != static_cast<std::int32_t>(x);
      }
    });
    EXPECT_EQ(wrong, 0u);
  });
}

// B4: a number that fits a byte is unchanged. Nothing is assumed of others: some instruction sets convert
// 32768 to 0.
TEST(Conversions, IntToByteKeepsWhatFits) {
  on_every_target([] {
    for (int offset = 0; offset < 8; ++offset) {  // each number in each lane
      std::vector<std::int32_t> from(264);
      for (int i = 0; i < 264; ++i) from[i] = (i + offset) % 256;
      std::vector<std::uint8_t> to(264);
      int_to_byte(from, to);
      for (int i = 0; i < 264; ++i) ASSERT_EQ(to[i], from[i]);
    }
  });
}

// B2: rounding to the frame, |y| < 1. To the nearest float, ties to even, denormals included; beyond the
// largest float to it or to infinity, depending on the instruction set. At every float, and at and next to
// the midpoint of every two.
TEST(Conversions, DoubleToFloatRoundsToNearestEven) {
  constexpr float kMax = std::numeric_limits<float>::max();
  on_every_target([] {
    std::vector<double> inputs(4 * kRun);
    std::vector<float> expected(4 * kRun), to(4 * kRun);
    std::uint64_t wrong = 0;
    over_floats(251, [&](std::span<const float> from) {
      for (std::size_t i = 0; i < kRun; ++i) {
        const auto bits = std::bit_cast<std::uint32_t>(from[i]) & 0x7fffffff;
        const float here = std::bit_cast<float>(bits), next = std::bit_cast<float>(bits + 1);
        const bool last = here >= kMax;
        const double middle = last ? here : (double{here} + next) / 2;
        const auto m = std::bit_cast<std::uint64_t>(middle);
        const double numbers[4] = {here, middle, std::bit_cast<double>(m - 1), std::bit_cast<double>(m + 1)};
        const float nearest[4] = {here, bits % 2 == 0 ? here : next, here, next};
        for (int k = 0; k < 4; ++k) {
          inputs[4 * i + k] = std::copysign(last ? double{here} : numbers[k], from[i]);
          expected[4 * i + k] = std::copysign(last ? here : nearest[k], from[i]);
        }
      }
      double_to_float(inputs, to);
      for (std::size_t i = 0; i < to.size(); ++i) {
        const bool beyond = std::isinf(expected[i]) && std::abs(to[i]) == kMax;
        wrong += !identical(to[i], beyond ? std::copysign(kMax, expected[i]) : expected[i]);
      }
    });
    EXPECT_EQ(wrong, 0u);
  });
}

// A step far outside its frame (F1) never rounds to a coordinate within it.
TEST(Conversions, DoubleBeyondFloatsStaysBeyond) {
  on_every_target([] {
    std::vector<double> from;
    for (const double x : edge_numbers<double>()) {
      if (std::abs(x) > double{std::numeric_limits<float>::max()}) from.push_back(x);
    }
    while (from.size() % 8 != 0) from.push_back(from.back());
    std::vector<float> to(from.size());
    double_to_float(from, to);
    for (std::size_t i = 0; i < from.size(); ++i)
      ASSERT_GE(std::copysign(to[i], 1.f) * (std::signbit(from[i]) == std::signbit(to[i]) ? 1 : -1),
                std::numeric_limits<float>::max());
  });
}

// R5: radii are rounded down, and norms up, to the next float.
TEST(Conversions, RoundUpAndRoundDownNeverPassTheNumber) {
  std::uint64_t wrong = 0;
  const auto test = [&](double x) {
    const float up = round_up(x), down = round_down(x);
    wrong += !(double{up} >= x) + !(double{down} <= x);
    // The next floats, unless there is none.
    wrong += up > -std::numeric_limits<float>::max() && double{std::nextafter(up, -INFINITY)} >= x;
    wrong += down < std::numeric_limits<float>::max() && double{std::nextafter(down, INFINITY)} <= x;
  };
  over_floats(1009, [&](std::span<const float> from) {
    for (const float f : from) {
      const double x = f;
      for (const double direction : {-INFINITY, INFINITY}) test(std::nextafter(x, direction));
      test(x);
      test(x * (1 + 0x1p-25));
    }
  });
  for (const double x : edge_numbers<double>()) {
    if (x == x) test(x);
  }
  EXPECT_EQ(wrong, 0u);
}

// S1, S3: sides are differences of floats, exact in double.
TEST(Conversions, FloatToDoubleIsExact) {
  on_every_target([] {
    std::vector<double> to(kRun);
    std::uint64_t wrong = 0;
    over_floats(251, [&](std::span<const float> from) {
      float_to_double(from, to);
      for (std::size_t i = 0; i < from.size(); ++i) {
        // From the bits, denormals included: float x = m 2^e.
        const auto bits = std::bit_cast<std::uint32_t>(from[i]);
        const int exponent = static_cast<int>(bits >> 23 & 255);
        if (exponent == 255) {
          wrong += !identical(to[i], double{from[i]});
          continue;
        }
        const std::uint64_t m = (bits & 0x7fffff) | (exponent != 0 ? 0x800000 : 0);
        const double unit = std::bit_cast<double>(std::uint64_t(std::max(exponent, 1) - 150 + 1023) << 52);
        wrong += !identical(to[i], std::copysign(static_cast<double>(m) * unit, from[i]));
      }
    });
    EXPECT_EQ(wrong, 0u);
  });
}

}  // namespace
}  // namespace foldproof::testing
