#include <gmock/gmock.h>

#include "report/report.h"

namespace foldproof {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

std::vector<Index> select(const std::string& text, Index frames) {
  const auto range = parse_frame_range(text);
  EXPECT_TRUE(range) << text << ": " << range.error().line();
  return range ? select_frames(*range, frames) : std::vector<Index>{};
}

// Every expectation is what Python gives for list(range(n))[A:B:STEP].
TEST(FrameRange, SelectsWhatAPythonSliceSelects) {
  EXPECT_THAT(select(":", 4), ElementsAre(0, 1, 2, 3));
  EXPECT_THAT(select("1:3", 5), ElementsAre(1, 2));
  EXPECT_THAT(select("3:", 5), ElementsAre(3, 4));
  EXPECT_THAT(select(":2", 5), ElementsAre(0, 1));
  EXPECT_THAT(select("-2:", 5), ElementsAre(3, 4));
  EXPECT_THAT(select(":-2", 5), ElementsAre(0, 1, 2));
  EXPECT_THAT(select("-4:-1:2", 5), ElementsAre(1, 3));
  EXPECT_THAT(select("::2", 5), ElementsAre(0, 2, 4));
  EXPECT_THAT(select("::", 2), ElementsAre(0, 1));
  EXPECT_THAT(select("0:99", 3), ElementsAre(0, 1, 2));
  EXPECT_THAT(select("-99:2", 3), ElementsAre(0, 1));
  EXPECT_THAT(select("3:1", 5), IsEmpty());
  EXPECT_THAT(select("7:", 5), IsEmpty());
  EXPECT_THAT(select("::4294967295", 5), ElementsAre(0));
  EXPECT_THAT(select("-9223372036854775808:9223372036854775807", 2), ElementsAre(0, 1));
}

TEST(FrameRange, ASingleNumberIsASingleFrame) {
  EXPECT_THAT(select("0", 5), ElementsAre(0));
  EXPECT_THAT(select("4", 5), ElementsAre(4));
  EXPECT_THAT(select("-1", 5), ElementsAre(4));
  EXPECT_THAT(select("-5", 5), ElementsAre(0));
  EXPECT_THAT(select("5", 5), IsEmpty());
  EXPECT_THAT(select("-6", 5), IsEmpty());
  EXPECT_THAT(select("9223372036854775807", 5), IsEmpty());
}

TEST(FrameRange, KnowsWhetherItSelectsAll) {
  for (const char* text : {":", "0:", "::1", "::"})
    EXPECT_TRUE(parse_frame_range(text)->selects_all()) << text;
  for (const char* text : {"1:", ":9", "::2", "0", "-1:"})
    EXPECT_FALSE(parse_frame_range(text)->selects_all()) << text;
}

TEST(FrameRange, SkipsFramesOnlyBetweenTwo) {
  CheckSettings settings;
  CheckTotals totals;
  totals.last_frame = 4;
  EXPECT_FALSE(skips_frames(settings, totals));
  settings.frames.step = 2;
  EXPECT_TRUE(skips_frames(settings, totals));
  totals.last_frame = 0;
  EXPECT_FALSE(skips_frames(settings, totals));
}

TEST(EveryNthFrame, HasTheOrdinalsOfEnglish) {
  for (const auto& [n, text] : {std::pair{2, "every 2nd frame"},
                                {3, "every 3rd frame"},
                                {4, "every 4th frame"},
                                {11, "every 11th frame"},
                                {12, "every 12th frame"},
                                {13, "every 13th frame"},
                                {21, "every 21st frame"},
                                {111, "every 111th frame"},
                                {122, "every 122nd frame"}})
    EXPECT_EQ(every_nth_frame(static_cast<Index>(n)), text);
}

TEST(FrameRange, RefusesEverythingElse) {
  for (const char* text : {"", "a", "1:b", "1:2:c", "1:2:3:4", "1.5:2", "1: 2", " 1", "+1", "1-2",
                           "99999999999999999999:", "::0", "::-1", "::4294967296", "1:2:0"}) {
    const auto range = parse_frame_range(text);
    ASSERT_FALSE(range) << "'" << text << "'";
    EXPECT_EQ(range.error().where, "--frames");
  }
}

}  // namespace
}  // namespace foldproof
