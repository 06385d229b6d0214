#include <fmt/format.h>
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "report/sinking_triangle.h"
#include "report/spheres.h"

namespace foldproof {
namespace {

using namespace foldproof::testing;
using nlohmann::json;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

using WriterList = std::vector<std::unique_ptr<ReportWriter>>;

WriterList one(Result<std::unique_ptr<ReportWriter>> writer) {
  WriterList writers;
  EXPECT_TRUE(writer) << writer.error().line();
  if (writer) writers.push_back(std::move(*writer));
  return writers;
}

CheckSettings poses() {
  CheckSettings settings;
  settings.poses = true;
  return settings;
}

json json_of(Motions motions, const CheckSettings& settings, bool pairs) {
  const TemporaryDirectory directory;
  const auto writers = one(json_report(directory / "report.json", motions, {settings, {}, pairs}));
  EXPECT_TRUE(run_check(motions, settings, writers));
  return json::parse(read_file(directory / "report.json"));
}

std::vector<std::string> keys(const json& object) {
  std::vector<std::string> keys;
  for (const auto& item : object.items()) keys.push_back(item.key());
  return keys;  // sorted, as nlohmann::json keeps them
}

TEST(JsonReport, HasTheFieldsThatReadersRelyOn) {
  const json report = json_of(list(sinking_triangle(kSinking, "name with \"quotes\"")), {}, true);
  EXPECT_THAT(keys(report), ElementsAre("clean", "contacts", "foldproof", "objects", "settings", "start",
                                        "steps", "totals", "verdict"));
  for (const json& contact : report["contacts"]) {
    EXPECT_THAT(keys(contact),
                ElementsAre("at_least", "box", "curves", "depth", "first_time", "folded", "frames",
                            "from_start", "group", "healed", "joined", "last_time", "named", "normal",
                            "number", "often", "pairs", "pierces", "point", "sides", "touching", "worst"));
  }
  EXPECT_EQ(report["foldproof"], version());
  EXPECT_EQ(
      report["objects"],
      json::parse(
          R"([{"name":"name with \"quotes\"","vertices":6,"triangles":2,"frames":5,"merged":0,"model":null}])"));
  EXPECT_EQ(report["clean"], false);
  ASSERT_EQ(report["steps"].size(), 4u);
  for (const json& step : report["steps"]) {
    EXPECT_THAT(keys(step), ElementsAre("collisions", "earliest_toi", "frame", "inside", "milliseconds",
                                        "pairs", "substep", "work"));
    EXPECT_THAT(keys(step["collisions"]), ElementsAre("ee", "vf"));
    EXPECT_THAT(keys(step["milliseconds"]), ElementsAre("narrow", "total", "traverse", "update"));
    EXPECT_THAT(keys(step["work"]),
                ElementsAre("candidates_ee", "candidates_vf", "certificate_passes", "certificate_tests",
                            "leaf_pairs", "node_tests", "refits", "undecided"));
    EXPECT_THAT(keys(step["pairs"]), ElementsAre("ee", "vf"));
  }
  const json& hit = report["steps"][1];
  EXPECT_EQ(hit["frame"], 1);
  EXPECT_EQ(hit["substep"], 0);
  EXPECT_EQ(hit["collisions"], json::parse(R"({"vf":1,"ee":0})"));
  ASSERT_EQ(hit["pairs"]["vf"].size(), 1u);
  const json& pair = hit["pairs"]["vf"][0];  // object, vertex, object, face, toi
  ASSERT_EQ(pair.size(), 5u);
  EXPECT_EQ((std::vector<int>{pair[0], pair[1], pair[2], pair[3]}), (std::vector<int>{0, 3, 0, 0}));
  EXPECT_EQ(pair[4], hit["earliest_toi"]);
  EXPECT_EQ(report["steps"][0]["earliest_toi"], 1);
  const json& totals = report["totals"];
  EXPECT_EQ(totals["steps"], 4);
  EXPECT_EQ(totals["steps_with_collisions"], 2);
  EXPECT_EQ(totals["collisions"], json::parse(R"({"vf":3,"ee":0})"));
  EXPECT_EQ(totals["earliest"]["frame"], 1);
  EXPECT_EQ(totals["worst"]["frame"], 2);
}

TEST(JsonReport, ListsPairsOnlyWhenAsked) {
  const json report = json_of(list(sinking_triangle(kSinking)), {}, false);
  ASSERT_EQ(report["steps"].size(), 4u);
  for (const json& step : report["steps"]) EXPECT_FALSE(step.contains("pairs"));
}

TEST(JsonReport, ACleanCheckHasNoEarliestAndNoWorst) {
  const json report = json_of(list(sinking_triangle({3, 2})), {}, true);
  EXPECT_EQ(report["clean"], true);
  EXPECT_TRUE(report["totals"]["earliest"].is_null());
  EXPECT_TRUE(report["totals"]["worst"].is_null());
}

TEST(JsonReport, PosesCountTriangles) {
  const json report = json_of(list(lone_floor(5), lone_triangle(kSinking)), poses(), true);
  ASSERT_EQ(report["steps"].size(), 5u);
  EXPECT_EQ(report["settings"]["static"], true);
  EXPECT_EQ(report["steps"][2]["collisions"], json::parse(R"({"vf":0,"ee":0,"tt":1})"));
  EXPECT_EQ(report["steps"][2]["pairs"], json::parse(R"({"vf":[],"ee":[],"tt":[[0,0,1,0]]})"));
  EXPECT_EQ(report["steps"][1]["pairs"]["tt"], json::array());
}

TEST(JsonReport, SaysWithWhatSettingsItWasMade) {
  CheckSettings settings;
  settings.frames = *parse_frame_range("1:-1:2");
  settings.substeps = 3;
  settings.step.thickness = 0.25;
  settings.step.within = false;
  const json report = json_of(list(lone_floor(5), lone_triangle(kSinking)), settings, false);
  EXPECT_EQ(
      report["settings"],
      json::parse(R"({"static":false,"frames":{"first":1,"last":3,"step":2},"substeps":3,"steps_only":false,
      "within":false,"between":true,"thickness":0.25,"tolerance":0.0,"first":false,"limit":10000000,"certificates":true,
      "ignore":[],"still_pairs":false,"weld":false,"seams":"by_format","points":false,"fps":24.0})"));
  EXPECT_EQ(report["steps"][2]["substep"], 2);
}

TEST(JsonReport, TheStartSaysWhatCrossesInTheFirstFrame) {
  const auto stuck = list(sinking_triangle(kSinking));
  CheckSettings from_two;
  from_two.frames = *parse_frame_range("2:4");
  const json report = json_of(stuck, from_two, true);
  EXPECT_THAT(keys(report["start"]), ElementsAre("crossings", "frame", "inside", "milliseconds", "pairs"));
  EXPECT_EQ(report["start"]["frame"], 2);
  EXPECT_EQ(report["start"]["crossings"], 1);
  EXPECT_EQ(report["start"]["pairs"], json::parse(R"({"tt":[[0,0,0,1]]})"));
  EXPECT_EQ(report["totals"]["starts_crossing"], 1);
  EXPECT_EQ(report["totals"]["steps_expected"], 1);
  EXPECT_EQ(report["totals"]["stopped"], false);
  EXPECT_FALSE(json_of(stuck, from_two, false)["start"].contains("pairs"));

  from_two.steps_only = true;
  const json steps = json_of(stuck, from_two, true);
  EXPECT_FALSE(steps.contains("start"));
  EXPECT_TRUE(steps["totals"]["starts_crossing"].is_null());
  EXPECT_EQ(steps["settings"]["steps_only"], true);
  EXPECT_TRUE(json_of(stuck, poses(), true)["totals"]["starts_crossing"].is_null());

  CheckSettings one;
  one.frames = *parse_frame_range("2");
  const json alone = json_of(stuck, one, true);
  EXPECT_EQ(alone["steps"].size(), 1u);
  EXPECT_EQ(alone["clean"], false);
}

TEST(JsonReport, ANameNeedNotBeUtf8) {
  const json report = json_of(list(sinking_triangle(kSinking, "caf\xe9\n.obj")), {}, false);
  EXPECT_EQ(report["objects"][0]["name"], "caf\xef\xbf\xbd\n.obj");
}

// The step from frame 2 has two collisions, that from frame 1 has one.
TEST(Reports, SayWhereALimitLeftSomeOut) {
  CheckSettings settings;
  settings.step.max_listed = 1;
  const json report = json_of(list(sinking_triangle(kSinking)), settings, true);
  EXPECT_EQ(report["settings"]["limit"], 1);
  EXPECT_FALSE(report["steps"][1].contains("listed"));
  EXPECT_EQ(report["steps"][2]["collisions"], json::parse(R"({"vf":2,"ee":0})"));
  EXPECT_EQ(report["steps"][2]["listed"], json::parse(R"({"vf":1,"ee":0})"));
  EXPECT_EQ(report["steps"][2]["pairs"]["vf"].size(), 1u);
  EXPECT_EQ(report["totals"]["collisions"], json::parse(R"({"vf":3,"ee":0})"));
  EXPECT_EQ(report["totals"]["listed"], json::parse(R"({"vf":2,"ee":0})"));
  const TemporaryDirectory directory;
  EXPECT_TRUE(run_check(list(sinking_triangle(kSinking)), settings, one(csv_report(directory / "a.csv"))));
  const std::string rows = read_file(directory / "a.csv");
  EXPECT_THAT(rows, HasSubstr("\n# frame 2 substep 0: listed 1 of 2\n2,0,vf,"));
  EXPECT_THAT(rows, ::testing::Not(HasSubstr("# frame 1")));
}

TEST(Reports, LeaveNoFileUnlessFinished) {
  const TemporaryDirectory directory;
  const auto motions = list(sinking_triangle(kSinking));
  {
    WriterList writers;
    writers.push_back(std::move(*json_report(directory / "a.json", motions, {})));
    writers.push_back(std::move(*csv_report(directory / "a.csv")));
    writers.push_back(std::move(*ply_report(directory / "a.ply", motions, {})));
    const std::atomic<bool> stop = true;
    EXPECT_TRUE(run_check(motions, {}, writers, {.progress = {}, .cancel = &stop})->cancelled);
  }
  EXPECT_THAT(directory.names(), IsEmpty());
}

TEST(Reports, LeaveNoneOfTheirFilesUnlessFinished) {
  const TemporaryDirectory directory;
  const auto motions = list(sinking_triangle(kSinking));
  {
    std::atomic<bool> stop = false;
    const auto after_collisions = [&](const CheckTotals& totals, std::uint64_t) {
      stop = totals.steps_with_collisions > 0;
    };
    const auto totals = run_check(motions, {}, one(ply_report(directory / "a%d.ply", motions, {})),
                                  {.progress = after_collisions, .cancel = &stop});
    ASSERT_TRUE(totals);
    EXPECT_TRUE(totals->cancelled);
    EXPECT_EQ(totals->steps_with_collisions, 1u);
  }
  EXPECT_THAT(directory.names(), IsEmpty());
}

TEST(Reports, SayAtOnceThatAFileCannotBeWritten) {
  const auto motions = list(sinking_triangle(kSinking));
  EXPECT_FALSE(json_report("/nowhere/a.json", motions, {}));
  EXPECT_FALSE(csv_report("/nowhere/a.csv"));
  EXPECT_FALSE(ply_report("/nowhere/a.ply", motions, {}));
  EXPECT_FALSE(ply_report("/nowhere/a%d.ply", motions, {}));
}

TEST(CsvReport, HasARowPerCollision) {
  const TemporaryDirectory directory;
  const auto motions = list(sinking_triangle(kSinking));
  ASSERT_TRUE(run_check(motions, {}, one(csv_report(directory / "a.csv"))));
  const std::string text = read_file(directory / "a.csv");
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 4);
  EXPECT_THAT(text,
              HasSubstr("frame,substep,kind,object_a,a0,a1,object_b,b0,b1,toi,answer\n1,0,vf,0,3,,0,0,,0."));
  EXPECT_THAT(text, HasSubstr(",hit\n2,0,vf,0,4,,0,0,,0."));

