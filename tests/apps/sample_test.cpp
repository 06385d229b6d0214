// foldproof sample and demo, on the command line.
#include <gmock/gmock.h>

#include <csignal>
#include <thread>

#include "apps/program.h"
#include "model/cylinder.h"

namespace foldproof {
namespace {

using namespace foldproof::testing;
using ::testing::HasSubstr;
using ::testing::Not;
namespace fs = std::filesystem;

struct Trained : TemporaryDirectory {
  Trained() {
    const Model model = trained(*bending_tube(kSmallTube, {-4.5, -2, 0, 2, 4.5}));
    EXPECT_TRUE(save_model(model, *this / "tube.model"));
  }
  Outcome run(std::vector<std::string> arguments) const {
    return run_program(std::move(arguments), {.directory = path()});
  }
};

TEST(SampleCommand, WritesShapesThatDoNotCrossAndSaysHowManyWereRefused) {
  const Trained scene;
  const Outcome drawn =
      scene.run({"sample", "tube.model", "-o", "shapes.npz", "--count", "20", "--spread", "1.2"});
  EXPECT_EQ(drawn.code, 0) << drawn.err;
  EXPECT_THAT(drawn.out, HasSubstr("shapes                  20\nrefused                 "));
  EXPECT_THAT(drawn.out, HasSubstr("drawn: they cross themselves)"));
  EXPECT_THAT(drawn.out, HasSubstr("No triangles cross in any of them, proven."));
  for (const char* name : {"shape_%04d.obj", "shape_%04d.ply", "motion.obj"}) {
    EXPECT_EQ(scene.run({"sample", "tube.model", "-o", name, "--count", "20", "--spread", "1.2", "-q"}).code,
              0);
  }
  // The same shapes in every format.
  const std::string counts = scene.run({"check", "shapes.npz", "--json", "-", "--pairs"}).out;
  const auto collisions = [](const std::string& text) {
    return text.substr(text.find("\"collisions\""), 60);
  };
  for (const std::vector<std::string>& motion : {std::vector<std::string>{"shapes.npz"},
                                                 {"shape_%04d.obj"},
                                                 {"shape_%04d.ply"},
                                                 {"motion.obj", "motion.pc2"}}) {
    auto words = motion;
    words.insert(words.begin(), "check");
    words.insert(words.end(), {"--json", "-"});
    EXPECT_EQ(collisions(scene.run(words).out), collisions(counts)) << motion[0];
    words.back() = "a.json";
    words.emplace_back("--static");
    EXPECT_EQ(scene.run(words).code, 0) << motion[0];
  }
}

TEST(SampleCommand, RepairsShapesInsteadOfRefusingThem) {
  const Trained scene;
  const Outcome refused =
      scene.run({"sample", "tube.model", "-o", "a.obj", "--count", "20", "--spread", "1.5"});
  EXPECT_THAT(refused.out, Not(HasSubstr("refused                 0 ")));
  const Outcome repaired =
      scene.run({"sample", "tube.model", "-o", "b.obj", "--count", "20", "--spread", "1.5", "--repair"});
  EXPECT_EQ(repaired.code, 0) << repaired.err;
  EXPECT_THAT(repaired.out, Not(HasSubstr("repaired                0\n")));
  EXPECT_THAT(repaired.out, HasSubstr("refused                 0  (0 % of 20 drawn"));
  EXPECT_EQ(scene.run({"check", "b.obj", "b.pc2", "--static"}).code, 0);
}

TEST(SampleCommand, RefusesInOneLineAndLeavesNothing) {
  const Trained scene;
  expect_one_line_error(scene.run({"sample", "tube.model", "-o", "a.npz", "--count", "0"}), "--count: is 0");
  expect_one_line_error(scene.run({"sample", "tube.model", "-o", "a.npz", "--seed", "99999999999999999999"}),
                        "--seed: 99999999999999999999 is out of range");
  expect_one_line_error(scene.run({"sample", "tube.model", "-o", "a.npz", "--spread", "inf"}), "--spread");
  expect_one_line_error(scene.run({"sample", "tube.model", "-o", "a.ply"}), "put %04d into the name");
  const Outcome stopped = run_program({"sample", "tube.model", "-o", "shape_%d.obj", "--count", "4000000"},
                                      {.directory = scene.path(), .while_it_runs = [](pid_t child) {
                                         std::this_thread::sleep_for(std::chrono::milliseconds(500));
                                         interrupt(child);
                                       }});
  EXPECT_EQ(stopped.code, 130);
  EXPECT_EQ(std::distance(fs::directory_iterator(scene.path()), fs::directory_iterator()), 1);
}

TEST(Demo, WritesADirectoryThatIsWholeOrNotThere) {
  const TemporaryDirectory directory;
  const auto run = [&](const RunOptions& options, std::vector<std::string> words) {
    RunOptions here = options;
    here.directory = directory.path();
    return run_program(std::move(words), here);
  };
  const Outcome stopped =
      run({.while_it_runs = [](pid_t child) { ::kill(child, SIGTERM); }}, {"demo", "legs"});
  EXPECT_NE(stopped.code, 0);
  ASSERT_EQ(run({}, {"demo", "legs/"}).code, 0);
  expect_one_line_error(run({}, {"demo", "legs"}), "legs: is already there; name a new directory");
  expect_one_line_error(run({}, {"demo", "none/legs"}),
                        "none/legs: cannot be written: No such file or directory");
  const Outcome walk = run({}, {"check", "legs/walk.glb"});
  EXPECT_EQ(walk.code, 1);
  EXPECT_THAT(walk.out, HasSubstr("no triangles cross in frame 0"));
  EXPECT_THAT(walk.out, HasSubstr("of 24 steps, the first in"));
}

}  // namespace
}  // namespace foldproof
