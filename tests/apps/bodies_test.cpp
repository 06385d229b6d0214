// What several files are to the program, frames or bodies, and which clip of a glTF it checks.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <array>
#include <nlohmann/json.hpp>

#include "apps/program.h"
#include "io/cube.h"
#include "io/gltf_builder.h"

namespace foldproof {
namespace {

using namespace foldproof::testing;
using nlohmann::json;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

std::string cube(double x, double y, double z) {
  return cube_at([&](int i, int j, int k) { return std::array{x + i, y + j, z + k}; });
}

/// Three cubes in "bodies" that overlap, and two in "lr".
struct Bodies : TemporaryDirectory {
  Bodies() {
    for (const char* name : {"bodies", "lr"}) std::filesystem::create_directory(*this / name);
    write_file(*this / "bodies/body_1.obj", cube(0, 0, 0));
    write_file(*this / "bodies/body_2.obj", cube(0.5, 0.4, 0.3));
    write_file(*this / "bodies/body_3.obj", cube(0.9, 0.7, 0.6));
    write_file(*this / "lr/left.obj", cube(0, 0, 0));
    write_file(*this / "lr/right.obj", cube(0.5, 0.4, 0.3));
  }
  json report() const { return json::parse(read_file(*this / "a.json")); }
};

TEST(Bodies, CopiesApartAreNoMotionUnlessThatIsSaid) {
  const Bodies scene;
  const std::vector<std::string> list{"bodies/body_1.obj", "bodies/body_2.obj", "bodies/body_3.obj"};
  for (const auto& named :
       std::vector<std::vector<std::string>>{{"bodies"}, {"bodies/*.obj"}, {"bodies/body_%d.obj"}, list}) {
    const auto check = [&](std::vector<std::string> options) {
      options.insert(options.begin(), named.begin(), named.end());
      options.insert(options.end(), {"--json", "a.json"});
      return check_in(scene, options);
    };
    expect_one_line_error(check({}), "say which it is: --sequence or --separate");
    EXPECT_EQ(check({"--separate"}).code, 1);
    EXPECT_EQ(scene.report()["objects"].size(), 3u);
    EXPECT_GT(scene.report()["start"]["crossings"], 30);
    const Outcome frames = check({"--sequence"});
    EXPECT_EQ(frames.code, 0);
    EXPECT_THAT(frames.out,
                HasSubstr("\nNo collisions between 3 frames of one mesh: no triangles cross in frame 0"));
    EXPECT_EQ(scene.report()["objects"][0]["taken_as"], "3 frames of one mesh");
    EXPECT_THAT(check({"--static"}).out, HasSubstr("\nNo triangles cross in any of 3 frames, proven."));
    expect_one_line_error(check({"--sequence", "--separate"}), "--separate");
  }
  EXPECT_EQ(
      run_program({"train", "bodies", "--no-learning", "-o", "a.model"}, {.directory = scene.path()}).code, 0)
      << "poses may be anywhere";
}

TEST(Bodies, OtherNamesAreOtherBodies) {
  const Bodies scene;
  const Outcome found = check_in(scene, {"lr"});
  EXPECT_EQ(found.code, 1);
  EXPECT_THAT(found.out, AllOf(HasSubstr("18 crossing pairs"), Not(HasSubstr("frames of one mesh"))));
  EXPECT_EQ(check_in(scene, {"lr", "--static"}).code, 0) << "two poses";
}

TEST(Bodies, FilesThatAreNoFramesOfTheOthersStandStill) {
  const Bodies scene;
  write_file(scene / "s1.obj", cube(0, 0, 0));
  write_file(scene / "s2.obj", cube(0.5, 0.5, 0.5));
  ASSERT_TRUE(write_npz(scene / "two.npz", *lone_triangle({9, 8})));
  ASSERT_TRUE(write_npz(scene / "three.npz", *lone_triangle({9, 8, 7})));
  const auto frames = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), {"--json", "a.json"});
    check_in(scene, arguments);
    std::vector<std::string> all;
    const json report = scene.report();
    for (const json& object : report["objects"]) all.push_back(object["name"].get<std::string>());
    return all;
  };
  expect_one_line_error(check_in(scene, {"s1.obj", "s2.obj", "two.npz"}),
                        "s2.obj is 0.5 times its size away from s1.obj");
  const auto apart = [](const char* motion) { return ElementsAre("s1.obj", "s2.obj", motion); };
  EXPECT_THAT(frames({"s1.obj", "s2.obj", "two.npz", "--separate"}), apart("two.npz"));
  EXPECT_THAT(frames({"s1.obj", "s2.obj", "three.npz"}), apart("three.npz"));
  EXPECT_THAT(frames({"s1.obj", "s2.obj", "two.npz", "--sequence"}),
              ElementsAre("s1.obj to s2.obj", "two.npz"));
  EXPECT_THAT(check_in(scene, {"s1.obj", "s2.obj", "two.npz", "--sequence"}).out,
              HasSubstr("No collisions (s1.obj to s2.obj: 2 frames of one mesh): no"));
}

