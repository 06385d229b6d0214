// train, info and check --model on the command line.
#include <gmock/gmock.h>

#include <csignal>
#include <nlohmann/json.hpp>
#include <thread>

#include "apps/program.h"
#include "model/cylinder.h"

namespace foldproof {
namespace {

using namespace foldproof::testing;
using nlohmann::json;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::MatchesRegex;

/// A tube that bends until it meets itself, poses of it, its model, and the sinking triangle.
struct Scene : Workplace {
  Scene() {
    EXPECT_TRUE(write_npz(path() + "/bend.npz", *bending_tube(kTube, {0, 1, 2, 3, 4.5, 6.5})));
    EXPECT_TRUE(write_npz(path() + "/long.npz", *bending_tube({32, 50}, {0, 1, 2, 3, 4.5, 6.5})));
    write_frames(path() + "/poses", *bending_tube(kTube, {0, 2, 4}));
    write_frames(path() + "/sink", *sinking_triangle(kSinking));
  }
};

TEST(TrainProgram, WritesAModelThatCheckUses) {
  const Scene scene;
  const Outcome trained = scene.run({"train", "poses", "-o", "tube.model"});
  EXPECT_EQ(trained.code, 0) << trained.err;
  EXPECT_EQ(trained.err, "");
  for (const char* part :
       {"triangles               3,072\n", "poses                   3  (3 references)\n", "charts",
        "bytes per triangle and reference)\n", "time", "% of leaves and of pairs"}) {
    EXPECT_THAT(trained.out, HasSubstr(part));
  }
  EXPECT_EQ(
      scene.run({"check", "bend.npz", "--model", "tube.model", "--json", "with", "--csv", "with.csv"}).code,
      1);
  EXPECT_EQ(scene.run({"check", "bend.npz", "--no-certificates", "--json", "off", "--csv", "off.csv"}).code,
            1);
  EXPECT_EQ(read_file(scene / "with.csv"), read_file(scene / "off.csv"));
  const json with = scene.report("with"), off = scene.report("off");
  EXPECT_EQ(with["objects"][0]["model"], "tube.model");
  EXPECT_EQ(off["objects"][0]["model"], nullptr);
  EXPECT_EQ(with["settings"]["certificates"], true);
  EXPECT_EQ(off["settings"]["certificates"], false);
  EXPECT_EQ(off["totals"]["work"]["certificate_tests"], 0);
  // From the first step on, where no chart has been drawn on the way.
  EXPECT_GT(with["steps"][0]["work"]["certificate_passes"], 100);
  EXPECT_LT(with["steps"][0]["work"]["leaf_pairs"].get<int>(),
            off["steps"][0]["work"]["leaf_pairs"].get<int>() / 4);
}

TEST(TrainProgram, OptionsChooseThePoses) {
  const Scene scene;
  const auto poses_of = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"train", "--quiet", "-o", "a.model"});
    const Outcome trained = scene.run(arguments);
    EXPECT_EQ(trained.code, 0) << trained.err;
    EXPECT_EQ(trained.out, "");
    EXPECT_EQ(scene.run({"info", "a.model", "--json", "a.json"}).code, 0);
    return scene.report("a.json")["poses"];
  };
  const auto frames = poses_of({"bend.npz", "--frames", "1:5:2", "--threads", "1"});
  ASSERT_EQ(frames.size(), 2u);
  EXPECT_EQ(frames[1]["name"], "bend.npz, frame 3");
  const auto several = poses_of({"poses", "bend.npz", "--references", "2"});
  ASSERT_EQ(several.size(), 9u);
  int references = 0;
  for (const json& pose : several) references += pose["reference"].get<bool>();
  EXPECT_EQ(references, 2);
}

