#include "base/duration.h"

#include <gtest/gtest.h>

#include <limits>

namespace foldproof {
namespace {

TEST(Duration, IsInTheUnitThatPeopleWouldUse) {
  EXPECT_EQ(duration(0.4231), "0.42 ms");
  EXPECT_EQ(duration(12.345), "12.3 ms");
  EXPECT_EQ(duration(1670), "1.67 s");
  EXPECT_EQ(duration(61'200), "61.2 s");
  EXPECT_EQ(duration(125'000), "2 min 5 s");
  EXPECT_EQ(duration(11'520'000), "3 h 12 min");
}

TEST(Duration, NeverHasAnExponentOrSixtySeconds) {
  EXPECT_EQ(duration(999.4), "999 ms");
  EXPECT_EQ(duration(999.6), "1 s");
  EXPECT_EQ(duration(119'400), "119 s");
  EXPECT_EQ(duration(119'600), "2 min 0 s");
  EXPECT_EQ(duration(179'700), "3 min 0 s");
  EXPECT_EQ(duration(7'199'700), "2 h 0 min");
  EXPECT_EQ(duration(1e-5), "< 0.01 ms");
  EXPECT_EQ(duration(0), "0 ms");
  EXPECT_EQ(duration(std::numeric_limits<double>::infinity()), "unknown");
}

}  // namespace
}  // namespace foldproof
