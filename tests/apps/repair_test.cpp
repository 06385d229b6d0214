// repair on the command line.
#include <gmock/gmock.h>

#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <thread>

#include "apps/program.h"

namespace foldproof {
namespace {

using namespace foldproof::testing;
using ::testing::HasSubstr;

/// The demo's motions, and each file's bytes.
struct Demo : Workplace {
  Demo() { EXPECT_EQ(run({"demo", "-q", "demo"}).code, 0); }
  Outcome repair(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "repair");
    return run_program(std::move(arguments), {.directory = *this / "demo"});
  }
  Outcome check(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "check");
    return run_program(std::move(arguments), {.directory = *this / "demo"});
  }
  std::string bytes(const std::string& name) const { return read_file(*this / ("demo/" + name)); }
  bool exists(const std::string& name) const { return std::filesystem::exists(*this / ("demo/" + name)); }
};

TEST(RepairProgram, WhatItWritesIsFree) {
  const Demo demo;
  ASSERT_EQ(demo.check({"walk.glb"}).code, 1);
  const Outcome done = demo.repair({"walk.glb", "-o", "fixed.npz"});
  EXPECT_EQ(done.code, 0) << done.err;
  EXPECT_THAT(done.out, HasSubstr("contacts before         2\n"));
  EXPECT_THAT(done.out, HasSubstr("Proven: nothing touches, in no frame and at no time between frames."));
  EXPECT_EQ(demo.check({"fixed.npz"}).code, 0);
  // Once more, it is as it was.
  EXPECT_EQ(demo.repair({"fixed.npz", "-o", "again.npz"}).code, 0);
  EXPECT_EQ(demo.bytes("again.npz"), demo.bytes("fixed.npz"));
  // On one thread, too.
  EXPECT_EQ(demo.repair({"walk.glb", "-q", "--threads", "1", "-o", "one.npz"}).code, 0);
  EXPECT_EQ(demo.bytes("one.npz"), demo.bytes("fixed.npz"));
}

// The file is what it was but for the morph targets that were added, and is free as it is read.
TEST(RepairProgram, WritesGltfIntoAFileLikeTheOneItCameFrom) {
  const Demo demo;
  const Outcome done = demo.repair({"walk.glb", "-o", "fixed.glb", "--json", "done.json"});
  EXPECT_EQ(done.code, 0) << done.err;
  EXPECT_EQ(demo.check({"fixed.glb"}).code, 0);
  const auto report = nlohmann::json::parse(demo.bytes("done.json"));
  EXPECT_EQ(report["verdict"]["kind"], "free");
  EXPECT_EQ(report["frames"].size(), 25);
  EXPECT_GT(report["frames"][21]["correction"], 0.005);
  EXPECT_EQ(report["before"].size(), 2);
  EXPECT_TRUE(report["remaining"].empty());
  EXPECT_FALSE(demo.exists("unchecked-fixed.glb"));
  // Of a few frames, the rest stays as it was.
  EXPECT_EQ(demo.repair({"walk.glb", "--frames", "3:7", "-q", "-o", "some.glb"}).code, 0);
  EXPECT_EQ(demo.check({"some.glb", "--frames", "3:7"}).code, 0);
}

TEST(RepairProgram, RefusesGltfOfWhatIsNone) {
  const Demo demo;
  EXPECT_THAT(demo.repair({"body.npz", "-o", "a.glb"}).err,
              HasSubstr("a.glb: is GLB, and body.npz is no glTF file; name it .npz, .obj or .ply"));
  EXPECT_THAT(demo.repair({"walk.glb", "--in-betweens", "2", "-o", "a.glb"}).err,
              HasSubstr("holds no times"));
  EXPECT_THAT(demo.repair({"walk.glb", "-o", "a.gltf"}).err,
              HasSubstr("is not a format that is written here; name it .npz, .obj, .ply or .glb"));
}