/// A triangle that "walk" moves, and "dive" through another one, faster.
struct Clips : TemporaryDirectory {
  Clips() {
    GltfBuilder b;
    b.triangle();
    const int floor = b.floats("VEC3", {-9, -9, 1, 20, -9, 1, -9, 20, 1});
    b.json["meshes"].push_back({{"primitives", {{{"attributes", {{"POSITION", floor}}}}}}});
    b.json["nodes"] = {{{"mesh", 0}}, {{"mesh", 1}}};
    b.json["scenes"][0]["nodes"] = {0, 1};
    b.animate(0, "translation", b.floats("SCALAR", {0, 2}), b.floats("VEC3", {0, 0, 0, 1, 0, 0}));
    b.json["animations"].back()["name"] = "walk";
    b.animate(0, "translation", b.floats("SCALAR", {0, 1}), b.floats("VEC3", {0, 0, 0, 0, 0, 3}));
    b.json["animations"].back()["name"] = "dive";
    write_file(*this / "a.glb", b.glb());
    write_file(*this / "b.glb", b.glb());
  }
};

TEST(Clips, TheLongestIsCheckedAndNamed) {
  const Clips scene;
  const Outcome walk = check_in(scene, {"a.glb", "--json", "a.json"});
  EXPECT_EQ(walk.code, 0);
  EXPECT_THAT(walk.out, HasSubstr("\nNo collisions in clip 'walk', the longest of 2: no triangles cross"));
  EXPECT_EQ(json::parse(read_file(scene / "a.json"))["objects"][0]["taken_as"],
            "clip 'walk', the longest of 2");
  const Outcome dive = check_in(scene, {"a.glb", "--clip", "dive"});
  EXPECT_EQ(dive.code, 1);
  EXPECT_THAT(dive.out, HasSubstr(" steps in clip 'dive', the first in "));
  expect_one_line_error(check_in(scene, {"a.glb", "--clip", "wlak"}), "a.glb: has no clip 'wlak'; ");
  write_file(scene / "c.obj", cube(0, 0, 0));
  expect_one_line_error(check_in(scene, {"c.obj", "--clip", "dive"}), "no file has animations");
}

TEST(Clips, AllAreCheckedOneAfterTheOther) {
  const Clips scene;
  const Outcome all = check_in(scene, {"a.glb", "--clip", "all", "--json", "a.json", "--pairs"});
  EXPECT_EQ(all.code, 1) << "the worst";
  EXPECT_THAT(all.out,
              AllOf(HasSubstr("\nNo collisions in clip 'walk': "), HasSubstr(" steps in clip 'dive', ")));
  const json report = json::parse(read_file(scene / "a.json"));
  EXPECT_EQ(report["clean"], false);
  ASSERT_EQ(report["clips"].size(), 2u);
  EXPECT_EQ(report["clips"][0]["clip"], "walk");
  EXPECT_EQ(report["clips"][0]["clean"], true);
  EXPECT_EQ(report["clips"][1]["clip"], "dive");
  EXPECT_EQ(report["clips"][1]["clean"], false);
  EXPECT_EQ(report["clips"][1]["foldproof"], report["foldproof"]);
  // One alone is reported as the same check in the list.
  check_in(scene, {"a.glb", "--clip", "dive", "--json", "b.json", "--pairs"});
  EXPECT_EQ(json::parse(read_file(scene / "b.json"))["steps"].size(), report["clips"][1]["steps"].size());

  expect_one_line_error(check_in(scene, {"a.glb", "b.glb", "--clip", "all"}), "several have animations");
  expect_one_line_error(check_in(scene, {"a.glb", "--clip", "all", "--csv", "a.csv"}),
                        "does not go with --csv");
  EXPECT_FALSE(std::filesystem::exists(scene / "a.csv"));
}

}  // namespace
}  // namespace foldproof