TEST(TrainProgram, InfoShowsWhatIsInside) {
  const Scene scene;
  ASSERT_EQ(scene.run({"train", "bend.npz", "-o", "tube.model"}).code, 0);
  const Outcome shown = scene.run({"info", "tube.model"});
  EXPECT_EQ(shown.code, 0);
  for (const char* part :
       {"tube.model", "trained by              foldproof ", "3,072 triangles, 1,568 vertices, hash ",
        "poses                   6  (6 references)", "yes        bend.npz, frame 0\n", "level ",
        "kappa, median", "\npairs "}) {
    EXPECT_THAT(shown.out, HasSubstr(part));
  }
  ASSERT_EQ(scene.run({"info", "tube.model", "--json", "a.json"}).code, 0);
  const json info = scene.report("a.json");
  EXPECT_EQ(info["triangles"], 3072);
  EXPECT_EQ(info["bytes"], std::filesystem::file_size(scene / "tube.model"));
  EXPECT_EQ(info["poses"].size(), 6u);
  EXPECT_THAT(info["topology_hash"].get<std::string>(), MatchesRegex("[0-9a-f]{16}"));
  int nodes = 0, charts = info["pairs"]["charts"].get<int>();
  for (const json& level : info["levels"]) {
    nodes += level["nodes"].get<int>();
    charts += level["charts"].get<int>();
  }
  EXPECT_EQ(nodes, 2 * info["leaves"].get<int>() - 1);
  EXPECT_EQ(charts, info["charts"]);
  EXPECT_GE(info["levels"].back()["kappa_largest"], 1.0);
}

TEST(TrainProgram, InfoNamesWhatIsHardToProve) {
  const Scene scene;
  ASSERT_EQ(scene.run({"train", "sink", "--frames", "0", "-o", "sinking.model"}).code, 0);
  EXPECT_THAT(scene.run({"info", "sinking.model"}).out,
              HasSubstr("Hard to prove: 1 of 1 leaves in some reference pose, 1 in every one.\n"
                        "     poses  why          triangles\n    1 of 1  overlapping  0 1\n"));
  ASSERT_EQ(scene.run({"info", "sinking.model", "--json", "a.json"}).code, 0);
  EXPECT_EQ(scene.report("a.json")["hard_leaves"],
            json::parse(R"([{"references":1,"why":"overlapping","triangles":[0,1]}])"));
}

TEST(TrainProgram, AModelServesTheObjectsOfItsMesh) {
  const Scene scene;
  ASSERT_EQ(scene.run({"train", "poses", "-o", "tube.model", "--quiet"}).code, 0);
  ASSERT_EQ(scene.run({"train", "long.npz", "-o", "long.model", "--quiet"}).code, 0);
  const auto models_of = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"check", "long.npz", "bend.npz"});
    arguments.insert(arguments.end(), {"--frames", ":2", "--quiet", "--json", "a.json"});
    EXPECT_EQ(scene.run(arguments).code, 1);
    const json objects = scene.report("a.json")["objects"];
    return std::vector<json>{objects[0]["model"], objects[1]["model"]};
  };
  EXPECT_THAT(models_of({"--model", "tube.model"}), ElementsAre(nullptr, "tube.model"));
  EXPECT_THAT(models_of({"--model", "long.model", "--model", "tube.model"}),
              ElementsAre("long.model", "tube.model"));
}

TEST(TrainProgram, HelpTeaches) {
  const Scene scene;
  for (const char* command : {"train", "info", "check"}) {
    const Outcome help = scene.run({command, "--help"});
    EXPECT_EQ(help.code, 0);
    EXPECT_THAT(help.out, HasSubstr("Examples:"));
    EXPECT_THAT(help.out, HasSubstr("body.model"));
  }
}

class TrainMistakes : public ::testing::TestWithParam<Mistake> {};