TEST(RepairProgram, PointCachesAreProvenAsTheyAreRounded) {
  const Demo demo;
  EXPECT_EQ(demo.repair({"walk.glb", "-q", "-o", "fixed.obj"}).code, 0);
  EXPECT_EQ(demo.check({"fixed.obj", "fixed.pc2"}).code, 0);
  EXPECT_EQ(demo.repair({"pose.obj", "-q", "-o", "pose-fixed.obj"}).code, 0);
  EXPECT_EQ(demo.check({"pose-fixed.obj"}).code, 0);
  EXPECT_FALSE(demo.exists("pose-fixed.pc2"));
}

// It starts in a training pose of the model, which is free, instead of one in which what crosses was
// smoothed.
TEST(RepairProgram, AModelKnowsWhereToStart) {
  const Demo demo;
  const Outcome done = demo.repair({"pose.obj", "--model", "body.model", "-o", "fixed.npz"});
  EXPECT_EQ(done.code, 0) << done.err;
  EXPECT_EQ(demo.check({"fixed.npz"}).code, 0);
  EXPECT_EQ(demo.repair({"pose.obj", "-q", "-o", "untangled.npz"}).code, 0);
  EXPECT_NE(demo.bytes("fixed.npz"), demo.bytes("untangled.npz"));
}

TEST(RepairProgram, OnlyTheShirtMoves) {
  const Demo demo;
  const Outcome done = demo.repair({"body.npz", "shirt.npz", "--fixed", "body.npz", "-o", "shirt-fixed.npz"});
  EXPECT_EQ(done.code, 0) << done.err;
  EXPECT_THAT(done.out,
              HasSubstr("Proven: nothing touches, in no frame and at no time between frames, apart from what "
                        "may not move, which touches itself."));
  EXPECT_THAT(done.out, HasSubstr("2 contacts, the worst first:\n#1  body with itself"));
  EXPECT_EQ(demo.check({"body.npz", "shirt.npz", "--ignore", "body", "body"}).code, 1);
  EXPECT_EQ(demo.check({"body.npz", "shirt-fixed.npz", "--ignore", "body", "body"}).code, 0);
  const Outcome two = demo.repair({"body.npz", "shirt.npz", "-q", "-o", "a.npz", "-o", "b.npz"});
  EXPECT_EQ(two.code, 0) << two.err;
  EXPECT_EQ(demo.check({"a.npz", "b.npz"}).code, 0);
}

TEST(RepairProgram, ContactsThatAreNamedAreRepairedAlone) {
  const Demo demo;
  const auto repair = [&](const char* one, const char* other) {
    return demo.repair({"body.npz", "shirt.npz", "--contact", one, other, "--json", "done.json", "-o",
                        "a.npz", "-o", "b.npz", "--unit", "cm"});
  };
  const Outcome done = repair("shirt", "body");
  EXPECT_EQ(done.code, 0) << done.err;
  EXPECT_THAT(done.out, HasSubstr("Proven: what was chosen is gone, in all frames and at all times between "
                                  "them; left: body goes through itself twice"));
  EXPECT_THAT(done.out, HasSubstr("What was left:\n\n2 contacts"));
  EXPECT_THAT(done.out, ::testing::ContainsRegex("largest correction +[0-9.]+ cm in frame"));
  const auto report = nlohmann::json::parse(demo.bytes("done.json"));
  EXPECT_EQ(report["verdict"]["kind"], "limited");
  EXPECT_EQ(report["before"].size(), 4);
  EXPECT_EQ(report["left"].size(), 2);
  EXPECT_EQ(demo.check({"a.npz", "b.npz", "--ignore", "a", "a"}).code, 0);
  EXPECT_EQ(demo.check({"a.npz", "b.npz"}).code, 1);
  EXPECT_THAT(repair("shirt", "shirt").out, HasSubstr("none of the contacts was chosen"));
  EXPECT_THAT(repair("shirt", "trousers").err, HasSubstr("'trousers': is neither an object nor a part"));
  // In glTF, too: its file says that it is not free.
  const Outcome gltf = demo.repair({"walk.glb", "--contact", "walk", "walk", "-o", "walk-fixed.glb"});
  EXPECT_EQ(gltf.code, 0) << gltf.err;
  EXPECT_EQ(demo.check({"walk-fixed.glb"}).code, 0);
}

