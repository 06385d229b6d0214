// reproduce as a person uses it, and the meshes that it generates.
#include <gmock/gmock.h>

#include <Eigen/Geometry>

#include <csignal>
#include <map>
#include <numbers>
#include <regex>
#include <thread>

#include "../../apps/generated.h"
#include "apps/program.h"
#include "foldproof/check.h"
#include "model/cylinder.h"

namespace foldproof {
namespace {

using namespace foldproof::testing;
using std::numbers::pi;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

/// Six times the volume; every edge must be there once in either direction.
double closed_volume(const Topology& topology, const std::vector<double>& x) {
  std::map<Edge, int> directed;
  double volume = 0;
  for (const Triangle& t : topology.triangles()) {
    for (int k = 0; k < 3; ++k) ++directed[{t[k], t[(k + 1) % 3]}];
    const auto at = [&](Index v) { return Eigen::Map<const Vec3>(&x[3 * std::size_t{v}]); };
    volume += at(t[0]).dot(at(t[1]).cross(at(t[2])));
  }
  for (const auto& [edge, count] : directed) {
    EXPECT_EQ(count, 1);
    EXPECT_EQ(directed.count({edge[1], edge[0]}), 1u);
  }
  return volume;
}

std::size_t crossings(const Topology& topology, const std::vector<double>& x) {
  StepChecker checker({std::make_shared<const Hierarchy>(*Hierarchy::build(topology, x))});
  StaticResult answer;
  const std::span<const double> positions[] = {x};
  EXPECT_TRUE(checker.check_static(positions, {}, answer));
  return answer.crossings.size();
}

TEST(Generated, CylinderIsClosedAndBendsUntilItMeetsItself) {
  const Cylinder mesh(32, 48);
  const auto straight = mesh.pose(0, 0);
  EXPECT_NEAR(closed_volume(mesh.topology(), straight) / 6, pi * 0.25 * 10, 0.1);
  EXPECT_EQ(mesh.pose(0, 1), mesh.pose(0, 1));
  // Which way it bends is nothing to a straight one, and its vertices keep their places around it.
  const auto turned = mesh.pose(0, 1);
  for (std::size_t k = 0; k < turned.size(); ++k) ASSERT_NEAR(turned[k], straight[k], 1e-12);
  EXPECT_EQ(crossings(mesh.topology(), mesh.pose(0.9 * pi, 2)), 0u);
  EXPECT_GT(crossings(mesh.topology(), mesh.pose(1.12 * pi, 2)), 0u);
  EXPECT_NEAR(closed_volume(mesh.topology(), mesh.pose(0.9 * pi, 2)) / 6, pi * 0.25 * 10, 0.3);
}

TEST(Generated, CreatureIsClosedAndHasJoints) {
  const Creature mesh(0.09);
  const auto rest = mesh.pose(Creature::rest());
  EXPECT_GT(closed_volume(mesh.topology(), rest), 0);
  EXPECT_EQ(crossings(mesh.topology(), rest), 0u);
  Creature::Turns turns = Creature::rest();
  turns[Creature::kForeRightShin] = {1, 0, 0};
  const auto bent = mesh.pose(turns);
  double inwards = 0;
  for (std::size_t k = 0; k < rest.size(); k += 3) {
    const double way = rest[k + 2] - bent[k + 2];
    inwards = std::max(inwards, way);
    if (std::abs(way) < 0.02) continue;  // the right foreleg from the knee down, and nothing else
    EXPECT_GT(rest[k], 0.5);
    EXPECT_LT(rest[k + 1], -0.5);
    EXPECT_GT(rest[k + 2], 0);
    if (rest[k + 1] < -1.2) {
      EXPECT_GT(way, 0.1);
    }
  }
  EXPECT_GT(inwards, 0.4);
}

struct Directory : TemporaryDirectory {
  Outcome run(std::vector<std::string> arguments, RunOptions options = {}) const {
    arguments.insert(arguments.begin(), "reproduce");
    options.directory = path();
    return run_program(std::move(arguments), options);
  }
  /// Files that the page names must be there, as pictures.
  std::string page(const std::string& directory) const {
    const std::string text = read_file(path() + "/" + directory + "/index.md");
    const std::regex picture(R"(!\[[^\]]*\]\(([^)]*)\))");
    for (auto it = std::sregex_iterator(text.begin(), text.end(), picture); it != std::sregex_iterator();
         ++it) {
      EXPECT_THAT(read_file(path() + "/" + directory + "/" + (*it)[1].str()), StartsWith("\x89PNG"))
          << (*it)[1];
    }
    return text;
  }
};

/// The cells of the rows that begin with a mode's name.
std::vector<std::vector<std::string>> rows(const std::string& page, const std::string& mode) {
  std::vector<std::vector<std::string>> found;
  std::istringstream lines(page);
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind("| " + mode, 0) != 0) continue;
    std::vector<std::string> cells;
    std::istringstream row(line.substr(2));
    for (std::string cell; std::getline(row, cell, '|');) {
      const auto begin = cell.find_first_not_of(' '), end = cell.find_last_not_of(' ');
      if (begin != std::string::npos) cells.push_back(cell.substr(begin, end - begin + 1));
    }
    found.push_back(std::move(cells));
  }
  return found;
}

