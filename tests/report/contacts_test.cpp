// Contacts of a motion's check: times, marks, and what is not known.
#include <gmock/gmock.h>

#include "report/joined.h"
#include "report/sinking_triangle.h"
#include "report/spheres.h"

namespace foldproof {
namespace {

using namespace foldproof::testing;
using ::testing::Each;

/// Marks of the faces after each frame.
struct Marks : ReportWriter {
  struct Seen {
    std::vector<std::vector<std::int32_t>> number;
    std::vector<std::vector<float>> depth;
  };
  Marks(Motions motions, Seen& seen) : motions(motions), joined(*join(motions, "test")), seen(seen) {}
  Result<void> start(const CheckedStep& pose) override { return step(pose); }
  Result<void> step(const CheckedStep& step) override {
    if (!step.contacts) return {};
    marks.update(joined, motions, step);
    seen.number.push_back(marks.number);
    seen.depth.push_back(marks.depth);
    return {};
  }
  Result<void> finish(const CheckTotals&) override { return {}; }
  Motions motions;
  JoinedMesh joined;
  InsideMarks marks;
  Seen& seen;
};

CheckTotals check(Motions motions, const CheckSettings& settings, Marks::Seen& seen) {
  std::vector<std::unique_ptr<ReportWriter>> writers;
  writers.push_back(std::make_unique<Marks>(motions, seen));
  return run_check(motions, settings, writers).value();
}

TEST(MotionContacts, MarkWhatCrossesAndWhatIsInside) {
  const auto motions = list(two_spheres(1.03));
  Marks::Seen seen;
  const CheckTotals totals = check(motions, {}, seen);
  ASSERT_EQ(totals.contacts.size(), 1u);
  const Contact& contact = totals.contacts[0];
  ASSERT_EQ(seen.number.size(), motions[0]->frame_count());
  for (std::size_t frame = 0; frame < seen.number.size(); ++frame) {
    std::size_t marked = 0;
    for (std::size_t face = 0; face < seen.number[frame].size(); ++face) {
      marked += seen.number[frame][face] == 1;
      EXPECT_EQ(seen.depth[frame][face],
                seen.number[frame][face] == 1 ? static_cast<float>(*contact.frames[frame].depth) : 0);
    }
    EXPECT_EQ(marked, contact.frames[frame].triangles);
  }
}

TEST(MotionContacts, NothingIsMarkedWhereNothingCrosses) {
  Marks::Seen seen;
  const CheckTotals totals = check(list(two_spheres(2.5)), {}, seen);
  EXPECT_TRUE(totals.contacts_found);
  EXPECT_TRUE(totals.contacts.empty());
  for (const auto& number : seen.number) EXPECT_THAT(number, Each(0));
}

TEST(MotionContacts, TimesAreFramesAndPartsOfThem) {
  Marks::Seen seen;
  CheckSettings settings;
  settings.frames = *parse_frame_range("::2");
  settings.substeps = 4;
  const CheckTotals whole = check(list(sinking_triangle(kSinking)), {}, seen),
                    parts = check(list(sinking_triangle(kSinking)), settings, seen);
  ASSERT_FALSE(whole.contacts.empty());
  ASSERT_FALSE(parts.contacts.empty());
  for (const Contact& contact : parts.contacts) {
    for (const ContactFrame& frame : contact.frames) EXPECT_EQ(2 * frame.time, std::round(2 * frame.time));
    EXPECT_LE(contact.last_time, 4);
  }
}

TEST(MotionContacts, AreNotLookedForWhereAnswersAreNotComplete) {
  Marks::Seen seen;
  CheckSettings settings;
  settings.step.earliest_only = true;
  EXPECT_FALSE(check(list(sinking_triangle(kSinking)), settings, seen).contacts_found);
  settings.step.earliest_only = false;
  settings.contacts = false;
  EXPECT_FALSE(check(list(sinking_triangle(kSinking)), settings, seen).contacts_found);
  EXPECT_TRUE(seen.number.empty());
}

// A limit that lists nothing, of pairs or of crossings.
TEST(MotionContacts, SayOfHowManyFramesNothingIsKnown) {
  Marks::Seen seen;
  CheckSettings settings;
  settings.step.max_listed = 3;
  const auto motions = list(two_spheres(1.03));
  const CheckTotals totals = check(motions, settings, seen);
  EXPECT_EQ(totals.contact_unknown_frames, motions[0]->frame_count());
  settings.step.max_listed = CheckSettings().step.max_listed;
  settings.steps_only = true;
  EXPECT_EQ(check(motions, settings, seen).contact_unknown_frames, motions[0]->frame_count());
}

TEST(MotionContacts, ListASinglePoseOnce) {
  Marks::Seen seen;
  CheckSettings settings;
  const auto motions = list(two_spheres(1.03, 1));
  const CheckTotals totals = check(motions, settings, seen);
  ASSERT_EQ(totals.contacts.size(), 1u);
  EXPECT_EQ(totals.contacts[0].frames.size(), 1u);
  settings.step.max_listed = 3;
  EXPECT_EQ(check(motions, settings, seen).contact_unknown_frames, 1u);
}

}  // namespace
}  // namespace foldproof
