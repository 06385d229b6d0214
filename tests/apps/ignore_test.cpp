// check --ignore and --still-pairs.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "apps/program.h"

namespace foldproof {
namespace {

using namespace foldproof::testing;
using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;

std::string box(double x) {
  std::string text;
  for (int i = 0; i < 8; ++i)
    text += "v " + std::to_string(x + (i & 1)) + (i & 2 ? " 1" : " 0") + (i & 4 ? " 1\n" : " 0\n");
  return text + "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
}

/// Two boxes that overlap, a cloth of two frames above them, and a mesh with two groups that cross.
struct Bodies : Workplace {
  Bodies() {
    write_file(*this / "s1.obj", box(0));
    write_file(*this / "other.obj", box(0.5));
    write_frames(path() + "/cloth", *lone_triangle({3, 2.9}));
    write_file(*this / "groups.obj",
               "v -9 -9 0\nv 20 -9 0\nv -9 20 0\nv 0 0 -1\nv 1 0 1\nv 0 1 1\n"
               "g coat\nf 1 2 3\ng body\nf 4 5 6\n");
  }
};

TEST(CheckIgnore, LeavesOutPairsAndSaysSo) {
  const Bodies bodies;
  EXPECT_EQ(check_in(bodies, {"groups.obj"}).code, 1);
  const Outcome ignored = check_in(bodies, {"groups.obj", "--ignore", "coat", "body", "--json", "a.json"});
  EXPECT_EQ(ignored.code, 0);
  EXPECT_THAT(ignored.out, HasSubstr("; pairs of coat and body were ignored.\n"));
  EXPECT_EQ(bodies.report("a.json")["settings"]["ignore"], json::array({json::array({"coat", "body"})}));
  const Outcome within =
      check_in(bodies, {"groups.obj", "--ignore", "coat", "coat", "--ignore", "body", "body"});
  EXPECT_EQ(within.code, 1);
  EXPECT_THAT(within.out, HasSubstr("; pairs of coat with itself, of body with itself were ignored."));
}

TEST(CheckIgnore, UnknownNamesAreOneLineErrors) {
  const Bodies bodies;
  expect_one_line_error(check_in(bodies, {"groups.obj", "--ignore", "coat", "bodi"}), "did you mean 'body'?");
  EXPECT_EQ(check_in(bodies, {"groups.obj", "--ignore", "coat"}).code, 2);
}

TEST(CheckStillPairs, AreALineOfTheirOwn) {
  const Bodies bodies;
  const Outcome still = check_in(bodies, {"s1.obj", "other.obj", "cloth", "--json", "a.json"});
  EXPECT_EQ(still.code, 0) << still.out << still.err;
  EXPECT_THAT(still.out, HasSubstr("s1.obj and other.obj stand still and cross each other at "));
  EXPECT_THAT(still.out, HasSubstr("pairs of triangles (--still-pairs counts them)."));
  const json report = bodies.report("a.json");
  EXPECT_EQ(report["clean"], true);
  EXPECT_EQ(report["totals"]["still"]["objects"], json({0, 1}));
  EXPECT_GT(report["totals"]["still"]["crossings"], 0);
  EXPECT_EQ(report["totals"]["still"]["pairs"][0]["objects"], json({0, 1}));

  const Outcome counted = check_in(bodies, {"s1.obj", "other.obj", "cloth", "--still-pairs"});
  EXPECT_EQ(counted.code, 1);
  EXPECT_THAT(counted.out, Not(HasSubstr("stand still and")));
  EXPECT_EQ(check_in(bodies, {"s1.obj", "other.obj"}).code, 1);  // nothing moves
}

}  // namespace
}  // namespace foldproof
