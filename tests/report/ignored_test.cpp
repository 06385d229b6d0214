// Pairs that are ignored by name, and pairs of what stands still.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "report/sinking_triangle.h"

namespace foldproof {
namespace {

using namespace foldproof::testing;
using ::testing::HasSubstr;

/// A motion with a file's name, parts, and that may stand still.
class Named final : public Motion {
 public:
  Named(std::unique_ptr<Motion> motion, std::string name, ObjectParts parts = {}, bool still = false)
      : motion_(std::move(motion)), name_(std::move(name)) {
    info_.parts = std::move(parts);
    info_.still = still;
  }
  const std::string& name() const override { return name_; }
  const Topology& topology() const override { return motion_->topology(); }
  const MotionInfo& info() const override { return info_; }
  Index frame_count() const override { return motion_->frame_count(); }
  Result<void> read_frame(Index k, std::span<double> out) override { return motion_->read_frame(k, out); }

 private:
  std::unique_ptr<Motion> motion_;
  std::string name_;
  MotionInfo info_;
};

std::unique_ptr<Motion> named(std::unique_ptr<Motion> motion, std::string name, ObjectParts parts = {},
                              bool still = false) {
  return std::make_unique<Named>(std::move(motion), std::move(name), std::move(parts), still);
}

using Pairs = std::vector<std::array<std::string, 2>>;

Result<CheckTotals> check(Motions motions, Pairs ignore, CheckSettings settings = {}) {
  settings.ignore = std::move(ignore);
  return run_check(motions, settings, {});
}

TEST(Ignore, ObjectsAndPartsByName) {
  const auto two =
      list(named(lone_triangle(kSinking), "scene/needle.obj"), named(lone_floor(5), "scene/floor.obj"));
  EXPECT_EQ(check(two, {})->collisions.sum(), 3u);
  for (const char* needle : {"scene/needle.obj", "needle.obj", "needle"}) {
    for (const char* floor : {"scene/floor.obj", "floor.obj", "floor"}) {
      EXPECT_TRUE(check(two, {{needle, floor}})->clean());
      EXPECT_TRUE(check(two, {{floor, needle}})->clean());
    }
  }
  EXPECT_EQ(check(two, {{"needle", "needle"}, {"floor", "floor"}})->collisions.sum(), 3u);

  const auto one = list(named(sinking_triangle(kSinking), "scene.npz", {{"floor", "tip"}, {0, 1}}));
  EXPECT_EQ(check(one, {{"floor", "floor"}, {"tip", "tip"}})->collisions.sum(), 3u);
  EXPECT_TRUE(check(one, {{"floor", "tip"}})->clean());
  EXPECT_TRUE(check(one, {{"scene", "scene"}})->clean());
  EXPECT_TRUE(check(one, {{"scene.npz", "tip"}})->clean());
  CheckSettings poses;
  poses.poses = true;
  EXPECT_FALSE(check(one, {}, poses)->clean());
  EXPECT_TRUE(check(one, {{"tip", "floor"}}, poses)->clean());
}

TEST(Ignore, APartOfOneObjectIsNamedWithIt) {
  const ObjectParts parts{{"floor", "tip"}, {0, 1}};
  const auto two = list(named(sinking_triangle(kSinking), "a/left.npz", parts),
                        named(lone_floor(5), "a/right.npz", {{"floor"}, {0}}));
  const auto left = [&](const char* a, const char* b) {  // the floors coincide
    return check(two, {{"floor", "floor"}, {a, b}})->collisions.sum();
  };
  ASSERT_EQ(left("tip", "tip"), 6u);  // the tip sinks into both floors
  for (const char* floor : {"a/left.npz:floor", "left.npz:floor", "left:floor"})
    EXPECT_EQ(left(floor, "tip"), 3u);
  EXPECT_EQ(left("right:floor", "left:tip"), 3u);
  EXPECT_EQ(left("floor", "tip"), 0u);
  EXPECT_THAT(check(two, {{"right:tip", "tip"}}).error().line(), HasSubstr("'right:tip': is neither"));
  const auto alike = list(named(sinking_triangle(kSinking), "a/left.npz", parts),
                          named(sinking_triangle(kSinking), "b/left.npz", parts));
  EXPECT_THAT(check(alike, {{"left:tip", "floor"}}).error().line(), HasSubstr("is a part of 2 objects"));
  // An object as it was named comes before one whose file has this name, in whatever order.
  for (const bool first : {true, false}) {
    const auto beside = list(named(sinking_triangle(kSinking), first ? "left.npz" : "b/left.npz", parts),
                             named(sinking_triangle(kSinking), first ? "b/left.npz" : "left.npz", parts));
    const Pairs others = {{"floor", "floor"}, {"tip", "tip"}, {"b/left.npz:tip", "floor"}};
    ASSERT_EQ(check(beside, others)->collisions.sum(), 6u);
    EXPECT_TRUE(check(beside, {others[0], others[1], others[2], {"left.npz:tip", "floor"}})->clean());
  }
}

TEST(Ignore, UnknownNamesListNearOnes) {
  const auto motions = list(named(sinking_triangle(kSinking), "a/scene.npz", {{"floor", "tip"}, {0, 1}}),
                            named(lone_floor(5), "b/scene.npz"));
  const auto line_of = [&](const char* name) { return check(motions, {{name, "tip"}}).error().line(); };
  EXPECT_EQ(line_of("flor"), "'flor': is neither an object nor a part of one; did you mean 'floor'?");
  EXPECT_THAT(line_of("something"), HasSubstr("give one of 'a/scene.npz', 'scene', 'floor', 'tip'"));
  EXPECT_THAT(line_of("scene"), HasSubstr("is the file name of 2 objects"));
}

TEST(Ignore, IsNamedInTheVerdictAndInJson) {
  CheckSettings settings;
  EXPECT_EQ(ignored_pairs(settings), "");
  settings.ignore = {{"floor", "tip"}, {"tip", "tip"}};
  EXPECT_EQ(ignored_pairs(settings), "pairs of floor and tip, of tip with itself were ignored");
  const auto one = list(named(sinking_triangle(kSinking), "scene.npz", {{"floor", "tip"}, {0, 1}}));
  const TemporaryDirectory directory;
  std::vector<std::unique_ptr<ReportWriter>> writers;
  writers.push_back(json_report(directory / "a.json", one, {settings, {}, false}).value());
  ASSERT_TRUE(run_check(one, settings, writers));
  const auto json = nlohmann::json::parse(read_file(directory / "a.json"));
  EXPECT_EQ(json["settings"]["ignore"], nlohmann::json::parse(R"([["floor","tip"],["tip","tip"]])"));
}

/// Two triangles that stick in a floor and stand still, as it does, and one that sinks.
std::vector<std::unique_ptr<Motion>> still_scene(const std::vector<double>& heights) {
  const std::vector<double> inside(heights.size(), -0.4);
  return list(named(lone_floor(heights.size()), "floor.obj", {}, true),
              named(lone_triangle(inside), "nail.obj", {}, true),
              named(lone_triangle(heights), "needle.npz"));
}

TEST(StillPairs, AreTestedInTheFirstFrameOnlyAndDoNotFail) {
  const auto motions = still_scene({3, 2.5, 2});
  const auto totals = check(motions, {});
  ASSERT_TRUE(totals);
  EXPECT_EQ(totals->still, (std::vector<Index>{0, 1}));
  EXPECT_EQ(totals->still_crossing, 1u);
  ASSERT_EQ(totals->still_crossings.size(), 1u);
  EXPECT_EQ(totals->still_crossings[0].object_b, 1u);
  EXPECT_EQ(totals->starts_crossing, 0u);
  EXPECT_TRUE(totals->clean());
  EXPECT_TRUE(totals->contacts.empty());
  EXPECT_EQ(still_pairs(motions, {}, *totals),
            "floor.obj and nail.obj stand still and cross each other at 1 pair of triangles");

  CheckSettings all;
  all.still_pairs = true;
  const auto more = check(motions, {}, all);
  EXPECT_TRUE(more->still.empty());
  EXPECT_EQ(more->starts_crossing, 1u);
  EXPECT_FALSE(more->clean());
  EXPECT_EQ(still_pairs(motions, all, *more), "");

  const auto ignored = check(motions, {{"floor", "nail"}});
  EXPECT_EQ(ignored->still_crossing, 0u);
}

TEST(StillPairs, DoNotHideWhatMoves) {
  const auto totals = check(still_scene(kSinking), {});
  EXPECT_GE(totals->collisions.sum(), 3u);
  EXPECT_FALSE(totals->clean());
}

// Where nothing moves, everything is tested.
TEST(StillPairs, CountWhereOnlyOneFrameIsChecked) {
  CheckSettings settings;
  settings.frames = *parse_frame_range("1");
  const auto totals = check(still_scene({3, 2.5, 2}), {}, settings);
  EXPECT_TRUE(totals->still.empty());
  EXPECT_EQ(totals->starts_crossing, 1u);
}

TEST(StillPairs, SayWhatWasNotTested) {
  const auto motions = still_scene({3, 2.5, 2});
  CheckSettings settings;
  settings.steps_only = true;
  EXPECT_EQ(still_pairs(motions, settings, *check(motions, {}, settings)),
            "floor.obj and nail.obj stand still; pairs among what stands still were not tested");
  settings.steps_only = false;
  settings.step.thickness = 0.1;
  EXPECT_EQ(
      still_pairs(motions, settings, *check(motions, {{"floor", "nail"}}, settings)),
      "floor.obj and nail.obj stand still; among what stands still nothing was tested for the thickness");
  CheckSettings poses;
  poses.poses = true;
  const auto totals = check(motions, {}, poses);
  EXPECT_TRUE(totals->clean());
  EXPECT_EQ(totals->still_crossing, 1u);
}

}  // namespace
}  // namespace foldproof
