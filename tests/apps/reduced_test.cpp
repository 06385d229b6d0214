// The program on reduced motion: certified radii, and motions given by coordinates.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <fstream>
#include <nlohmann/json.hpp>

#include "apps/program.h"
#include "foldproof/io.h"
#include "foldproof/model.h"
#include "io/npz_builder.h"
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

TEST_F(Reduced, RadiusSaysHowFar) {
  const Outcome said = run({"radius", "cloth.model"});
  ASSERT_EQ(said.code, 0) << said.err;
  EXPECT_NE(said.out.find("\nmean "), std::string::npos) << said.out;
  EXPECT_NE(said.out.find("training poses lie within a radius"), std::string::npos) << said.out;
}

TEST_F(Reduced, RadiusKeepsItsBallsInTheModel) {
  const Outcome before = run({"radius", "cloth.model"});
  const Outcome saves = run({"radius", "cloth.model", "--save"});
  ASSERT_EQ(saves.code, 0) << saves.err;
  EXPECT_EQ(saves.out, before.out);
  EXPECT_EQ(run({"radius", "cloth.model"}).out, before.out);
  EXPECT_NE(run({"info", "cloth.model"}).out.find("\nballs kept "), std::string::npos);
  // Balls of radius 0, which no proof gives, show who reads them.
  Model marked = load_model(directory_ / "cloth.model").value();
  ASSERT_TRUE(marked.balls);
  ReducedBalls none = *marked.balls;
  std::ranges::fill(none.radii, 0.f);
  marked.balls = std::make_shared<const ReducedBalls>(std::move(none));
  ASSERT_TRUE(save_model(marked, directory_ / "marked.model"));
  const auto mean = [](const Outcome& said) {
    const std::string row = said.out.substr(said.out.find("\nmean ") + 6);
    return std::stod(row);
  };
  EXPECT_GT(mean(before), 0);
  EXPECT_EQ(mean(run({"radius", "marked.model"})), 0);
  EXPECT_GT(mean(run({"radius", "marked.model", "--clearance", "1e-7"})), 0) << "other balls";
  write_coordinates("p.csv", {0, 0.5, -0.5});
  const auto work = [&](const std::string& model) {
    const Outcome said = run({"check", "--reduced", model, "p.csv", "--json", "-"});
    EXPECT_EQ(said.code, 0) << said.err;
    return nlohmann::json::parse(said.out)["totals"]["work"];
  };
  EXPECT_NE(work("cloth.model"), work("marked.model")) << "the answer is the same, the way to it is not";
}

TEST_F(Reduced, CheckFollowsCoordinatesAndPlacements) {
  write_coordinates("p.csv", {0, 0.5, -0.5});
  const Outcome alone = run({"check", "--reduced", "cloth.model", "p.csv"});
  EXPECT_EQ(alone.code, 0) << alone.err;
  EXPECT_NE(
      alone.out.find("No collisions: no triangles cross in frame 0, and all 2 steps are proven free.\n"),
      std::string::npos)
      << alone.out;
  // Another cloth, turned upright, stands through the first.
  write_coordinates("upright.csv", {0, 0.1, 0.2}, ",0.7071067811865476,0.7071067811865476,0,0,0,0,0");
  const Outcome both =
      run({"check", "--reduced", "cloth.model", "p.csv", "cloth.model", "upright.csv", "--csv", "pairs.csv"});
  EXPECT_EQ(both.code, 1) << both.err;
  EXPECT_NE(both.out.find("\nFrame 0 starts with "), std::string::npos) << both.out;
  EXPECT_TRUE(std::ifstream(directory_ / "pairs.csv").good());
  write_coordinates("away.csv", {0, 0.1, 0.2}, ",1,0,0,0,0,0,5");
  EXPECT_EQ(run({"check", "--reduced", "cloth.model", "p.csv", "cloth.model", "away.csv"}).code, 0);
}