  ASSERT_TRUE(run_check(motions, poses(), one(csv_report(directory / "b.csv"))));
  EXPECT_EQ(read_file(directory / "b.csv"),
            "frame,substep,kind,object_a,a0,a1,object_b,b0,b1,toi,answer\n2,0,tt,0,0,,0,1,,,crossing\n");
}

TEST(CsvReport, WhatCrossesInTheFirstFrameComesFirst) {
  const TemporaryDirectory directory;
  const auto motions = list(sinking_triangle({-0.4, -1.4}));
  ASSERT_TRUE(run_check(motions, {}, one(csv_report(directory / "a.csv"))));
  EXPECT_THAT(read_file(directory / "a.csv"), HasSubstr("answer\n0,0,tt,0,0,,0,1,,,crossing\n0,0,vf,0,4,"));
}

TEST(CsvReport, EdgePairsNameTheirVertices) {
  // Two triangles standing upright at right angles; one falls so that only the long edges cross.
  const std::vector<double> x0 = {-1, 0, 0, 1, 0, 0, 0, 0, -1, 0, -1, 1, 0, 1, 1, 0, 0, 2};
  std::vector<double> x1 = x0;
  for (int v = 3; v < 6; ++v) x1[v * 3 + 2] -= 1.5;
  const auto motions = list(memory_motion("edges", *Topology::make(6, {{0, 1, 2}, {3, 4, 5}}), {x0, x1}));
  const TemporaryDirectory directory;
  ASSERT_TRUE(run_check(motions, {}, one(csv_report(directory / "a.csv"))));
  EXPECT_THAT(read_file(directory / "a.csv"), HasSubstr("0,0,ee,0,0,1,0,3,4,0.66"));
}

