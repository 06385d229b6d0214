#include "io/support.h"

namespace foldproof::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

using Corner = std::array<float, 3>;
constexpr Corner kA{0, 0, 0}, kB{1, 0, 0}, kC{0, 1, 0}, kD{0.1f, 1, 1};
const std::vector<std::array<Corner, 3>> kTwo{{kA, kB, kC}, {kC, kB, kD}};

std::string binary(const std::vector<std::array<Corner, 3>>& facets, const std::string& header = "made") {
  std::string bytes = header;
  bytes.resize(80);
  bytes += bytes_of(static_cast<std::uint32_t>(facets.size()));
  for (const auto& facet : facets) {
    bytes += std::string(12, '\x7f');  // a normal that is not a number
    for (const Corner& corner : facet) {
      for (const float x : corner) bytes += bytes_of(x);
    }
    bytes += "ab";
  }
  return bytes;
}

std::string ascii(const std::vector<std::array<Corner, 3>>& facets, const std::string& name = "") {
  std::string text = "solid " + name + "\n";
  for (const auto& facet : facets) {
    text += " facet normal 0 0 nan\n  outer loop\n";
    for (const Corner& x : facet)
      text += "   vertex " + std::to_string(x[0]) + " " + std::to_string(x[1]) + " " + std::to_string(x[2]) +
              "\n";
    text += "  endloop\n endfacet\n";
  }
  return text + "endsolid " + name + "\n";
}

class StlTest : public IoTest {};

TEST_F(StlTest, CornersAtTheSamePlaceAreOneVertexInTheOrderInWhichTheyCome) {
  for (const std::string& bytes : {binary(kTwo), binary(kTwo, "solid"), ascii(kTwo)}) {
    const auto motion = open({files.write("a.stl", bytes)});
    ASSERT_TRUE(motion);
    EXPECT_EQ(triangles(*motion), (std::vector<Triangle>{{0, 1, 2}, {2, 1, 3}}));
    EXPECT_THAT(frame(*motion, 0),
                ElementsAre(0, 0, 0, 1, 0, 0, 0, 1, 0, ::testing::DoubleNear(0.1, 1e-8), 1, 1));
  }
  const auto zeros = open({files.write("b.stl", binary({{kA, kB, {-0.f, 0, -0.f}}}))});
  EXPECT_EQ(triangles(*zeros), (std::vector<Triangle>{{0, 1, 0}}));
}

TEST_F(StlTest, LinesMayEndAnywhereBetweenWords) {
  std::string joined = ascii(kTwo), split = joined;
  const std::size_t first = joined.find('\n') + 1;
  std::replace(joined.begin() + static_cast<std::ptrdiff_t>(first), joined.end(), '\n', ' ');
  for (std::size_t at = first; (at = split.find("facet normal 0 ", at)) != split.npos; ++at)
    split[at + 5] = '\n';
  for (const std::string& bytes : {joined, split}) {
    const auto motion = open({files.write("a.stl", bytes)});
    ASSERT_TRUE(motion);
    EXPECT_EQ(triangles(*motion), (std::vector<Triangle>{{0, 1, 2}, {2, 1, 3}}));
  }
  joined[first - 1] = ' ';
  EXPECT_EQ(open_error({files.write("a.stl", joined + "\n" + ascii(kTwo))}),
            "a.stl:1: a facet is on the line of its solid; export the mesh as STL again");
}

TEST_F(StlTest, BinaryIsExactAndAsciiIsRoundedToDoubles) {
  EXPECT_EQ(frame(*open({files.write("a.stl", binary(kTwo))}), 0)[9], static_cast<double>(0.1f));
  EXPECT_EQ(frame(*open({files.write("a.stl", ascii(kTwo))}), 0)[9], 0.1);
}

TEST_F(StlTest, SolidsAreParts) {
  const auto motion = open({files.write("a.stl", ascii({kTwo[0]}, "left hand") + ascii({kTwo[1]}))});
  EXPECT_THAT(motion->info().parts.names, ElementsAre("left hand", "default"));
  EXPECT_THAT(motion->info().parts.of_triangle, ElementsAre(0, 1));
}

TEST_F(StlTest, SequencesNeedTheSameWelding) {
  files.write("run/1.stl", binary(kTwo));
  files.write("run/2.STL", binary({{kA, kB, kD}, {kD, kB, kC}}));
  files.write("run/3.stl", binary({{kA, kB, kC}, {kC, kB, kA}}));
  const auto motion = open({files.path("run")});
  ASSERT_TRUE(motion);
  EXPECT_EQ(motion->frame_count(), 3u);
  EXPECT_EQ(frame(*motion, 1)[6], static_cast<double>(0.1f));
  EXPECT_EQ(frame_error(*motion, 2),
            "run/3.stl (frame 2): has 3 vertices, but the first frame has 4; export OBJ or PLY: STL does not "
            "number vertices, so those at one place are one");
}

TEST_F(StlTest, BadFilesAreOneLineErrors) {
  const auto error = [&](const std::string& bytes) { return open_error({files.write("a.stl", bytes)}); };
  const std::string good = binary(kTwo);
  EXPECT_EQ(
      error("solit"),
      "a.stl: is too short for a binary STL, and does not begin with 'solid'; export the mesh as STL again");
  EXPECT_EQ(error(good.substr(0, 100)),
            "a.stl, byte 80: header announces 2 facets of 50 bytes, but 16 bytes follow it; copy or export "
            "the mesh again");
  EXPECT_THAT(error(good + "x"), HasSubstr("but 101 bytes follow it"));
  EXPECT_THAT(error(std::string(80, ' ') + "\xff\xff\xff\xff"), HasSubstr("announces 4294967295 facets"));
  EXPECT_EQ(error(binary({})), "a.stl: has no vertices; export the mesh again");
  EXPECT_EQ(
      error(binary({{kA, kB, {0, std::numeric_limits<float>::infinity(), 0}}})),
      "a.stl, facet 0: a coordinate is not finite; export the mesh without NaN or infinite coordinates");
  const std::string again = "; export the mesh as STL again";
  EXPECT_EQ(error("solid\nfacet\nvertex 0 0 0\nvertex 1 0 0\nendfacet\n"),
            "a.stl:5: facet has 2 vertices" + again);
  EXPECT_EQ(error("solid\nfacet\nvertex 0 0 0\n"), "a.stl:4: the file ends within a facet" + again);
  EXPECT_EQ(error("solid\nvertexes\n"), "a.stl:2: is not understood" + again);
  EXPECT_EQ(error("solid\nvertex 0 1\n"), "a.stl:2: coordinate z is missing; export the mesh again");
  EXPECT_EQ(error("solid\nvertex 0 inf 1\n"),
            "a.stl:2: coordinate y is not finite; export the mesh without NaN or infinite coordinates");
}

}  // namespace
}  // namespace foldproof::testing