// One triangle pierces another in the object b, in both frames; the object a is far away.
TEST(RepairProgram, WhatMayNotMoveIsTestedWithItselfAndListed) {
  const Workplace place;
  write_file(place / "a.obj", "o far\nv 9 9 9\nv 10 9 9\nv 9 10 9\nf 1 2 3\n");
  write_file(place / "b.obj",
             "v -9 -9 0\nv 20 -9 0\nv -9 20 0\nv 0 0 0.6\nv 1 0 -2\nv 0 1 2\nf 1 2 3\nf 4 5 6\n");
  const auto repair = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"repair", "--separate", "a.obj", "b.obj", "-o", "out.npz"});
    return run_program(std::move(arguments), {.directory = place.path()});
  };
  for (const std::vector<std::string>& may_move :
       {std::vector<std::string>{"--only", "a"}, std::vector<std::string>{"--fixed", "b"}}) {
    const Outcome done = repair(may_move);
    EXPECT_EQ(done.code, 0) << done.err;
    EXPECT_THAT(
        done.out,
        HasSubstr(
            "The motion is as it was: nothing touches, apart from what may not move, which touches itself."));
    EXPECT_THAT(done.out, HasSubstr("What may not move touches itself, and was left so:\n\n1 contact"));
    EXPECT_THAT(done.out, HasSubstr("b with itself"));
    auto with = may_move;
    with.insert(with.end(), {"--ignore", "b", "b"});
    EXPECT_THAT(repair(with).out,
                HasSubstr("The motion is as it was: nothing touches; pairs of b with itself "
                          "were ignored."));
    with = may_move;
    with.insert(with.end(), {"--thickness", "0.1"});
    EXPECT_THAT(repair(with).out, HasSubstr("was not tested with itself for the thickness"));
  }
}

// Vertex 6 is in no face; with --weld, 4 and 5 are in none either.
TEST(RepairProgram, WhatIsFixedHasNoVertexThatMayMove) {
  const Workplace place;
  write_file(place / "a.obj", "v 9 9 9\nv 10 9 9\nv 9 10 9\nf 1 2 3\n");
  write_file(place / "b.obj",
             "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 1 0 0\nv 0 1 0\nv 5 5 5\nf 1 2 3\nf 5 4 6\n");
  for (const char* option : {"--weld", "--no-weld"}) {
    const Outcome done =
        run_program({"repair", "--separate", option, "a.obj", "b.obj", "--fixed", "b", "-o", "out.npz"},
                    {.directory = place.path()});
    EXPECT_EQ(done.code, 0) << option << done.err;
  }
}

TEST(RepairProgram, VerticesThatAreNamedStay) {
  const Workplace place;
  write_file(place / "a.obj", "v 0 0 0\nv 4 0 0\nv 0 4 0\nf 1 2 3\n");
  write_file(place / "b.obj", "v 1 1 -1\nv 1 1.2 1\nv 1.2 1 1\nf 1 2 3\n");
  write_file(place / "none.csv", "0\n0\n0\n");
  write_file(place / "two.csv", "0\n1\n0.5\n");
  const auto repair = [&](const std::string& a, const std::string& b, std::vector<std::string> outputs) {
    outputs.insert(outputs.begin(),
                   {"repair", "--separate", "a.obj", "b.obj", "--fixed-vertices", a, "--fixed-vertices", b});
    return run_program(std::move(outputs), {.directory = place.path()});
  };
  write_file(place / "all.csv", "1\n1\n1\n");
  const Outcome done = repair("all.csv", "two.csv", {"-o", "out.obj"});
  EXPECT_EQ(done.code, 0) << done.err << done.out;
  EXPECT_THAT(read_file(place / "out.obj"), ::testing::ContainsRegex("\nv 1 1.2 1\nv 1.2 1 1\n"));
  EXPECT_EQ(repair("none.csv", "two.csv", {"-o", "a-out.obj", "-o", "b-out.obj"}).code, 0);
  EXPECT_THAT(repair("all.csv", "all.csv", {"-o", "out.obj"}).err,
              HasSubstr("--fixed-vertices: leaves nothing that may move"));
  write_file(place / "two.csv", "1\n1\n");
  EXPECT_THAT(repair("all.csv", "two.csv", {"-o", "out.obj"}).err,
              HasSubstr("two.csv: has 2 numbers for 3 vertices; give a number for each vertex"));
}