TEST_P(TrainMistakes, GetOneLineAndLeaveNoFile) {
  const Scene scene;
  ASSERT_EQ(scene.run({"train", "poses", "-o", "tube.model", "--quiet"}).code, 0);
  const std::string model = read_file(scene / "tube.model");
  write_file(scene / "cut.model", model.substr(0, model.size() / 2));
  write_file(scene / "foreign.model", "v 0 0 0\n");
  const auto before = scene.names();
  const Outcome outcome = scene.run(GetParam().arguments);
  expect_one_line_error(outcome, GetParam().said);
  EXPECT_THAT(outcome.err, HasSubstr("; "));
  EXPECT_EQ(scene.names(), before);
}

INSTANTIATE_TEST_SUITE_P(
    Train, TrainMistakes,
    ::testing::Values(
        Mistake{{"train"}, "POSES"}, Mistake{{"train", "poses"}, "--output"},
        Mistake{{"train", "missing.obj", "-o", "a.model"}, "missing.obj"},
        Mistake{{"train", "poses", "-o", "no/where.model"}, "no/where.model"},
        Mistake{{"train", "poses", "-o", "/dev/full"}, "/dev/full"},
        Mistake{{"train", "poses", "-o", "a.model", "--frames", "9:"}, "--frames: selects none"},
        Mistake{{"train", "poses", "-o", "a.model", "--frames", "x"}, "'x'"},
        Mistake{{"train", "poses", "-o", "a.model", "--threads", "-1"}, "--threads"},
        Mistake{{"train", "poses", "-o", "a.model", "--references", "-1"}, "--references"},
        Mistake{{"train", "poses", "-o", "a.model", "--fps", "0"}, "--fps"},
        Mistake{{"train", "poses", "long.npz", "-o", "a.model"},
                "long.npz: has other triangles than poses: 3200 over 1632 vertices instead of 3072"}));

INSTANTIATE_TEST_SUITE_P(
    Use, TrainMistakes,
    ::testing::Values(
        Mistake{{"info"}, "MODEL"}, Mistake{{"info", "missing.model"}, "missing.model"},
        Mistake{{"info", "bend.npz"}, "bend.npz: is not a Foldproof model"},
        Mistake{{"info", "cut.model"}, "cut.model: is damaged or cut off"},
        Mistake{{"info", "tube.model", "--json", "no/where"}, "no/where"},
        Mistake{{"check", "bend.npz", "--model", "foreign.model"}, "is not a Foldproof model"},
        Mistake{{"check", "bend.npz", "--model", "tube.model", "--no-certificates"}, "--model"},
        Mistake{{"check", "long.npz", "--model", "tube.model"},
                "tube.model: is a model of another mesh: 3072 triangles over 1568 vertices, but long.npz"},
        Mistake{{"check", "long.npz", "long.npz", "--model", "tube.model"}, "of none of these meshes"},
        Mistake{{"check", "bend.npz", "--model", "tube.model", "--model", "tube.model"},
                "models: are 2 for 1 motions"},
        Mistake{
            {"check", "bend.npz", "bend.npz", "bend.npz", "--model", "tube.model", "--model", "tube.model"},
            "models: are 2 for 3 motions"}));

TEST(TrainProgram, InterruptedLeavesNoFile) {
  const Scene scene;
  std::vector<double> angles(400);
  for (std::size_t k = 0; k < angles.size(); ++k) angles[k] = 0.01 * static_cast<double>(k);
  ASSERT_TRUE(write_npz(scene / "many.npz", *bending_tube({64, 96}, angles)));
  const auto before = scene.names();
  RunOptions options{.directory = scene.path()};
  options.while_it_runs = [](pid_t child) {
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    interrupt(child);
  };
  const Outcome outcome = run_program({"train", "many.npz", "-o", "a.model", "--references", "400"}, options);
  EXPECT_EQ(outcome.code, 130);
  EXPECT_EQ(outcome.out, "");
  EXPECT_EQ(outcome.err, "foldproof: interrupted: training was not finished; no model was written\n");
  EXPECT_EQ(scene.names(), before);
}

}  // namespace
}  // namespace foldproof
