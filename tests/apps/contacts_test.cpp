#include <fmt/format.h>
#include <gmock/gmock.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>

#include "apps/program.h"
#include "io/gltf_builder.h"
#include "report/spheres.h"

namespace foldproof {
namespace {

using namespace foldproof::testing;
using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;

// Two spheres in one mesh; they cross from the start and stay so.
struct Merged : Workplace {
  Merged() { EXPECT_TRUE(write_npz(*this / "merged.npz", *motion)); }
  std::unique_ptr<Motion> motion = two_spheres(1.03);
  void write(const std::string& name, const std::string& text) const { std::ofstream(*this / name) << text; }
  // The first half of the triangles is one sphere, the second the other.
  std::string halves() const {
    std::string text;
    const std::size_t count = motion->topology().triangles().size();
    for (std::size_t i = 0; i < count; ++i) text += i < count / 2 ? "left\n" : "right\n";
    return text;
  }
};

TEST(Contacts, AreInTheSummaryWithPartsFramesAndDepth) {
  const Merged scene;
  scene.write("parts.txt", scene.halves());
  const Outcome found = check_in(scene, {"merged.npz", "--parts", "parts.txt", "--unit", "cm"});
  EXPECT_EQ(found.code, 1) << found.err;
  EXPECT_THAT(found.out, HasSubstr("\n1 contact, the worst first:\n#1  left - right  frames 0-"));
  EXPECT_THAT(found.out,
              ::testing::ContainsRegex(" [0-9.]+ (mm|cm) deep, [0-9]+ triangles, from the start\n"));
  EXPECT_THAT(found.out,
              ::testing::ContainsRegex(
                  "\nleft and right go through each other, [0-9.]+ (mm|cm) at worst, in frame [0-9]\\.\n"
                  "Frame 0 starts with [0-9,]+ crossing pairs of triangles"));
  const Outcome plain = check_in(scene, {"merged.npz"});
  EXPECT_THAT(plain.out, HasSubstr("#1  at ("));
  EXPECT_THAT(plain.out, Not(HasSubstr(" cm")));
  EXPECT_EQ(check_in(scene, {"merged.npz", "--quiet"}).out, "");
}

TEST(Contacts, SayWhereTheyAreFarFromTheOriginToo) {
  const TemporaryDirectory directory;
  const auto near = two_spheres(1.03);
  std::vector<double> x(std::size_t{3} * near->topology().vertex_count());
  ASSERT_TRUE(near->read_frame(0, x));
  for (double& value : x) value += 1e6 + 0.5;
  ASSERT_TRUE(write_npz(directory / "far.npz", *memory_motion("far", near->topology(), {x})));
  const Outcome found = check_in(directory, {"far.npz"});
  EXPECT_THAT(found.out, ::testing::ContainsRegex("#1  at \\(100000[01]\\.[0-9]+, "));
}

// An OBJ and a glTF name parts and unit themselves; options win.
TEST(Contacts, HaveTheNamesOfTheFile) {
  const Merged scene;
  const auto triangles = scene.motion->topology().triangles();
  std::vector<double> x(std::size_t{3} * scene.motion->topology().vertex_count());
  ASSERT_TRUE(scene.motion->read_frame(0, x));
  std::string text;
  for (std::size_t i = 0; i < x.size(); i += 3) text += fmt::format("v {} {} {}\n", x[i], x[i + 1], x[i + 2]);
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    if (2 * i % triangles.size() == 0) text += i == 0 ? "g near\n" : "g far\n";
    text += fmt::format("f {} {} {}\n", triangles[i][0] + 1, triangles[i][1] + 1, triangles[i][2] + 1);
  }
  scene.write("a.obj", text);
  scene.write("parts.txt", scene.halves());
  EXPECT_THAT(check_in(scene, {"a.obj"}).out, HasSubstr("\n#1  near - far  frame 0"));
  EXPECT_THAT(check_in(scene, {"a.obj", "--parts", "parts.txt"}).out,
              HasSubstr("\n#1  left - right  frame 0"));
  check_in(scene, {"a.obj", "--json", "a.json", "--contacts-csv", "a.csv"});
  EXPECT_EQ(scene.report("a.json")["contacts"][0]["sides"][1]["name"], "far");
  EXPECT_FALSE(scene.report("a.json")["settings"].contains("unit"));
  EXPECT_THAT(read_file(scene / "a.csv"), HasSubstr("\n1,near,far,"));
}

TEST(Contacts, HaveTheUnitOfTheFormat) {
  GltfBuilder b;
  b.triangle() = {{"attributes",
                   {{"POSITION", b.floats("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0, 0.2f, 0.2f, -1, 0.3f, 0.2f, 1,
                                                   0.2f, 0.3f, 1})}}}};
  b.json["nodes"] = {{{"mesh", 0}}};
  const TemporaryDirectory directory;
  std::ofstream(directory / "a.gltf") << b.gltf();
  EXPECT_THAT(check_in(directory, {"a.gltf", "--json", "a.json"}).out,
              ::testing::ContainsRegex(" (m|cm|mm)( deep)?, [0-9]+ triangles, from the start\n"));
  EXPECT_EQ(json::parse(read_file(directory / "a.json"))["settings"]["unit"], "m");
  EXPECT_THAT(check_in(directory, {"a.gltf", "--unit", "feet"}).out,
              ::testing::ContainsRegex(" feet( deep)?, [0-9]+ triangles, from the start\n"));
}

