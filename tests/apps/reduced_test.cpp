// The program on reduced motion: certified radii, and motions given by coordinates.
#include <fstream>

#include "apps/program.h"
#include "foldproof/io.h"
#include "foldproof/model.h"
#include "reduced/shapes.h"

namespace foldproof::testing {
namespace {

class Reduced : public ::testing::Test {
 protected:
  void SetUp() override {
    const ReducedMesh mesh = waving_cloth(12, 2);
    const auto motion = mesh.motion();
    std::mt19937 random(41);
    std::vector<std::vector<double>> poses;
    for (int k = 0; k < 10; ++k) {
      auto p = random_direction(*motion, random);
      motion->positions(p, poses.emplace_back(mesh.rest.size()));
    }
    ASSERT_TRUE(write_npz(directory_ / "poses.npz", *memory_motion("poses", mesh.topology, poses)));
    const Outcome trained = run({"train", "poses.npz", "-o", "cloth.model", "--quiet"});
    ASSERT_EQ(trained.code, 0) << trained.err;
    modes_ = load_model(directory_ / "cloth.model").value().learned->pca.modes();
    deviation_ = load_model(directory_ / "cloth.model").value().learned->pca.deviations[0];
  }
  Outcome run(std::vector<std::string> arguments) {
    RunOptions options;
    options.directory = directory_.path();
    return run_program(std::move(arguments), options);
  }
  // Frames along the first mode, in deviations, each row followed by `more`.
  void write_coordinates(const std::string& name, const std::vector<double>& frames,
                         const std::string& more = "") {
    std::ofstream file(directory_ / name);
    for (const double f : frames) {
      file << f * deviation_;
      for (Index k = 1; k < modes_; ++k) file << ",0";
      file << more << "\n";
    }
  }
  TemporaryDirectory directory_;
  Index modes_ = 0;
  double deviation_ = 0;
};

TEST_F(Reduced, RadiusSaysHowFarAndItsSamplesAreFree) {
  const Outcome said =
      run({"radius", "cloth.model", "--sample", "6", "-o", "samples.npz", "--ply", "left.ply"});
  ASSERT_EQ(said.code, 0) << said.err;
  EXPECT_NE(said.out.find("\nmean "), std::string::npos) << said.out;
  EXPECT_NE(said.out.find("training poses lie within a radius"), std::string::npos) << said.out;
  EXPECT_EQ(run({"check", "samples.npz", "--static", "--quiet"}).code, 0);
  EXPECT_EQ(run({"check", "samples.npz", "--quiet"}).code, 0) << "from shape to shape";
  EXPECT_TRUE(std::ifstream(directory_ / "left.ply").good());
}

TEST_F(Reduced, CheckFollowsCoordinatesAndPlacements) {
  write_coordinates("p.csv", {0, 0.5, -0.5});
  const Outcome alone = run({"check", "--reduced", "cloth.model", "p.csv"});
  EXPECT_EQ(alone.code, 0) << alone.err;
  EXPECT_NE(alone.out.find("2 steps, 0 with collisions"), std::string::npos) << alone.out;
  // Another cloth, turned upright, stands through the first.
  write_coordinates("upright.csv", {0, 0.1, 0.2}, ",0.7071067811865476,0.7071067811865476,0,0,0,0,0");
  const Outcome both =
      run({"check", "--reduced", "cloth.model", "p.csv", "cloth.model", "upright.csv", "--csv", "pairs.csv"});
  EXPECT_EQ(both.code, 1) << both.err;
  EXPECT_EQ(both.out.find("frame 0 starts with "), 0u) << both.out;
  EXPECT_TRUE(std::ifstream(directory_ / "pairs.csv").good());
  write_coordinates("away.csv", {0, 0.1, 0.2}, ",1,0,0,0,0,0,5");
  EXPECT_EQ(run({"check", "--reduced", "cloth.model", "p.csv", "cloth.model", "away.csv"}).code, 0);
}

TEST_F(Reduced, CheckAsksTheFirstFrameToo) {
  // Upright and still, or a single frame: no contact begins, and yet one cloth stands through the other.
  const std::string upright = ",0.7071067811865476,0.7071067811865476,0,0,0.0312,0.0071,0.0213";
  write_coordinates("still.csv", {0, 0});
  write_coordinates("upright.csv", {0, 0}, upright);
  write_coordinates("still1.csv", {0});
  write_coordinates("upright1.csv", {0}, upright);
  for (const std::string frames : {"", "1"}) {
    const std::vector<std::string> both{"check",       "--reduced",
                                        "cloth.model", "still" + frames + ".csv",
                                        "cloth.model", "upright" + frames + ".csv",
                                        "--csv",       "pairs.csv"};
    const Outcome found = run(both);
    EXPECT_EQ(found.code, 1) << found.err;
    EXPECT_EQ(found.out.find("frame 0 starts with "), 0u) << found.out;
    EXPECT_NE(found.out.find("1 step, 0 with collisions"), std::string::npos) << found.out;
    EXPECT_NE(read_file(directory_ / "pairs.csv").find("\n0,0,tt,0,"), std::string::npos);
  }
  const Outcome steps =
      run({"check", "--reduced", "cloth.model", "still.csv", "cloth.model", "upright.csv", "--steps-only"});
  EXPECT_EQ(steps.code, 0) << steps.err;
  EXPECT_EQ(steps.out.find("not tested for crossings in frame 0"), 0u) << steps.out;
}

TEST_F(Reduced, RefusesInOneLine) {
  write_coordinates("p.csv", {0, 0.5});
  write_coordinates("one.csv", {0});
  write_coordinates("wide.csv", {0, 1}, ",1,2");
  const std::vector<std::pair<std::vector<std::string>, const char*>> mistakes{
      {{"check", "--reduced", "cloth.model"}, "give MODEL COORDINATES in turn"},
      {{"check", "--reduced", "cloth.model", "missing.csv"}, "missing.csv"},
      {{"check", "--reduced", "cloth.model", "one.csv", "--steps-only"}, "one.csv: has 1 frame"},
      {{"check", "--reduced", "cloth.model", "wide.csv"}, "wide.csv"},
      {{"check", "--reduced", "cloth.model", "p.csv", "--static"}, "--static"},
      {{"check", "--reduced", "poses.npz", "p.csv"}, "poses.npz"},
      {{"radius", "poses.npz"}, "poses.npz"},
      {{"radius", "cloth.model", "--sample", "3"}, "--sample: goes with -o"},
      {{"radius", "cloth.model", "--clearance", "-1"}, "--clearance"}};
  for (const auto& [arguments, said] : mistakes) expect_one_line_error(run(arguments), said);
}

}  // namespace
}  // namespace foldproof::testing