TEST_F(Reduced, QuaternionsMayHaveAnyLength) {
  const auto mesh_of = [&](const std::string& name, double length) {
    write_coordinates(name + ".csv", {0.1, 0.2}, fmt::format(",{0},{0},0,0,0,0,0", length));
    EXPECT_EQ(run({"check", "--reduced", "cloth.model", name + ".csv", "--ply", name + ".ply"}).code, 0);
    return read_file(directory_ / (name + ".ply"));
  };
  const std::string mesh = mesh_of("p", 1);
  EXPECT_EQ(mesh_of("large", 0x1p600), mesh);
  EXPECT_EQ(mesh_of("small", 0x1p-600), mesh);
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
    EXPECT_NE(found.out.find("\nFrame 0 starts with "), std::string::npos) << found.out;
    EXPECT_NE(found.out.find("  with collisions       0\n"), std::string::npos) << found.out;
    EXPECT_NE(read_file(directory_ / "pairs.csv").find("\n0,0,tt,0,"), std::string::npos);
  }
  const Outcome steps =
      run({"check", "--reduced", "cloth.model", "still.csv", "cloth.model", "upright.csv", "--steps-only"});
  EXPECT_EQ(steps.code, 0) << steps.err;
  EXPECT_NE(steps.out.find("not tested for crossings (--steps-only)"), std::string::npos) << steps.out;
}

