#include <gmock/gmock.h>

#include <cmath>
#include <csignal>
#include <nlohmann/json.hpp>
#include <thread>

#include "apps/program.h"
#include "io/gltf_builder.h"
#include "mesh/grid.h"
#include "report/spheres.h"
#include "report/without_times.h"

namespace foldproof {
namespace {

using namespace foldproof::testing;
using nlohmann::json;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

/// The sinking triangle as OBJ frames in "sink", a clean motion in "clean", a single pose in "pose.obj".
struct Scene : Workplace {
  Scene() {
    write_frames(path() + "/sink", *sinking_triangle(kSinking));
    write_frames(path() + "/clean", *sinking_triangle({3, 2, 1}));
    write_frames(path() + "/floor", *lone_floor(5));
    write_frames(path() + "/tip", *lone_triangle(kSinking));
    std::filesystem::copy_file(path() + "/sink/frame2.obj", path() + "/pose.obj");
  }
};

// --- Answers

TEST(Check, ExitCodesReportTheAnswer) {
  const Scene scene;
  EXPECT_EQ(check_in(scene, {"clean"}).code, 0);
  EXPECT_EQ(check_in(scene, {"sink"}).code, 1);
  EXPECT_EQ(check_in(scene, {"nothing.obj"}).code, 2);
  EXPECT_EQ(check_in(scene, {"pose.obj", "--static"}).code, 1);
  EXPECT_EQ(check_in(scene, {"sink/frame0.obj", "--static"}).code, 0);
  EXPECT_EQ(check_in(scene, {"sink", "--frames", ":2"}).code, 0);
  EXPECT_EQ(check_in(scene, {"sink", "--frames", "1:3"}).code, 1);
}

TEST(Check, NotesOfAReaderAreShownWhole) {
  const Scene scene;
  std::filesystem::remove(scene / "clean/frame1.obj");
  const std::string note = "frame numbers jump from 0 to 2: the step between them was not in the files";
  const Outcome checked = check_in(scene, {"clean", "--json", "a.json"});
  EXPECT_THAT(checked.out, HasSubstr("\nclean: " + note + "\n"));
  EXPECT_EQ(scene.report("a.json")["objects"][0]["notes"], json::array({note}));
  check_in(scene, {"sink", "--json", "b.json"});
  EXPECT_FALSE(scene.report("b.json")["objects"][0].contains("notes"));
}

TEST(Check, LongNamesAreCutInTheMiddle) {
  const Scene scene;
  std::filesystem::rename(scene / "clean", scene / ("begin_" + std::string(60, 'x') + "_end"));
  const Outcome checked = check_in(scene, {"begin_" + std::string(60, 'x') + "_end"});
  EXPECT_THAT(checked.out, HasSubstr("\nbegin_xxxxxxxxx...xxxxxxxxxxxxxxxxxxxxxxxxxx_end  "));
}

TEST(Check, SummaryHasTheMainResults) {
  const Scene scene;
  const Outcome found = check_in(scene, {"sink"});
  for (const char* part :
       {"object", "vertices", "triangles", "frames", "sink", "steps checked", "vertex-face 3, edge-edge 0",
        "frames 2 to 3: 2 pairs", "frames 1 to 2, time of impact 0.", "undecided", "time per step",
        "Collisions in 2 of 4 steps between 5 frames of one mesh, the first in frames 1 to 2, 0."}) {
    EXPECT_THAT(found.out, HasSubstr(part));
  }
  EXPECT_EQ(found.err, "");  // not a terminal: no progress bar
  EXPECT_THAT(
      check_in(scene, {"clean"}).out,
      HasSubstr("No collisions between 3 frames of one mesh: no triangles cross in frame 0, and all 2 "
                "steps are proven free.\n"));
}

TEST(Check, SaysThatItSkipsFrames) {
  const Scene scene;
  const Outcome free = check_in(scene, {"clean", "--frames", "::2"});
  EXPECT_THAT(free.out, HasSubstr("steps checked           1  (frames 0 to 2, every 2nd frame)\n"));
  EXPECT_THAT(free.out, HasSubstr(" and the one step is proven free; only every 2nd frame was checked.\n"));
  const Outcome poses = check_in(scene, {"sink", "--static", "--frames", "::4"});
  EXPECT_THAT(poses.out, HasSubstr("; only every 4th frame was checked.\n"));
  EXPECT_THAT(check_in(scene, {"clean", "--frames", "1::5"}).out, Not(HasSubstr("every")));
  ASSERT_TRUE(write_npz(scene / "long.npz", *sinking_triangle(std::vector<double>(200, 1))));
  for (const auto& [step, name] :
       {std::pair{"11", "11th"}, {"21", "21st"}, {"23", "23rd"}, {"112", "112th"}}) {
    const Outcome found = check_in(scene, {"long.npz", "--frames", "::" + std::string(step)});
    EXPECT_THAT(found.out, HasSubstr("only every " + std::string(name) + " frame was checked.\n"));
  }
}

// Two overlapping spheres that move together have no new contact, and yet intersect.
TEST(Check, CrossingsFromTheStartAreInAllReports) {
  const TemporaryDirectory directory;
  ASSERT_TRUE(write_npz(directory / "merged.npz", *two_spheres(1.03)));
  ASSERT_TRUE(write_npz(directory / "apart.npz", *two_spheres(2.5)));

  const Outcome merged = check_in(directory, {"merged.npz", "--json", "a.json", "--pairs", "--csv", "a.csv",
                                              "--ply", "a.ply", "--vtk", "a.pvd"});
  EXPECT_EQ(merged.code, 1);
  const json report = json::parse(read_file(directory / "a.json"));
  const std::uint64_t crossings = report["totals"]["starts_crossing"];
  EXPECT_GT(crossings, 10u);
  const std::string said = std::to_string(crossings) + " crossing pairs of triangles";
  EXPECT_THAT(merged.out, HasSubstr("frame 0 starts with " + said));
  EXPECT_THAT(merged.out,
              HasSubstr("\nFrame 0 starts with " + said + "; no other contact begins in the steps.\n"));
  EXPECT_THAT(merged.out, Not(HasSubstr("free")));
  EXPECT_EQ(report["clean"], false);
  EXPECT_EQ(report["totals"]["steps_with_collisions"], 0);
  EXPECT_EQ(report["start"]["pairs"]["tt"].size(), crossings);
  const std::string rows = read_file(directory / "a.csv");
  EXPECT_EQ(static_cast<std::uint64_t>(std::count(rows.begin(), rows.end(), '\n')), crossings + 1);
  const auto marks = read_marks(directory / "a.ply", report["objects"][0]["triangles"]);
  EXPECT_GT(std::count(marks.begin(), marks.end(), 1), 10);
  EXPECT_EQ(std::count(marks.begin(), marks.end(), 2), 0);
  EXPECT_THAT(read_file(directory / "a/step000001.vtp"), HasSubstr("\"meets\""));
  EXPECT_THAT(check_in(directory, {"merged.npz", "--pairs"}).out, HasSubstr("frame 0 at the start\n  face "));

  const Outcome steps = check_in(directory, {"merged.npz", "--steps-only", "--json", "b.json"});
  EXPECT_EQ(steps.code, 0);
  EXPECT_THAT(steps.out, HasSubstr("No contact begins in all 2 steps, proven. Crossings from frame 0 on were "
                                   "not tested (--steps-only).\n"));
  EXPECT_TRUE(json::parse(read_file(directory / "b.json"))["totals"]["starts_crossing"].is_null());
  EXPECT_THAT(steps.out, Not(HasSubstr("free")));

  const Outcome apart = check_in(directory, {"apart.npz"});
  EXPECT_EQ(apart.code, 0);
  EXPECT_THAT(apart.out,
              HasSubstr("No collisions: no triangles cross in frame 0, and all 2 steps are proven free.\n"));
}

TEST(Check, ASingleFrameIsAStepWithoutMotion) {
  const Scene scene;
  const Outcome crossing = check_in(scene, {"pose.obj"});
  EXPECT_EQ(crossing.code, 1);
  EXPECT_THAT(crossing.out, HasSubstr("\nFrame 0 starts with 1 crossing pair of triangles.\n"));
  const Outcome free =
      check_in(scene, {"sink/frame1.obj", "--json", "a.json", "--ply", "a.ply", "--vtk", "a.pvd"});
  EXPECT_EQ(free.code, 0) << free.err;
  EXPECT_THAT(free.out, HasSubstr("\nNo collisions: no triangles cross in frame 0, proven.\n"));
  EXPECT_EQ(scene.report("a.json")["steps"].size(), 1u);
  EXPECT_EQ(check_in(scene, {"sink", "--frames", "2"}).code, 1);

  const Outcome near = check_in(scene, {"sink/frame1.obj", "--thickness", "0.7"});
  EXPECT_EQ(near.code, 1);
  EXPECT_THAT(near.out, HasSubstr("\n1 pair in frame 0 as close as the thickness and the tolerance.\n"));
  const Outcome far = check_in(scene, {"sink/frame1.obj", "--thickness", "0.5"});
  EXPECT_EQ(far.code, 0);
  EXPECT_THAT(far.out, HasSubstr("and all is farther apart than the thickness, proven.\n"));
}

TEST(Check, ASingleFrameStandsStillBesideAMotion) {
  const Scene scene;
  std::filesystem::copy_file(scene / "floor/frame0.obj", scene / "ground.obj");
  const Outcome moved = check_in(scene, {"tip", "floor", "--sequence", "--json", "moved.json"});
  const Outcome still = check_in(scene, {"tip", "ground.obj", "--sequence", "--json", "still.json"});
  EXPECT_EQ(moved.code, 1);
  EXPECT_EQ(still.code, 1) << still.err;
  EXPECT_EQ(scene.report("still.json")["totals"]["collisions"],
            scene.report("moved.json")["totals"]["collisions"]);
}

// What newcomers take for collisions.
TEST(Check, HintsAtDoubledVerticesAndAtFramesThatAreNotOneMotion) {
  const Scene scene;
  write_file(scene / "seam.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 4 6 5\n");
  const std::string doubled =
      "2 of 6 vertices lie exactly where others do, and so triangles touch there; if they are of one "
      "surface, "
      "check it with --weld";
  const std::string found = check_in(scene, {"seam.obj", "--json", "a.json"}).out;
  EXPECT_THAT(found, HasSubstr("\nseam.obj: " + doubled + "\n"));
  EXPECT_LT(found.find(doubled), found.find("1 contact")) << found;
  EXPECT_EQ(scene.report("a.json")["totals"]["notices"], json::array({{{"object", 0}, {"text", doubled}}}));
  const Outcome welded = check_in(scene, {"seam.obj", "--weld", "--json", "b.json"});
  EXPECT_EQ(welded.code, 0);
  EXPECT_THAT(welded.out, Not(HasSubstr("--weld")));
  EXPECT_THAT(welded.out, HasSubstr("2 of 6 vertices lie on seams and were merged"));
  EXPECT_EQ(scene.report("b.json")["objects"][0]["merged"], 2);
  EXPECT_EQ(scene.report("b.json")["objects"][0]["vertices"], 6);
  EXPECT_FALSE(scene.report("b.json")["totals"].contains("notices"));
  EXPECT_THAT(check_in(scene, {"sink"}).out, Not(HasSubstr("--weld")));

  for (const char* name : {"one side.obj", "two sides.obj", "no sides.obj"})
    std::filesystem::copy_file(scene / "clean/frame0.obj", scene / name);
  EXPECT_THAT(check_in(scene, {"one side.obj", "two sides.obj", "no sides.obj"}).out,
              HasSubstr("All 3 meshes have the same triangles. If they are frames of one motion, check "
                        "them with --sequence."));
  EXPECT_THAT(check_in(scene, {"one side.obj", "two sides.obj"}).out, Not(HasSubstr("the same triangles")));
  EXPECT_THAT(check_in(scene, {"one side.obj", "two sides.obj", "no sides.obj", "--separate"}).out,
              Not(HasSubstr("the same triangles")));
}

/// A cube whose faces have vertices of their own, as exporters of glTF write them.
GltfBuilder cube_of_24_vertices() {
  GltfBuilder b;
  std::vector<float> positions;
  std::vector<std::uint16_t> indices;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const float side : {0.0f, 1.0f}) {
      const auto first = static_cast<std::uint16_t>(positions.size() / 3);
      for (const auto& [u, v] : {std::pair(0, 0), {1, 0}, {1, 1}, {0, 1}}) {
        float x[3];
        x[axis] = side;
        x[(axis + 1) % 3] = static_cast<float>(u);
        x[(axis + 2) % 3] = static_cast<float>(v);
        positions.insert(positions.end(), x, x + 3);
      }
      for (const int corner : {0, 1, 2, 0, 2, 3})
        indices.push_back(static_cast<std::uint16_t>(first + corner));
    }
  }
  b.json["meshes"] = {{{"primitives",
                        {{{"attributes", {{"POSITION", b.floats("VEC3", positions)}}},
                          {"indices", b.accessor("SCALAR", indices)}}}}}};
  b.json["nodes"] = {{{"mesh", 0}}};
  return b;
}

