// foldproof check --explain, on the command line.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "apps/program.h"

namespace foldproof {
namespace {

using namespace foldproof::testing;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

struct Scene : TemporaryDirectory {
  Scene() { write_frames(path() + "/sink", *needle(kSinking)); }
};

TEST(CheckExplain, WritesTheThreeKindsOfFile) {
  const Scene scene;
  for (const char* name : {"a.npz", "a.csv", "A.PLY"}) {
    const Outcome found = check_in(scene, {"sink", "--explain", name});
    EXPECT_EQ(found.code, 1) << name;
    EXPECT_EQ(found.err, "");
    EXPECT_THAT(found.out, HasSubstr("\ncertified               0 % of leaf pairs; not: "));
  }
  EXPECT_THAT(scene.names(), ElementsAre("A.PLY", "a.csv", "a.npz", "sink"));
  EXPECT_THAT(read_file(scene / "a.csv"),
              StartsWith("frame,substep,kind,object,reason,level,count\n0,0,triangles,0,"));
  EXPECT_THAT(read_file(scene / "a.npz"), StartsWith("PK"));
  EXPECT_THAT(read_file(scene / "A.PLY"), StartsWith("ply\n"));
}

TEST(CheckExplain, SaysNothingUnlessAsked) {
  const Scene scene;
  EXPECT_THAT(check_in(scene, {"sink"}).out, Not(HasSubstr("certified")));
}

TEST(CheckExplain, WithoutCertificatesEverythingIsOff) {
  const Scene scene;
  EXPECT_THAT(check_in(scene, {"sink", "--no-certificates", "--explain", "a.csv"}).out,
              HasSubstr("0 % of leaf pairs; not: 100.0 % certificates off"));
  const std::string text = read_file(scene / "a.csv");
  for (int step = 0; step < 4; ++step)
    EXPECT_THAT(text, HasSubstr(fmt::format("\n{},0,triangles,0,off,-1,2\n", step)));
}

TEST(CheckExplain, MistakesGetOneLineAndLeaveNothing) {
  const Scene scene;
  const auto before = scene.names();
  const std::vector<std::pair<std::vector<std::string>, const char*>> mistakes{
      {{"sink", "--explain", "a.txt"},
       "--explain a.txt: ends in .txt, not in .npz, .csv or .ply; name another file"},
      {{"sink", "--explain", "npz"}, "'npz' ends in none"},
      {{"sink", "--explain", "no/where.npz"}, "no/where.npz"},
      {{"sink", "--csv", "a.csv", "--explain", "a.csv"}, "a.csv: is named for two outputs"},
      {{"sink", "--explain", "a.npz", "--csv", "/dev/full"}, "/dev/full"}};
  for (const auto& [arguments, said] : mistakes) {
    expect_one_line_error(check_in(scene, arguments), said);
    EXPECT_EQ(scene.names(), before);
  }
}

}  // namespace
}  // namespace foldproof