TEST(PlyReport, ShowsTheFrameInWhichSomethingIsInside) {
  const TemporaryDirectory directory;
  // A third triangle far away takes part in nothing.
  std::vector<std::vector<double>> frames;
  for (const double height : kSinking) {
    frames.push_back(sinking_frame(height));
    frames.back().insert(frames.back().end(), {99, 0, 0, 99, 1, 0, 99, 0, 1});
  }
  const auto motions =
      list(memory_motion("three", *Topology::make(9, {{6, 7, 8}, {3, 4, 5}, {0, 1, 2}}), frames));
  ASSERT_TRUE(run_check(motions, {}, one(ply_report(directory / "a.ply", motions, {}))));
  EXPECT_THAT(directory.names(), ElementsAre("a.ply"));
  EXPECT_THAT(read_marks(directory / "a.ply", 3),
              ElementsAre(0, 3, 3));  // and meets more on the way to the next

  const std::string path[] = {directory / "a.ply"};
  const auto written = open_motions(path);
  ASSERT_TRUE(written) << written.error().line();
  EXPECT_EQ(written->front()->topology(), motions[0]->topology());
  std::vector<double> positions(27);
  ASSERT_TRUE(written->front()->read_frame(0, positions));
  EXPECT_NEAR(positions[3 * 3 + 2], kSinking[2], 1e-6);
}