TEST(RepairProgram, MistakesAreSaidInOneLineAndAtOnce) {
  const Demo demo;
  const std::vector<Mistake> mistakes = {
      {{"walk.glb", "-o", "a.npz", "-o", "b.npz"}, "-o: is given 2 times, but 1 object may move"},
      {{"body.npz", "shirt.npz", "-o", "a.npz"}, "-o: is given once, but 2 objects may move"},
      {{"body.npz", "--fixed", "body", "-o", "a.npz"},
       "--fixed body: leaves nothing that may move; leave one of these out"},
      {{"walk.glb", "--only", "nothing", "-o", "a.npz"}, "'nothing': is neither an object nor a part of one"},
      {{"walk.glb", "--thickness", "1", "-o", "a.npz"},
       "--thickness: 1 is more than the gaps of walk.glb itself: in frame "},
      {{"body.npz", "--ignore", "body", "-o", "a.npz"}, "'-o' is an option; give two names"},
      {{"walk.glb", "--thickness", "-1", "-o", "a.npz"}, "--thickness"},
      {{"walk.glb", "--falloff", "-1", "-o", "a.npz"}, "--falloff"},
      {{"walk.glb", "-o", "a.ply"}, "a.ply: is PLY, which holds one frame"},
      {{"body.npz", "-o", "body.npz"}, "body.npz"},
      {{"body.npz", "shirt.npz", "-o", "body.npz", "-o", "b.npz"}, "-o body.npz: would write over"},
      {{"body.npz", "shirt.npz", "-o", "a.npz", "-o", "a.npz"}, "-o a.npz: is named for two outputs"},
      {{"body.npz", "shirt.npz", "-o", "./../demo/a.npz", "-o", "a.npz"}, "is named for two outputs"},
      {{"body.npz", "--start", "shirt.npz", "-o", "a.npz"}, "shirt.npz: has other triangles than body.npz"},
      {{"pose.obj", "--start", "pose.obj", "-o", "a.npz"}, "--start pose.obj: touches itself: "},
      {{"shirt.npz", "--model", "body.model", "-o", "a.npz"}, "body.model: "},
      {{"walk.glb", "--in-betweens", "3", "-o", "a.ply"}, "name it .npz, or .obj, which gets an MDD"},
      {{"walk.glb", "--in-betweens", "3", "-o", "a%04d.obj"}, "name it .npz, or .obj without %, which"},
      {{"pose.obj", "--in-betweens", "3", "-o", "a.obj"}, "leave out --in-betweens: there is one frame"},
      {{"walk.glb", "--in-betweens", "-1", "-o", "a.npz"}, "--in-betweens"},
      {{"walk.glb"}, "--output"},
  };
  for (const Mistake& mistake : mistakes) {
    SCOPED_TRACE(mistake.said);
    expect_one_line_error(demo.repair(mistake.arguments), mistake.said);
  }
  EXPECT_FALSE(demo.exists("a.npz"));
}

TEST(RepairProgram, IgnoredPairsAreListedAndDoNotCount) {
  const Demo demo;
  ASSERT_EQ(demo.check({"body.npz", "shirt.npz"}).code, 1);
  const Outcome done = demo.repair({"body.npz", "shirt.npz", "--ignore", "body", "shirt", "--ignore", "body",
                                    "body", "--ignore", "shirt", "shirt", "-o", "a.npz", "-o", "b.npz"});
  EXPECT_EQ(done.code, 0) << done.err;
  EXPECT_THAT(done.out,
              HasSubstr("The motion is as it was: nothing touches; pairs of body and shirt, of body "
                        "with itself, of shirt with itself were ignored."));
  EXPECT_EQ(demo.bytes("a.npz"), demo.bytes("body.npz"));
}

