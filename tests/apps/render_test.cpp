// render on the command line.
#include <gmock/gmock.h>

#include "apps/program.h"
#include "model/cylinder.h"

namespace foldproof {
namespace {

using namespace foldproof::testing;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::StartsWith;

/// A tube that bends until it meets itself, and a motion of two frames.
struct Scene : TemporaryDirectory {
  Scene() {
    EXPECT_TRUE(write_npz(path() + "/bend.npz", *bending_tube(kTube, {0, 1, 4.5, 6.5})));
    EXPECT_TRUE(write_npz(path() + "/short.npz", *bending_tube(kTube, {0, 1})));
  }
  Outcome run(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "render");
    return run_program(std::move(arguments), {.directory = path()});
  }
  std::string png(const std::string& name) const {
    const std::string bytes = read_file(*this / name);
    EXPECT_THAT(bytes, StartsWith("\x89PNG\r\n\x1a\n")) << name;
    return bytes;
  }
};

/// Width and height from the header.
std::array<int, 2> size_of(const std::string& png) {
  const auto number = [&](std::size_t at) {
    int value = 0;
    for (std::size_t k = 0; k < 4; ++k) value = value * 256 + static_cast<unsigned char>(png[at + k]);
    return value;
  };
  return {number(16), number(20)};
}

TEST(RenderProgram, DrawsAFrame) {
  const Scene scene;
  const Outcome drawn = scene.run({"bend.npz", "-o", "a.png"});
  EXPECT_EQ(drawn.code, 0) << drawn.err;
  EXPECT_EQ(drawn.out, "");
  EXPECT_EQ(size_of(scene.png("a.png")), (std::array{1200, 900}));
  const std::vector<std::string> small{"bend.npz", "--size", "80x60", "-o"};
  const auto with = [&](const char* name, std::vector<std::string> more) {
    std::vector<std::string> arguments = small;
    arguments.emplace_back(name);
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome outcome = scene.run(arguments);
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    const std::string bytes = scene.png(name);
    EXPECT_EQ(size_of(bytes), (std::array{80, 60}));
    return bytes;
  };
  const std::string first = with("b.png", {});
  EXPECT_EQ(with("c.png", {}), first);
  EXPECT_EQ(with("c.png", {"--frame", "-4"}), first);
  EXPECT_NE(with("d.png", {"--frame", "2"}), first);
  EXPECT_NE(with("e.png", {"--view", "side"}), first);
  EXPECT_NE(with("f.png", {"--flat"}), first);
  EXPECT_NE(with("i.png", {"--up", "z"}), first);
  EXPECT_EQ(with("j.png", {"--up", "y", "--view", "auto"}), first);
  EXPECT_EQ(with("g.png", {"--view", "0,0,2"}), with("h.png", {"--view", "front"}));
}

TEST(RenderProgram, ColorsCollisionsAndContacts) {
  const Scene scene;
  const auto output = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), {"--size", "90x60", "-o", "a.png"});
    const Outcome outcome = scene.run(arguments);
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    scene.png("a.png");
    return outcome.out;
  };
  EXPECT_EQ(output({"bend.npz", "--color", "collisions"}), "Nothing crosses in frame 0.\n");
  const std::string plain = scene.png("a.png");
  EXPECT_THAT(output({"bend.npz", "--color", "collisions", "--frame", "2"}),
              HasSubstr("pairs on the way to the next, the first 0."));
  EXPECT_NE(scene.png("a.png"), plain);
  EXPECT_THAT(
      output({"bend.npz", "--color", "collisions", "--frame", "3"}),
      ::testing::MatchesRegex("bend goes through itself.*, in frame 3(; [0-9]+ more contacts?)?\\.\n"));
  EXPECT_EQ(output({"bend.npz", "--color", "contacts"}), "Nothing crosses in frame 0.\n");
  EXPECT_THAT(output({"bend.npz", "--color", "contacts", "--frame", "3"}), HasSubstr(" in frame 3"));
  EXPECT_EQ(scene.run({"bend.npz", "--color", "collisions", "--frame", "2", "--quiet", "-o", "a.png"}).out,
            "");
}

TEST(RenderProgram, ExplainsMistakesInOneLine) {
  const Scene scene;
  const std::vector<std::pair<std::vector<std::string>, const char*>> mistakes{
      {{"bend.npz"}, "--output is required"},
      {{"bend.npz", "-o", "no/a.png"}, "cannot be written"},
      {{"none.npz", "-o", "a.png"}, "none.npz"},
      {{"bend.npz", "-o", "a.png", "--frame", "4"}, "there is no frame 4 among 4"},
      {{"bend.npz", "-o", "a.png", "--frame", "-5"}, "there is no frame -5 among 4"},
      {{"bend.npz", "-o", "a.png", "--view", "left"}, "'left' is no view"},
      {{"bend.npz", "-o", "a.png", "--up", "x"}, "x"},
      {{"bend.npz", "-o", "a.png", "--size", "10"}, "'10' is no size"},
      {{"bend.npz", "-o", "a.png", "--size", "0x10"}, "'0x10' is no size"},
      {{"bend.npz", "-o", "a.png", "--size", "99999x10"}, "cannot be drawn"},
      {{"bend.npz", "-o", "a.png", "--color", "rainbow"}, "rainbow"},
      {{"bend.npz", "short.npz", "-o", "a.png"}, "has 2 frames, but bend.npz has 4"},
  };
  for (const auto& [arguments, problem] : mistakes) {
    expect_one_line_error(scene.run(arguments), problem);
  }
  EXPECT_FALSE(std::filesystem::exists(scene / "a.png"));
  const Outcome help = scene.run({"--help"});
  EXPECT_EQ(help.code, 0);
  EXPECT_THAT(help.out, HasSubstr("foldproof render walk.glb --frame 12 --color collisions -o c.png"));
}

}  // namespace
}  // namespace foldproof