TEST(PlyReport, HasTheContactsOfTheFrameAtWhichItsStepStarts) {
  const TemporaryDirectory directory;
  const auto motions = list(two_spheres(1.03));
  ASSERT_TRUE(run_check(motions, {}, one(ply_report(directory / "a%d.ply", motions, {}))));
  const std::string first = directory / directory.names().front(), bytes = read_file(first);
  EXPECT_THAT(bytes,
              HasSubstr("\nproperty uchar mark\nproperty int contact\nproperty float contact_depth\n"));
  const std::size_t faces = motions[0]->topology().triangles().size();
  for (std::size_t face = 0; face < faces; ++face) {
    std::int32_t contact = 0;
    float depth = 0;
    const char* record = bytes.data() + bytes.size() - 22 * (faces - face);
    std::memcpy(&contact, record + 14, 4);
    std::memcpy(&depth, record + 18, 4);
    EXPECT_TRUE(contact == 0 || contact == 1) << contact;
    EXPECT_EQ(depth > 0.1, contact == 1) << depth;
    EXPECT_EQ(record[13] & 1, contact);
  }

  CheckSettings steps_only;
  steps_only.steps_only = true;
  ASSERT_TRUE(run_check(motions, steps_only, one(ply_report(directory / "b.ply", motions, steps_only))));
  EXPECT_THAT(read_file(directory / "b.ply"), Not(HasSubstr("contact")));
}

