// What a check says in a sentence, and which contacts are one to a person.
#include "report/verdict.h"

#include <gmock/gmock.h>

#include "report/contact_groups.h"
#include "report/sinking_triangle.h"
#include "report/spheres.h"

namespace foldproof {
namespace {

using namespace foldproof::testing;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(LengthText, HasTwoDigitsAndTheUnitThatFits) {
  EXPECT_EQ(length_text(0.06552, "m"), "6.6 cm");
  EXPECT_EQ(length_text(1.26, "m"), "1.3 m");
  EXPECT_EQ(length_text(126, "m"), "130 m");
  EXPECT_EQ(length_text(3400, "m"), "3.4 km");
  EXPECT_EQ(length_text(0.0009961, "m"), "1 mm");
  EXPECT_EQ(length_text(0.00005, "cm"), "500 nm");
  EXPECT_EQ(length_text(12, "mm"), "1.2 cm");
  EXPECT_EQ(length_text(0, "m"), "0 m");
  EXPECT_EQ(length_text(0.0655, "feet"), "0.066 feet");
  EXPECT_EQ(length_text(12345, ""), "12000");
}

/// A contact between two parts of an object that crosses from one time to another.
Contact contact_of(Index part_a, Index part_b, double first, double last, double depth) {
  Contact contact;
  contact.sides[0].part = part_a;
  contact.sides[1].part = part_b;
  contact.first_time = first;
  contact.last_time = last;
  ContactFrame frame;
  frame.time = last;
  frame.depth = depth;
  if (depth > 0) contact.frames.push_back(frame);
  return contact;
}

std::vector<std::size_t> numbers_of(const std::vector<GroupOfContact>& groups) {
  std::vector<std::size_t> numbers;
  for (const GroupOfContact& group : groups) numbers.push_back(group.number);
  return numbers;
}

TEST(DepthText, SaysWhatIsKnown) {
  ContactFrame frame;
  frame.curve_length = 0.5;
  EXPECT_EQ(depth_text(frame, "m"), "along 50 cm");
  frame.depth = 0.066;
  EXPECT_EQ(depth_text(frame, "m"), "6.6 cm");
  frame.at_least = true;
  EXPECT_EQ(depth_text(frame, ""), "at least 0.066");
}

TEST(ContactGroups, JoinTheSameTwoPartsInEitherOrder) {
  const std::vector<Contact> contacts{contact_of(0, 1, 1, 3, 9), contact_of(2, 1, 0, 9, 8),
                                      contact_of(1, 0, 5, 7, 7), contact_of(0, 1, 8, 9, 0)};
  const auto groups = group_contacts(contacts);
  ASSERT_EQ(groups.size(), 2u);
  EXPECT_THAT(groups[0].contacts, ElementsAre(0, 2, 3));
  EXPECT_EQ(how_often(groups[0]), "twice");  // the last only touches
  EXPECT_EQ(how_often(groups[1]), "");
  EXPECT_THAT(numbers_of(groups_of(contacts)), ElementsAre(0, 1, 0, 0));
  EXPECT_EQ(groups_of(contacts)[3].often, "twice");
}

TEST(ContactGroups, AtOneTimeTheyAreInSeveralPlaces) {
  const std::vector<Contact> contacts{contact_of(0, 1, 1, 5, 9), contact_of(0, 1, 4, 7, 8),
                                      contact_of(0, 1, 8, 9, 7)};
  EXPECT_EQ(how_often(group_contacts(contacts)[0]), "in 3 places");
}

TEST(ContactGroups, WithoutPartsThoseAreOneThatShareTrianglesOnBothSides) {
  std::vector<Contact> contacts;
  const std::vector<std::array<std::vector<Index>, 2>> triangles{
      {{{1, 2}, {7, 8}}}, {{{8, 9}, {2, 3}}}, {{{1, 2}, {4, 5}}}, {{{7}, {8}}}};
  for (const auto& sides : triangles) {
    contacts.push_back(contact_of(kNoIndex, kNoIndex, 0, 1, 1));
    for (std::size_t k = 0; k < 2; ++k) contacts.back().sides[k].triangles = sides[k];
  }
  // The second meets the first the other way round; the others share one side only.
  EXPECT_THAT(numbers_of(groups_of(contacts)), ElementsAre(0, 0, 1, 2));
}

CheckVerdict verdict_of(const std::vector<std::unique_ptr<Motion>>& motions,
                        const CheckSettings& settings = {}) {
  return verdict(motions, settings, run_check(motions, settings, {}).value());
}

TEST(VerdictText, SaysWhatGoesThroughWhatHowDeepAndWhen) {
  const auto motions = list(two_spheres(1.03));
  CheckSettings settings;
  const std::size_t count = motions[0]->topology().triangles().size();
  ObjectParts parts{.names = {"left", "right"}, .of_triangle = std::vector<Index>(count, 0)};
  std::fill(parts.of_triangle.begin() + count / 2, parts.of_triangle.end(), 1);
  settings.parts = {parts};
  settings.unit = "m";
  const CheckVerdict found = verdict_of(motions, settings);
  EXPECT_EQ(found.kind, CheckVerdictKind::Found);
  EXPECT_THAT(found.sentence.text(),
              ::testing::MatchesRegex(
                  "left and right go through each other, [0-9.]+ cm at worst, in frame [0-9]\\."));
  ASSERT_EQ(found.sentence.pieces().size(), 3u);
  EXPECT_TRUE(std::holds_alternative<double>(found.sentence.pieces()[1]));
  EXPECT_THAT(found.numbers, HasSubstr("Frame 0 starts with "));
  // What was left out stays named.
  settings.frames.step = 2;
  const CheckVerdict some = verdict_of(motions, settings);
  EXPECT_FALSE(some.whole);
  EXPECT_THAT(some.sentence.text(), ::testing::EndsWith("; only every 2nd frame was checked."));
}

TEST(VerdictText, AnObjectIsNamedByItsFileAndNothingIsFoundByProof) {
  EXPECT_EQ(verdict_of(list(two_spheres(2.5))).kind, CheckVerdictKind::Free);
  CheckSettings steps_only;
  steps_only.steps_only = true;
  EXPECT_EQ(verdict_of(list(two_spheres(2.5)), steps_only).kind, CheckVerdictKind::Limited);
  const auto named = [](const std::string& name) {
    return memory_motion(name, *Topology::make(3, {{0, 1, 2}}), {{0, 0, 0, 1, 0, 0, 0, 1, 0}});
  };
  const auto motions =
      list(named("a/body.obj"), named("b/body.obj"), named("b/coat.obj"), named("b/coat.ply"));
  EXPECT_EQ(short_name(0, motions), "a/body.obj");
  EXPECT_EQ(short_name(2, motions), "coat.obj");
  EXPECT_EQ(short_name(0, list(named("a/body.obj"))), "body");
}

}  // namespace
}  // namespace foldproof