TEST(Check, SeamsOfAGltfAreMergedUnlessToldOtherwise) {
  const Scene scene;
  write_file(scene / "cube.gltf", cube_of_24_vertices().gltf());
  const Outcome merged = check_in(scene, {"cube.gltf", "--json", "a.json"});
  EXPECT_EQ(merged.code, 0) << merged.out;
  EXPECT_THAT(merged.out,
              HasSubstr("\ncube.gltf: 16 of 24 vertices lie on seams and were merged; what meets there "
                        "counts as neighbors\n"));
  EXPECT_EQ(scene.report("a.json")["settings"]["seams"], "by_format");
  EXPECT_EQ(scene.report("a.json")["settings"]["weld"], false);
  EXPECT_EQ(scene.report("a.json")["objects"][0]["merged"], 16);
  const Outcome kept = check_in(scene, {"cube.gltf", "--no-weld", "--json", "b.json"});
  EXPECT_EQ(kept.code, 1);
  EXPECT_EQ(scene.report("b.json")["settings"]["seams"], "never");
  EXPECT_EQ(scene.report("b.json")["objects"][0]["merged"], 0);
  const std::string notice = "16 of 24 vertices lie exactly where others do";
  EXPECT_LT(kept.out.find(notice), kept.out.find(" contacts, the worst first")) << kept.out;
  const Outcome both = check_in(scene, {"cube.gltf", "--no-weld", "--weld"});
  EXPECT_EQ(both.code, 2);
  EXPECT_THAT(both.err, HasSubstr("--no-weld"));
}