TEST(PlyReport, WithoutCollisionsShowsTheFirstPoseUnmarked) {
  const TemporaryDirectory directory;
  const auto motions = list(sinking_triangle({3, 2, 1}));
  ASSERT_TRUE(run_check(motions, {}, one(ply_report(directory / "a.ply", motions, {}))));
  EXPECT_THAT(read_marks(directory / "a.ply", 2), ElementsAre(0, 0));
}

TEST(PlyReport, MarksWhatIsInsideAndWhatMeetsWithValuesOfTheirOwn) {
  const TemporaryDirectory directory;
  // The third triangle comes down on the floor beside the sinking triangle, which sticks in it all the time.
  const auto frame = [](double height) {
    std::vector<double> x = sinking_frame(-0.4);
    x.insert(x.end(), {2, 2, height, 2.5, 2, height + 1, 2, 2.5, height + 1});
    return x;
  };
  const auto motions = list(memory_motion("three", *Topology::make(9, {{0, 1, 2}, {3, 4, 5}, {6, 7, 8}}),
                                          {frame(0.7), frame(0.6), frame(-0.3)}));
  ASSERT_TRUE(run_check(motions, {}, one(ply_report(directory / "a.ply", motions, {}))));
  EXPECT_THAT(read_marks(directory / "a.ply", 3), ElementsAre(1, 1, 1));
  ASSERT_TRUE(run_check(motions, {}, one(ply_report(directory / "n%d.ply", motions, {}))));
  EXPECT_THAT(directory.names(), ElementsAre("a.ply", "n0.ply", "n1.ply", "n2.ply"));
  EXPECT_THAT(read_marks(directory / "n0.ply", 3), ElementsAre(1, 1, 0));
  EXPECT_THAT(read_marks(directory / "n1.ply", 3), ElementsAre(3, 1, 2));
  EXPECT_THAT(read_marks(directory / "n2.ply", 3), ElementsAre(1, 1, 1));

  CheckSettings first_step;
  first_step.frames = *parse_frame_range("0:2");
  ASSERT_TRUE(run_check(motions, first_step, one(ply_report(directory / "b.ply", motions, first_step))));
  EXPECT_THAT(read_marks(directory / "b.ply", 3), ElementsAre(1, 1, 0));
}

TEST(PlyReport, JoinsObjectsAndMarksTheFacesOfEach) {
  const TemporaryDirectory directory;
  const auto motions = list(lone_triangle({9, 9, 9, 9, 9}), lone_floor(5), lone_triangle(kSinking));
  ASSERT_TRUE(run_check(motions, poses(), one(ply_report(directory / "a.ply", motions, poses()))));
  EXPECT_THAT(read_marks(directory / "a.ply", 3), ElementsAre(0, 1, 1));
}

TEST(PlyReport, APercentSignGivesAFilePerFrameWithMarks) {
  const TemporaryDirectory directory;
  const auto motions = list(sinking_triangle(kSinking));
  ASSERT_TRUE(run_check(motions, {}, one(ply_report(directory / "a%03d.ply", motions, {}))));
  EXPECT_THAT(directory.names(), ElementsAre("a001.ply", "a002.ply"));

  CheckSettings parts;
  parts.substeps = 10;
  ASSERT_TRUE(run_check(motions, parts, one(ply_report(directory / "b%d.ply", motions, parts))));
  // Hit at 0.6 of frame 1 and of frame 2: where parts 5 and 6 meet, so one or both of them. It crosses
  // between.
  for (int k = 17; k <= 25; ++k)
    EXPECT_THAT(directory.names(), ::testing::Contains(fmt::format("b{}.ply", k)));
  for (const std::string& name : directory.names()) {
    if (name[0] == 'b') {
      EXPECT_TRUE(name >= "b15.ply" && name <= "b26.ply") << name;
    }
  }
}

TEST(PlyReport, RefusesOtherPercentSigns) {
  const auto motions = list(sinking_triangle(kSinking));
  for (const char* path :
       {"a%s.ply", "a%", "a%%d.ply", "a%d%d.ply", "a%4d.ply", "a%099d.ply", "a%04.ply", "a%-3d.ply"}) {
    EXPECT_FALSE(ply_report(path, motions, {})) << path;
  }
}

}  // namespace
}  // namespace foldproof