TEST(RepairProgram, TheThicknessThatARefusalNamesIsNotRefused) {
  const Demo demo;
  const Outcome refused = demo.repair({"walk.glb", "--thickness", "0.1", "-o", "a.npz"});
  const std::string most = "give at most ";
  const std::size_t at = refused.err.find(most);
  ASSERT_NE(at, std::string::npos) << refused.err;
  const std::string length =
      refused.err.substr(at + most.size(), refused.err.find('\n', at) - at - most.size());
  const Outcome done =
      demo.repair({"walk.glb", "--quick", "--frames", "0:2", "--thickness", length, "-o", "a.npz"});
  EXPECT_EQ(done.err, "");
  EXPECT_NE(done.code, 2);
}

TEST(RepairProgram, OneFrameOfSeveralIsAPly) {
  const Demo demo;
  EXPECT_EQ(demo.repair({"walk.glb", "--frames", "9:10", "-q", "-o", "a.ply"}).code, 0);
  EXPECT_EQ(demo.check({"a.ply"}).code, 0);
}

TEST(RepairProgram, FramesAreNumberedAsInTheInput) {
  const Demo demo;
  const Outcome done =
      demo.repair({"body.npz", "shirt.npz", "--fixed", "body", "--frames", "20:23", "-o", "a.npz"});
  EXPECT_THAT(done.out, HasSubstr("body with itself  frame 21  worst 21: "));
}

TEST(RepairProgram, TimesStandBesideFramesThatMayBeAdded) {
  const Demo demo;
  EXPECT_EQ(demo.repair({"walk.glb", "-q", "--fps", "4", "--in-betweens", "3", "-o", "a.npz"}).code, 0);
  EXPECT_THAT(demo.bytes("a.npz"), HasSubstr("times.npy"));
  EXPECT_EQ(demo.check({"a.npz"}).code, 0);
  EXPECT_EQ(demo.repair({"walk.glb", "-q", "-o", "b.npz"}).code, 0);
  EXPECT_THAT(demo.bytes("b.npz"), ::testing::Not(HasSubstr("times.npy")));
}

TEST(RepairProgram, PointCachesWithTimesHoldFramesThatMayBeAdded) {
  const Demo demo;
  EXPECT_EQ(demo.repair({"walk.glb", "-q", "--fps", "4", "--in-betweens", "3", "-o", "a.obj"}).code, 0);
  EXPECT_FALSE(demo.exists("a.pc2"));
  EXPECT_EQ(demo.check({"a.obj", "a.mdd"}).code, 0);
}

// It is interrupted later each time, until it is done before.
TEST(RepairProgram, InterruptedItKeepsWhatIsFinished) {
  const Demo demo;
  int kept = 0;
  for (int wait = 0, code = 130; code == 130; wait += 10) {
    const auto later = [&](pid_t child) {
      std::this_thread::sleep_for(std::chrono::milliseconds(wait));
      interrupt(child);
    };
    std::filesystem::remove(demo / "demo/cut.npz");
    const Outcome done = run_program({"repair", "walk.glb", "--keep", "--threads", "1", "-o", "cut.npz"},
                                     {.directory = demo / "demo", .while_it_runs = later});
    code = done.code;
    ASSERT_TRUE(code == 130 || code == 0) << done.err;
    if (code == 0 || !demo.exists("cut.npz")) continue;
    ++kept;
    EXPECT_THAT(done.out, HasSubstr("of the input were finished, and are written."));
    EXPECT_EQ(demo.check({"cut.npz"}).code, 0);
  }
  EXPECT_GT(kept, 0);
}

TEST(RepairProgram, InterruptedItLeavesNothing) {
  const Demo demo;
  const Outcome done =
      run_program({"repair", "walk.glb", "-o", "cut.npz"},
                  {.directory = demo / "demo", .while_it_runs = [](pid_t child) { interrupt(child); }});
  EXPECT_TRUE(done.code == 130 || done.code == 0) << done.code;  // it may have been done before
  EXPECT_EQ(demo.exists("cut.npz"), done.code == 0);
}

}  // namespace
}  // namespace foldproof