// A leaf of two sides with vertices of their own: merged, their faces have the same three vertices.
TEST(Check, SidesOfOneSurfaceDoNotCross) {
  const Scene scene;
  GltfBuilder b;
  const int front = b.floats("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0});
  const int back = b.floats("VEC3", {0, 0, 0, 0, 1, 0, 1, 0, 0});
  b.json["meshes"] = {{{"primitives",
                        {{{"attributes", {{"POSITION", front}}}, {"material", 0}},
                         {{"attributes", {{"POSITION", back}}}, {"material", 1}}}}}};
  b.json["nodes"] = {{{"mesh", 0}}};
  b.json["materials"] = {{{"name", "leaf front"}}, {{"name", "leaf back"}}};
  write_file(scene / "leaf.gltf", b.gltf());
  b.json["materials"][1]["name"] = "stone";
  write_file(scene / "stone.gltf", b.gltf());
  for (const char* kind : {"--static", "--quiet"}) {
    EXPECT_EQ(check_in(scene, {"leaf.gltf", kind}).code, 0) << kind;
    EXPECT_EQ(check_in(scene, {"leaf.gltf", kind, "--no-weld"}).code, 1) << kind;
  }
  const Outcome stone = check_in(scene, {"stone.gltf"});
  EXPECT_EQ(stone.code, 0);
  EXPECT_THAT(stone.out,
              HasSubstr("\nstone.gltf: 1 face lies on another, turned around; that is not counted as "
                        "contact, and --no-weld counts it\n"));
}

TEST(Check, QuietPrintsNothing) {
  const Scene scene;
  const Outcome found = check_in(scene, {"sink", "--quiet", "--pairs"});
  EXPECT_EQ(found.code, 1);
  EXPECT_EQ(found.out, "");
  EXPECT_EQ(found.err, "");
}

TEST(Check, ReportsGoToTheirFiles) {
  const Scene scene;
  const Outcome found =
      check_in(scene, {"sink", "--json", "a.json", "--pairs", "--csv", "a.csv", "--ply", "a.ply"});
  EXPECT_EQ(found.code, 1);
  const json report = scene.report("a.json");
  EXPECT_EQ(report["objects"][0]["name"], "sink");
  EXPECT_EQ(report["totals"]["collisions"]["vf"], 3);
  EXPECT_EQ(report["steps"][1]["pairs"]["vf"][0][1], 3);
  EXPECT_THAT(read_file(scene / "a.csv"), HasSubstr("\n1,0,vf,0,3,,0,0,,0."));
  EXPECT_THAT(read_marks(scene / "a.ply", 2), ElementsAre(3, 3));
  EXPECT_THAT(found.out, Not(HasSubstr("vertex 3")));  // the pairs went to the file
}

TEST(Check, PairsWithoutAFileAreListed) {
  const Scene scene;
  EXPECT_THAT(check_in(scene, {"sink", "--pairs"}).out,
              HasSubstr("frame 1 substep 0\n  vertex 3 meets face 0 at 0."));
  EXPECT_THAT(check_in(scene, {"floor", "tip", "--sequence", "--pairs"}).out,
              HasSubstr("vertex 0 of object 1 meets face 0 of object 0 at 0."));
  EXPECT_THAT(check_in(scene, {"pose.obj", "--static", "--pairs"}).out, HasSubstr("face 0 crosses face 1"));
}

TEST(Check, ALimitListsFewerPairsButCountsAll) {
  const Scene scene;
  const std::string out = check_in(scene, {"sink", "--pairs", "--limit", "1"}).out;
  EXPECT_THAT(out, HasSubstr("frame 2 substep 0\n  1 of 2 pairs:\n"));
  EXPECT_THAT(out, HasSubstr("colliding pairs         3 "));
  EXPECT_THAT(out, HasSubstr("  listed                2 of 3 "));
  EXPECT_THAT(check_in(scene, {"sink"}).out, Not(HasSubstr("listed")));
}

TEST(Check, TheEarliestPairsAreNotCalledAllOrTheWorst) {
  const Scene scene;
  const std::string out = check_in(scene, {"sink", "--first"}).out;
  EXPECT_THAT(out, HasSubstr("\nearliest pairs          2 "));
  EXPECT_THAT(out, Not(HasSubstr("colliding pairs")));
  EXPECT_THAT(out, Not(HasSubstr("\nworst ")));
}

TEST(Check, ContactsOfAFewPairsAndOfOnePoseSaySo) {
  const Scene scene;
  const char* limited = "Contacts join the listed pairs only (--limit).\n";
  EXPECT_THAT(check_in(scene, {"sink", "--limit", "1"}).out, HasSubstr(limited));
  EXPECT_THAT(check_in(scene, {"sink"}).out, Not(HasSubstr(limited)));
  const std::string pose = check_in(scene, {"sink", "--frames", "0", "--thickness", "2"}).out;
  EXPECT_THAT(pose, HasSubstr("  frame 0  touches, "));
}

TEST(Check, OptionsReachTheQuery) {
  const Scene scene;
  const auto settings = [&](std::vector<std::string> options) {
    options.insert(options.end(), {"--json", "a.json", "--quiet"});
    EXPECT_NE(check_in(scene, options).code, 2);
    return scene.report("a.json")["settings"];
  };
  const json all = settings({"floor", "tip", "--sequence", "--between", "--frames=-4:-1:2", "--substeps", "3",
                             "--thickness", "0.5", "--tolerance", "1e-3", "--first", "--weld", "--fps", "30",
                             "--threads", "1"});
  EXPECT_EQ(
      all,
      json::parse(
          R"({"static":false,"frames":{"first":1,"last":3,"step":2},"substeps":3,"steps_only":false,"within":false,
      "between":true,"thickness":0.5,"tolerance":0.001,"first":true,"limit":10000000,"certificates":true,"points":false,"ignore":[],"still_pairs":false,"weld":true,"seams":"always","fps":30.0})"));
  EXPECT_EQ(settings({"sink", "--static", "--within"})["static"], true);
  EXPECT_EQ(settings({"sink", "--within"})["between"], false);
  EXPECT_EQ(settings({"sink", "--frames", "-3:"})["frames"], json::parse(R"({"first":2,"last":4,"step":1})"));
}

TEST(Check, WithinAndBetween) {
  const Scene scene;
  EXPECT_EQ(check_in(scene, {"floor", "tip", "--sequence"}).code, 1);
  EXPECT_EQ(check_in(scene, {"floor", "tip", "--sequence", "--between"}).code, 1);
  const Outcome within = check_in(scene, {"floor", "tip", "--sequence", "--within"});
  EXPECT_EQ(within.code, 0);
  EXPECT_THAT(within.out, HasSubstr("; pairs of two meshes were not tested."));
  EXPECT_THAT(check_in(scene, {"sink", "--within"}).out, Not(HasSubstr("were not tested")));
}

TEST(Check, HelpAndVersion) {
  for (const auto& arguments : {std::vector<std::string>{"--help"}, {"check", "--help"}, {"check", "-h"}}) {
    const Outcome help = run_program(arguments);
    EXPECT_EQ(help.code, 0);
    EXPECT_THAT(help.out, HasSubstr("foldproof check walk.glb"));
    EXPECT_EQ(help.err, "");
  }
  EXPECT_EQ(run_program({"--version"}).out, fmt::format("foldproof {}\n{}\n", version(), build_info()));
}

// --- Errors

class CheckMistakes : public ::testing::TestWithParam<Mistake> {};

TEST_P(CheckMistakes, GetOneLineAndExitCode2) {
  const Scene scene;
  write_file(scene / "truncated.ply",
             "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
             "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n");
  write_file(scene / "nan.obj", "v 0 0 0\nv 1 0 nan\nv 0 1 0\nf 1 2 3\n");
  write_file(scene / "range.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 99\n");
  write_file(scene / "empty.obj", "");
  write_file(scene / "points.obj", "v 0 0 0\n");
  std::filesystem::create_directory(scene / "nobody");
  write_frames(scene / "changed", *sinking_triangle({3, 2}));
  write_file(scene / "changed/frame1.obj", read_file(scene / "floor/frame0.obj"));

  const Outcome outcome = run_program(GetParam().arguments, {.directory = scene.path()});
  expect_one_line_error(outcome, GetParam().said);
  EXPECT_THAT(outcome.err, HasSubstr("; "));  // what to do about it
}

INSTANTIATE_TEST_SUITE_P(
    CommandLine, CheckMistakes,
    ::testing::Values(Mistake{{"chekc"}, "chekc"}, Mistake{{"check"}, "MOTION"},
                      Mistake{{"check", "sink", "--frobnicate"}, "--frobnicate"},
                      Mistake{{"check", "sink", "--frames"}, "--frames"},
                      Mistake{{"check", "sink", "--frames", "a:b"}, "'a:b'"},
                      Mistake{{"check", "sink", "--frames", "::0"}, "'::0'"},
                      Mistake{{"check", "sink", "--frames", "9:"}, "selects 0 of 5 frames"},
                      Mistake{{"check", "sink", "--frames", "3", "--steps-only"}, "selects 1 of 5 frames"},
                      Mistake{{"check", "sink", "--substeps", "0"}, "--substeps"},
                      Mistake{{"check", "sink", "--substeps", "-1"}, "--substeps"},
                      Mistake{{"check", "sink", "--substeps", "many"}, "many"},
                      Mistake{{"check", "sink", "--thickness", "-1"}, "--thickness"},
                      Mistake{{"check", "sink", "--thickness", "nan"}, "--thickness"},
                      Mistake{{"check", "sink", "--tolerance", "inf"}, "--tolerance"},
                      Mistake{{"check", "sink", "--fps", "0"}, "--fps"},
                      Mistake{{"check", "sink", "--threads", "-2"}, "--threads"},
                      Mistake{{"check", "sink", "--within", "--between"}, "--within"},
                      Mistake{{"check", "sink", "--between"}, "nothing between"},
                      Mistake{{"check", "sink", "--static", "--thickness", "1"}, "--static"},
                      Mistake{{"check", "sink", "--static", "--substeps", "2"}, "--static"},
                      Mistake{{"check", "sink", "--static", "--first"}, "--static"},
                      Mistake{{"check", "sink", "--first", "--contacts"}, "--first"},
                      Mistake{{"check", "sink", "--first", "--contacts-csv", "c.csv"}, "--first"},
                      Mistake{{"check", "sink", "--miss-rate", "0.2"}, "--miss-rate: goes with --mode paper"},
                      Mistake{{"check", "sink", "--limit", "99999999999999999999"}, "is out of range"},
                      Mistake{{"check", "sink", "--limit", "-1"}, "is below 0"},
                      Mistake{{"check", "sink", "clean", "--sequence"}, "has 3 frames, but sink has 5"},
                      Mistake{{"check", "sink", "--static", "--steps-only"}, "--static"},
                      Mistake{{"check", "pose.obj", "--steps-only"}, "without --steps-only"}));

INSTANTIATE_TEST_SUITE_P(
    Files, CheckMistakes,
    ::testing::Values(Mistake{{"check", "missing.obj"}, "missing.obj"},
                      Mistake{{"check", "truncated.ply", "--static"}, "truncated.ply"},
                      Mistake{{"check", "nan.obj", "--static"}, "nan.obj:2"},
                      Mistake{{"check", "range.obj", "--static"}, "range.obj"},
                      Mistake{{"check", "empty.obj", "--static"}, "empty.obj: is empty"},
                      Mistake{{"check", "elsewhere"}, "elsewhere: does not exist; check the name"},
                      Mistake{{"check", "nan.ob"}, "nan.ob: does not exist; did you mean 'nan.obj'?"},
                      Mistake{{"check", "points.obj", "--static"}, "points.obj"},
                      Mistake{{"check", "nobody"}, "nobody"},
                      Mistake{{"check", "changed"}, "changed/frame1.obj"},
                      Mistake{{"check", "pose.xyz"}, "pose.xyz"},
                      Mistake{{"check", "sink", "--json", "no/where.json"}, "no/where.json"},
                      Mistake{{"check", "sink", "--csv", "no/where.csv"}, "no/where.csv"},
                      Mistake{{"check", "sink", "--ply", "no/where.ply"}, "no/where.ply"},
                      Mistake{{"check", "sink", "--ply", "a%s.ply"}, "a%s.ply"},
                      Mistake{{"check", "sink", "--vtk", "a.vtp"}, "a.vtp"},
                      Mistake{{"check", "sink", "--vtk", "no/where.pvd"}, "no/where.pvd"},
                      Mistake{{"check", "sink", "--json", "sink"}, "sink"},
                      Mistake{{"check", "sink", "--json", "x", "--csv", "x"}, "x: is named for two outputs"},
                      Mistake{{"check", "sink", "--json", "/dev/full"}, "/dev/full"},
                      Mistake{{"check", "sink", "--csv", "/dev/full"}, "/dev/full"},
                      Mistake{{"check", "sink", "--ply", "/dev/full"}, "/dev/full"}));

TEST(Check, AnErrorLeavesNoFileBehind) {
  const Scene scene;
  const auto before = scene.names();
  EXPECT_EQ(check_in(scene, {"sink", "--json", "a.json", "--csv", "a.csv", "--ply", "no/where.ply"}).code, 2);
  EXPECT_EQ(scene.names(), before);
}

TEST(Check, AnErrorLeavesAnEarlierReportAlone) {
  const Scene scene;
  write_file(scene / "a.json", "mine");
  write_file(scene / "sink/frame4.obj", "v 0 0 0\n");
  EXPECT_EQ(check_in(scene, {"sink", "--json", "a.json"}).code, 2);
  EXPECT_EQ(read_file(scene / "a.json"), "mine");
}

// --- Ends that come early
// -----------------------------------------------------------------------------------------

class CheckInterrupted : public ::testing::TestWithParam<int> {};

TEST_P(CheckInterrupted, LeavesNoPartialFile) {
  const Scene scene;
  const auto before = scene.names();
  RunOptions options{.directory = scene.path()};
  options.while_it_runs = [&](pid_t child) {
    // Its files are open once something new stands in the directory.
    for (int tries = 0; tries < 3000 && scene.names() == before; ++tries) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    EXPECT_NE(scene.names(), before);
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    ::kill(child, GetParam());
  };
  // Far too many steps to finish.
  const Outcome outcome = run_program({"check", "sink", "--substeps", "4000000000", "--json", "a.json",
                                       "--csv", "a.csv", "--ply", "a.ply", "--vtk", "a.pvd"},
                                      options);
  EXPECT_EQ(outcome.signal, 0);
  EXPECT_EQ(outcome.code, 130);
  EXPECT_THAT(outcome.err, ::testing::MatchesRegex(
                               "foldproof: interrupted: stopped at [0-9,]+ of 16,000,000,000 steps, [0-9,]+ "
                               "with collisions; no report was written\n"));
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1);
  EXPECT_EQ(outcome.out, "");
  EXPECT_EQ(scene.names(), before);
}

