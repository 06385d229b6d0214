// Lines and points of files, as the program checks and names them.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "apps/program.h"

namespace foldproof {
namespace {

using namespace foldproof::testing;
using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;

// An OBJ line, or a vertex in no face, goes through a triangle from one file to the next.
void write_pair(const TemporaryDirectory& scene, const std::string& name, const std::string& above,
                const std::string& below, const std::string& rest) {
  std::filesystem::create_directories(scene / name);
  const std::string face = "v -1 -1 0\nv 1 -1 0\nv 0 1 0\n";
  std::ofstream(scene / (name + "/a0.obj")) << face << above << "f 1 2 3\n" << rest;
  std::ofstream(scene / (name + "/a1.obj")) << face << below << "f 1 2 3\n" << rest;
}

TEST(Lines, ALineOfAFilePierces) {
  const TemporaryDirectory scene;
  write_pair(scene, "hair", "v 0 0 1\nv 0 0 2\n", "v 0 0 -2\nv 0 0 -1\n", "l 4 5\n");
  const Outcome found = check_in(scene, {"hair", "--pairs", "--json", "a.json"});
  EXPECT_EQ(found.code, 1);
  EXPECT_THAT(found.out, HasSubstr("hair: 1 line in no face\n"));
  EXPECT_THAT(found.out, HasSubstr("pierces between frames, 2 pairs\n"));
  const json report = json::parse(read_file(scene / "a.json"));
  EXPECT_EQ(report["objects"][0]["triangles"], 1);
  EXPECT_EQ(report["objects"][0]["lines"], 1);
  EXPECT_EQ(report["contacts"][0]["pierces"], true);
  write_pair(scene, "still", "v 0 0 1\nv 0 0 -1\n", "v 0 0 1\nv 0 0 -1\n", "l 4 5\n");
  EXPECT_THAT(check_in(scene, {"still"}).out, HasSubstr("pierces in 1 place, from the start\n"));
  EXPECT_THAT(check_in(scene, {"still", "--pairs"}).out, HasSubstr("  face 0 crosses line 0\n"));
}

TEST(Lines, SaysThatVerticesInNoFaceWereNotChecked) {
  const TemporaryDirectory scene;
  write_pair(scene, "pts", "v 0 0 1\n", "v 0 0 -1\n", "");
  const Outcome free = check_in(scene, {"pts", "--json", "a.json"});
  EXPECT_EQ(free.code, 0);
  EXPECT_THAT(free.out,
              HasSubstr(", and the one step is proven free; 1 vertex in no face was not checked.\n"));
  EXPECT_EQ(json::parse(read_file(scene / "a.json"))["objects"][0]["unchecked"],
            json::array({"1 vertex in no face was not checked"}));
  const Outcome found = check_in(scene, {"pts", "--points"});
  EXPECT_EQ(found.code, 1);
  EXPECT_THAT(found.out, Not(HasSubstr("not checked")));
}

}  // namespace
}  // namespace foldproof