TEST_F(Reduced, CheckAnswersAsForTheMotionOfVertices) {
  // A cloth that falls through another and through itself, so that contacts begin and end.
  write_coordinates("still.csv", {0, 0.2, 0.1, 0}, ",1,0,0,0,0,0,0");
  std::ofstream fall(directory_ / "fall.csv");
  for (const double z : {0.5, 0.2, -0.2, -0.5}) {
    fall << 0.3 * deviation_;
    for (Index k = 1; k < modes_; ++k) fall << ",0";
    fall << ",0.9,0.3,0.2,0.1,0.01,0.02," << z << "\n";
  }
  fall.close();
  const Outcome reduced = run({"check", "--reduced", "cloth.model", "still.csv", "cloth.model", "fall.csv",
                               "--json", "reduced.json", "--pairs", "--vtk", "all.pvd"});
  EXPECT_EQ(reduced.code, 1) << reduced.err;
  const Model model = load_model(directory_ / "cloth.model").value();
  const auto vertices = [&](const std::string& csv) {
    const NumberTable table = read_csv(directory_ / csv).value();
    const ReducedMotion motion = ReducedMotion::make(model.hierarchy(), model.learned->pca).value();
    std::vector<std::vector<double>> frames;
    for (std::uint64_t k = 0; k < table.shape[0]; ++k) {
      const std::span<const double> row(&table.values[k * table.shape[1]], table.shape[1]);
      const double* q = &row[modes_];
      const ReducedPose pose{
          row.first(modes_),
          Eigen::Quaternion<double>(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix(),
          {q[4], q[5], q[6]}};
      pose_vertices(motion, pose,
                    frames.emplace_back(3 * std::size_t{model.hierarchy()->topology().vertex_count()}));
    }
    EXPECT_TRUE(write_npz(directory_ / (csv + ".npz"),
                          *memory_motion(csv, model.hierarchy()->topology(), std::move(frames))));
    return csv + ".npz";
  };
  const Outcome whole =
      run({"check", vertices("still.csv"), vertices("fall.csv"), "--json", "whole.json", "--pairs"});
  EXPECT_EQ(whole.code, 1) << whole.err;
  const auto a = nlohmann::json::parse(read_file(directory_ / "reduced.json"));
  const auto b = nlohmann::json::parse(read_file(directory_ / "whole.json"));
  ASSERT_GT(b["totals"]["collisions"]["ee"], 10);
  EXPECT_EQ(a["start"]["pairs"], b["start"]["pairs"]);
  for (std::size_t k = 0; k < 3; ++k)
    EXPECT_EQ(a["steps"][k]["collisions"], b["steps"][k]["collisions"]) << k;
  ASSERT_FALSE(b["contacts"].empty());
  EXPECT_EQ(a["contacts"].size(), b["contacts"].size());
  EXPECT_EQ(a["contacts"][0]["frames"], b["contacts"][0]["frames"]);
  const auto lines = [](const std::string& text) { return text.substr(text.find("\ncolliding pairs"), 60); };
  EXPECT_EQ(lines(reduced.out), lines(whole.out));
  EXPECT_TRUE(std::ifstream(directory_ / "all/step000002.vtp").good());
}

TEST_F(Reduced, NamesOfColumnsMeanWhatTheyStandFor) {
  std::string modes;
  for (Index k = 0; k < modes_; ++k) modes += fmt::format("{}p{}", k ? "," : "", k);
  const auto check_named = [&](const std::string& names, const std::string& placement) {
    write_coordinates("p.csv", {0, 0.1}, placement);
    write_file(directory_ / "p.csv", names + "\n" + read_file(directory_ / "p.csv"));
    return run({"check", "--reduced", "cloth.model", "p.csv"});
  };
  const std::string placed = ",1,0,0,0,0,0,0";
  EXPECT_EQ(check_named(modes, "").code, 0);
  for (const char* names : {",w,x,y,z,tx,ty,tz", ",qw,qx,qy,qz,X,Y,Z", ",a,b,c,d,e,f,g"})
    EXPECT_EQ(check_named(modes + names, placed).code, 0) << names;
  expect_one_line_error(
      check_named(modes + ",tx,ty,tz,w,x,y,z", placed),
      fmt::format("p.csv: has 'tx' as column {}; give {} numbers, one per mode", modes_ + 1, modes_));
  expect_one_line_error(check_named(modes + ",x,y,z,w,tx,ty,tz", placed), "p.csv: has 'x' as column");
  expect_one_line_error(check_named("Time" + modes.substr(2), ""), "p.csv: has 'Time' as column 1; ");
}

TEST_F(Reduced, PlacementsInAnArrayHaveTheirShape) {
  const auto check_with = [&](const std::string& name, const std::string& shape,
                              std::vector<double> numbers) {
    const std::vector<double> p(3 * modes_);
    write_archive(directory_ / "p.npz", {{"p.npy", npy("<f8", fmt::format("3, {}", modes_), array(p))},
                                         {name + ".npy", npy("<f8", shape, array(numbers))}});
    return run({"check", "--reduced", "cloth.model", "p.npz"});
  };
  std::vector<double> turns;
  for (int k = 0; k < 3; ++k) turns.insert(turns.end(), {1, 0, 0, 0, 1, 0, 0, 0, 1});
  const std::vector<double> shifts(9);
  EXPECT_EQ(check_with("rotation", "3, 3, 3", turns).code, 0);
  EXPECT_EQ(check_with("translation", "3, 3", shifts).code, 0);
  expect_one_line_error(check_with("translation", "9,", shifts),
                        "p.npz: 'translation' is of shape 9; give 3 x 3 for the frames of 'p'");
  expect_one_line_error(check_with("translation", "1, 9", shifts), "'translation' is of shape 1 x 9; ");
  expect_one_line_error(check_with("rotation", "3, 9", turns),
                        "'rotation' is of shape 3 x 9; give 3 x 3 x 3");
}

TEST_F(Reduced, AnExtensionMayBeInUpperCase) {
  write_archive(
      directory_ / "p.NPZ",
      {{"p.npy", npy("<f8", fmt::format("3, {}", modes_), array(std::vector<double>(3 * modes_)))}});
  EXPECT_EQ(run({"check", "--reduced", "cloth.model", "p.NPZ"}).code, 0);
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
      {{"check", "--reduced", "cloth.model", "p.csv", "--fps", "30"}, "does not go with --static"},
      {{"check", "--reduced", "cloth.model", "p.csv", "--separate"}, "does not go with --static"},
      {{"check", "--reduced", "cloth.model", "p.csv", "--sequence"}, "--sequence or --clip"},
      {{"check", "--reduced", "cloth.model", "p.csv", "--clip", "a"}, "--sequence or --clip"},
      {{"check", "--reduced", "poses.npz", "p.csv"}, "poses.npz"},
      {{"radius", "poses.npz"}, "poses.npz"},
      {{"radius", "cloth.model", "--clearance", "-1"}, "--clearance"}};
  for (const auto& [arguments, said] : mistakes) expect_one_line_error(run(arguments), said);
}

}  // namespace
}  // namespace foldproof::testing