INSTANTIATE_TEST_SUITE_P(Signals, CheckInterrupted, ::testing::Values(SIGINT, SIGTERM));

TEST(Check, AClosedPipeIsNoError) {
  const Scene scene;
  int ends[2];
  ASSERT_EQ(::pipe2(ends, O_CLOEXEC), 0);
  ::close(ends[0]);
  const Outcome outcome = run_program({"check", "sink", "--pairs", "--json", "a.json"},
                                      {.directory = scene.path(), .output = ends[1]});
  ::close(ends[1]);
  EXPECT_EQ(outcome.signal, 0);
  EXPECT_EQ(outcome.code, 1);
  EXPECT_EQ(outcome.err, "");
  EXPECT_EQ(scene.report("a.json")["clean"], false);
}

TEST(Check, AFullDiskBehindStandardOutputIsAnError) {
  const Scene scene;
  const int full = ::open("/dev/full", O_WRONLY | O_CLOEXEC);
  ASSERT_GE(full, 0);
  const Outcome outcome = run_program({"check", "sink"}, {.directory = scene.path(), .output = full});
  ::close(full);
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.err, StartsWith("foldproof: standard output: "));
}

// --- Threads

/// Two wavy sheets that pass through each other, so that many pairs collide.
std::unique_ptr<Motion> waves(double phase, double direction) {
  constexpr Index kSide = 40;
  std::vector<std::vector<double>> frames(4);
  for (std::size_t k = 0; k < frames.size(); ++k) {
    for (Index i = 0; i < kSide; ++i) {
      for (Index j = 0; j < kSide; ++j) {
        const double height = 0.5 * std::sin(0.4 * i + phase) * std::cos(0.3 * j + phase);
        frames[k].insert(frames[k].end(), {0.1 * i + 0.03 * phase, 0.1 * j,
                                           height + direction * (1.0 - 0.5 * static_cast<double>(k))});
      }
    }
  }
  return memory_motion("waves", Grid{kSide - 1, kSide - 1, false, Diagonal::SecondToThird}.topology(),
                       std::move(frames));
}

TEST(Check, TheAnswerIsTheSameForAnyNumberOfThreads) {
  const TemporaryDirectory directory;
  ASSERT_TRUE(write_npz(directory / "up.npz", *waves(0, 1)));
  ASSERT_TRUE(write_npz(directory / "down.npz", *waves(1, -1)));
  std::vector<std::string> reports;
  for (const char* threads : {"1", "2", "7"}) {
    const std::string name = std::string("threads") + threads;
    EXPECT_EQ(check_in(directory, {"up.npz", "down.npz", "--threads", threads, "--pairs", "--json", name,
                                   "--csv", name + ".csv"})
                  .code,
              1);
    reports.push_back(without_times(read_file(directory / name)) + read_file(directory / (name + ".csv")));
  }
  EXPECT_GT(std::count(reports[0].begin(), reports[0].end(), '\n'), 1000);
  EXPECT_EQ(reports[0], reports[1]);
  EXPECT_EQ(reports[0], reports[2]);
}

}  // namespace
}  // namespace foldproof
