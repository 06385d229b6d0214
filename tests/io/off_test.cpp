#include "io/support.h"

namespace foldproof::testing {
namespace {

class OffTest : public IoTest {
 protected:
  std::string off_error(std::string_view text) { return open_error({files.write("a.off", text)}); }
};

TEST_F(OffTest, ReadsEveryWayToWriteTheSameMesh) {
  for (const char* text : {
           "OFF\n3 1 3\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
           "\xef\xbb\xbfOFF\n3 1 3\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
           "OFF 3 1 3\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2",
           "OFF\r\n3 1\r\n0 0 0\r\n1 0 0\r\n0 1 0\r\n3 0 1 2\r\n",
           "# text\nOFF # yes\n\n# counts\n3 1 0\n\n0 0 0 # one\n1 0 0\n0 1 0\n# faces\n3 0 1 2 255 0 0\n\n",
           "COFF\n3 1 0\n0 0 0 255 0 0 255\n1 0 0 255 0 0 255\n0 1 0 0 0 0 1\n3 0 1 2\n",
           "NOFF\n3 1 0\n0 0 0 0 0 1\n1 0 0 0 0 1\n0 1 0 0 0 1\n3 0 1 2\n",
           "STCNOFF\n3 1 0\n0 0 0 0 0 1 1 1 1 1 0 0\n1 0 0\n0 1 0\n3 0 1 2 0.5 0.5 0.5\n",
       }) {
    SCOPED_TRACE(text);
    const auto motion = open({files.write("a.off", text)});
    ASSERT_TRUE(motion);
    EXPECT_EQ(triangles(*motion), kOneTriangle);
    EXPECT_EQ(frame(*motion, 0), kTrianglePositions);
  }
}

TEST_F(OffTest, CutsPolygonsIntoFans) {
  const auto motion =
      open({files.write("a.off", "OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 3\n4 0 1 2 3\n")});
  ASSERT_TRUE(motion);
  EXPECT_EQ(triangles(*motion), (std::vector<Triangle>{{0, 1, 3}, {0, 1, 2}, {0, 2, 3}}));
}

TEST_F(OffTest, FacesMayTakeSeveralLines) {
  const auto motion = open({files.write(
      "a.off", "OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0\n1 # one\n\n2\n3 255 0 0\n3\n0 1\n3\n")});
  ASSERT_TRUE(motion);
  EXPECT_EQ(triangles(*motion), (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}, {0, 1, 3}}));
}

TEST_F(OffTest, ReportsLineAndRemedy) {
  const std::string head = "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n";
  const std::string again = "; export the mesh again";
  EXPECT_EQ(off_error("\n"),
            "a.off:2: does not start with OFF (or COFF, NOFF, STOFF); export the mesh as OFF again");
  EXPECT_EQ(off_error("4OFF\n"),
            "a.off:1: does not start with OFF (or COFF, NOFF, STOFF); export the mesh as OFF again");
  EXPECT_EQ(off_error("OFF BINARY\n"),
            "a.off:1: is a binary OFF file; export the mesh as ASCII OFF, or as binary PLY");
  EXPECT_EQ(off_error("OFF\n3\n"),
            "a.off:2: the numbers of vertices and faces are missing; export the mesh as OFF again");
  EXPECT_EQ(off_error("OFF\n3 -1 0\n"),
            "a.off:2: the numbers of vertices and faces are missing; export the mesh as OFF again");
  EXPECT_EQ(off_error("OFF\n3 1 0 7\n"),
            "a.off:2: the line of counts is not understood; export the mesh as OFF again");
  EXPECT_EQ(off_error("OFF\n900000000000000000 1 0\n0 0 0\n"),
            "a.off:2: header announces 900000000000000000 vertices and 1 faces, but the file ends before; "
            "copy or export the mesh again");
  EXPECT_EQ(off_error(head), "a.off:6: the size of face 0 is missing" + again);
  EXPECT_EQ(off_error(head + "\n\n\n\n\n\n\n\n"), "a.off:14: the size of face 0 is missing" + again);
  EXPECT_EQ(off_error("OFF\n3 1 0\n0 0 0\n1 0\n0 1 0\n3 0 1 2\n"),
            "a.off:4: coordinate z of vertex 1 is missing" + again);
  EXPECT_EQ(
      off_error("OFF\n3 1 0\n0 0 0\n1 0 inf\n0 1 0\n3 0 1 2\n"),
      "a.off:4: coordinate z of vertex 1 is not finite; export the mesh without NaN or infinite coordinates");
  EXPECT_EQ(off_error("OFF\n3 1 0\n0 0 0\n1 0 1.#INF\n0 1 0\n3 0 1 2\n"),
            "a.off:4: coordinate z of vertex 1 is not a number" + again);
  EXPECT_EQ(off_error(head + "3 0 1 2#\n"), "a.off:6: vertex 2 of face 0 is not a number" + again);
  EXPECT_EQ(off_error(head + "3 0 1 3\n"),
            "a.off:6: face 0 refers to vertex 3, but there are 3 (counting from 0)" + again);
  EXPECT_EQ(off_error(head + "3 0 1 -1\n"),
            "a.off:6: face 0 refers to vertex -1, but there are 3 (counting from 0)" + again);
  EXPECT_EQ(off_error(head + "3 0 1\n\n\n"), "a.off:9: vertex 2 of face 0 is missing" + again);
  EXPECT_EQ(off_error(head + "3 0\n1 3\n"),
            "a.off:7: face 0 refers to vertex 3, but there are 3 (counting from 0)" + again);
  EXPECT_EQ(off_error(head + "3 0 1 b\n"), "a.off:6: vertex 2 of face 0 is not a number" + again);
  EXPECT_EQ(off_error(head + "2 0 1  \n"),
            "a.off:6: face 0 has 2 vertices; remove faces with fewer than three vertices");
  EXPECT_EQ(off_error(head + "3 0 1 2\n3 0 1 2\n"),
            "a.off:7: there is more data than the header announces" + again);
  EXPECT_EQ(off_error("OFF\n0 0 0\n"), "a.off: has no vertices" + again);
  EXPECT_EQ(off_error("OFF\n3 0 0\n0 0 0\n1 0 0\n0 1 0\n"),
            "a.off: has no faces; export the mesh with its faces");
}

}  // namespace
}  // namespace foldproof::testing