TEST(Contacts, AreInTheJsonReport) {
  const Merged scene;
  check_in(scene, {"merged.npz", "--json", "a.json"});
  check_in(scene, {"merged.npz", "--json", "b.json", "--pairs"});
  const json contact = scene.report("a.json")["contacts"].at(0),
             with = scene.report("b.json")["contacts"].at(0);
  EXPECT_EQ(contact["number"], 1);
  EXPECT_EQ(contact["from_start"], true);
  EXPECT_EQ(contact["healed"], false);
  EXPECT_EQ(contact["frames"].size(), scene.motion->frame_count());
  EXPECT_GT(contact["depth"], 0.1);
  EXPECT_EQ(contact["frames"][0]["closed"], true);
  EXPECT_FALSE(contact.contains("curves"));
  EXPECT_GT(with["sides"][0]["triangles"].size(), with["sides"][0]["inside"].size());
  EXPECT_GT(with["curves"][0].size(), 8u);
  EXPECT_EQ(with["curves"][0].front(), with["curves"][0].back());
  EXPECT_EQ(scene.report("a.json")["totals"]["contacts"]["unknown_frames"], 0);
}

TEST(Contacts, AreRowsOfACsv) {
  const Merged scene;
  scene.write("parts.txt", scene.halves());
  check_in(scene, {"merged.npz", "--parts", "parts.txt", "--contacts-csv", "a.csv"});
  const std::string rows = read_file(scene / "a.csv");
  EXPECT_THAT(rows, HasSubstr("\n1,left,right,1,0,0,"));
  EXPECT_EQ(std::count(rows.begin(), rows.end(), '\n'), 1 + scene.motion->frame_count());

  scene.write("parts.txt", std::regex_replace(scene.halves(), std::regex("left"), "le\rft"));
  check_in(scene,
           {"merged.npz", "--parts", "parts.txt", "--static", "--limit", "5", "--contacts-csv", "a.csv"});
  EXPECT_THAT(read_file(scene / "a.csv"), HasSubstr("\n# contacts join the 15 listed of "));
  check_in(scene, {"merged.npz", "--parts", "parts.txt", "--contacts-csv", "a.csv"});
  EXPECT_THAT(read_file(scene / "a.csv"), HasSubstr("\n1,\"le\rft\",right,"));
}

TEST(Contacts, OfPosesAreFoundToo) {
  const Merged scene;
  const Outcome found = check_in(scene, {"merged.npz", "--static"});
  EXPECT_THAT(found.out, HasSubstr("\n1 contact, the worst first:\n"));
}

TEST(Contacts, SayWhatIsNotKnown) {
  const Merged scene;
  const Outcome cut = check_in(scene, {"merged.npz", "--limit", "5"});
  EXPECT_THAT(cut.out, Not(HasSubstr("contacts, the worst")));
  EXPECT_THAT(cut.out, HasSubstr("it is not known which triangles cross: too many pairs (--limit).\n"));
  const TemporaryDirectory directory;
  write_frames(directory.path() + "/sink", *sinking_triangle(kSinking));
  const Outcome steps = check_in(directory, {"sink", "--steps-only"});
  EXPECT_THAT(steps.out, HasSubstr("it is not known which triangles cross (--steps-only).\n"));
  EXPECT_THAT(steps.out, HasSubstr("touches; not known whether it crosses"));
}

TEST(Contacts, BadPartsFilesAreOneLineErrors) {
  const Merged scene;
  scene.write("short.txt", "left\nright\n");
  scene.write("empty.txt", "left\n\nright\n");
  const auto error = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "merged.npz");
    const Outcome found = check_in(scene, arguments);
    EXPECT_EQ(found.code, 2);
    EXPECT_EQ(std::count(found.err.begin(), found.err.end(), '\n'), 1);
    return found.err;
  };
  EXPECT_THAT(error({"--parts", "short.txt"}), HasSubstr("short.txt: has 2 lines for "));
  EXPECT_THAT(error({"--parts", "empty.txt"}), HasSubstr("empty.txt:2: is empty"));
  EXPECT_THAT(error({"--parts", "none.txt"}), HasSubstr("none.txt"));
  EXPECT_THAT(error({"--parts", "short.txt", "--parts", "short.txt"}), HasSubstr("for 1 object"));
}

}  // namespace
}  // namespace foldproof