TEST(ReproduceProgram, MakesPicturesAndTablesOfGeneratedMeshes) {
  const Directory directory;
  const Outcome outcome = directory.run({"-o", "out", "--quick"});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
  EXPECT_THAT(outcome.out, StartsWith("out/index.md tells what came out ("));
  const std::string page = directory.page("out");
  for (const char* part :
       {"(Fig. 2 and 3)", "(Fig. 4)", "(Fig. 5)", "(Fig. 6)", "(Fig. 7 and 8)", "(Fig. 9)",
        "## Speed, culling and misses", "Generated by the program", "--quick", "creature-key-points.png",
        "cylinder-poses.png", "cylinder-prediction.png", "creature-bent.png", "creature-collision.png",
        "creature-rebuilt.png", "cylinder-missing-direction.png"}) {
    EXPECT_THAT(page, HasSubstr(part));
  }
  EXPECT_TRUE(load_model(directory / "out/creature.model"));
  // Plain, and plain in the subspace, for either mesh; collisions there are, and nobody who proves misses
  // one.
  const auto plain = rows(page, "plain hierarchies");
  ASSERT_EQ(plain.size(), 4u);
  for (const auto& row : plain) {
    ASSERT_EQ(row.size(), 8u);
    EXPECT_NE(row[5], "0");
  }
  for (const char* mode : {"plain", "certificates, no model", "certificates, model", "reduced"}) {
    EXPECT_GE(rows(page, mode).size(), 2u) << mode;
    for (const auto& row : rows(page, mode)) {
      ASSERT_EQ(row.size(), 8u);
      EXPECT_EQ(row[6], "0") << mode;
      EXPECT_EQ(row[7], "0") << mode;
    }
  }
  for (const auto& row : rows(page, "certificates, model")) EXPECT_GT(std::stod(row[3]), 50);
  for (const auto& row : rows(page, "paper")) EXPECT_THAT(row[0], EndsWith("(statistical)"));
  EXPECT_EQ(rows(page, "paper").size(), 6u);

  const Outcome again = directory.run({"-o", "out", "--quick"});
  EXPECT_EQ(again.code, 2);
  EXPECT_THAT(again.err, HasSubstr("out: is not empty; name another directory, or add --force"));
}

TEST(ReproduceProgram, TakesDataThatIsThere) {
  const Directory directory;
  std::filesystem::create_directories(directory.path() + "/data");
  write_frames(directory.path() + "/data/lion-poses", *bending_tube({16, 24}, {0, 1, 2, 3, 4, 6.6, 5}));
  std::filesystem::create_directories(directory.path() + "/out");
  write_file(directory / "out/old.txt", "stays");
  const Outcome outcome =
      directory.run({"-o", "out", "--quick", "--data", "data", "--force", "--quiet", "--threads", "1"});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(outcome.out, "");
  const std::string page = directory.page("out");
  EXPECT_THAT(page, HasSubstr("### The lion"));
  EXPECT_THAT(page, HasSubstr("lion-collision.png"));
  EXPECT_THAT(page, HasSubstr("on 1 thread;"));
  EXPECT_THAT(page, Not(HasSubstr("### The hand")));
  EXPECT_EQ(read_file(directory / "out/old.txt"), "stays");
}

TEST(ReproduceProgram, StopsWhenInterrupted) {
  const Directory directory;
  RunOptions options;
  options.while_it_runs = [](pid_t program) {
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    ::kill(program, SIGINT);
  };
  const Outcome outcome = directory.run({"-o", "out"}, options);
  EXPECT_EQ(outcome.code, 130) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("interrupted"));
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  EXPECT_FALSE(std::filesystem::exists(directory / "out/index.md"));
  for (const auto& entry : std::filesystem::directory_iterator(directory / "out"))
    EXPECT_THAT(entry.path().string(), Not(EndsWith(".part")));
}

TEST(ReproduceProgram, ExplainsMistakesInOneLine) {
  const Directory directory;
  std::filesystem::create_directories(directory / "empty");
  std::filesystem::create_directories(directory / "bad/lion-poses");
  write_file(directory / "bad/lion-poses/a.obj", "f 1 2 3\n");
  write_file(directory / "file", "");
  const std::vector<std::pair<std::vector<std::string>, const char*>> mistakes{
      {{}, "--output is required"},
      {{"-o", "file"}, "is no directory"},
      {{"-o", "file/out"}, "file/out"},
      {{"-o", "a", "--data", "none"}, "none: is no directory"},
      {{"-o", "a", "--data", "empty"}, "holds nothing that is known"},
      {{"-o", "b", "--data", "bad"}, "a.obj"},
      {{"-o", "c", "--threads", "-3"}, "--threads"},
  };
  for (const auto& [arguments, problem] : mistakes) {
    expect_one_line_error(directory.run(arguments), problem);
  }
  EXPECT_FALSE(std::filesystem::exists(directory / "a"));
  EXPECT_THAT(directory.run({"--help"}).out, HasSubstr("foldproof reproduce -o out --quick"));
}

}  // namespace
}  // namespace foldproof
