#include "io/support.h"

namespace foldproof::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

class ObjTest : public IoTest {
 protected:
  std::unique_ptr<Motion> obj(std::string_view text) { return open({files.write("a.obj", text)}); }
  std::string obj_error(std::string_view text) { return open_error({files.write("a.obj", text)}); }
};

TEST_F(ObjTest, ReadsATriangle) {
  const auto motion = obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  ASSERT_TRUE(motion);
  EXPECT_EQ(motion->frame_count(), 1u);
  EXPECT_EQ(triangles(*motion), kOneTriangle);
  EXPECT_EQ(frame(*motion, 0), kTrianglePositions);
}

TEST_F(ObjTest, ReadsEveryWayToWriteTheSameMesh) {
  for (const char* text : {
           "v 0 0 0\r\nv 1 0 0\r\nv 0 1 0\r\nf 1 2 3\r\n",
           "v 0 0 0\rv 1 0 0\rv 0 1 0\rf 1 2 3",
           "# text\nmtllib a.mtl\no thing\ng part\n\n  v 0 0 0 # one\nv\t1 0 0\nv 0 1 0\ns off\nf 1 2 3 # a",
           "v 0 0 0 1\nv 1 0 0 0.5 0.5 0.5\nv 0 1 0 1\nvn 0 0 1\nvt 0 0\nusemtl a\nf 1/1/1 2//1 3/1\n",
           "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\n",
           "f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\n",
           "v 0 0 \\\n0\nv 1 0 0\nv 0 1 0\nf 1 \\\r\n2 3\n",
           "v +0.0 0e5 0\nv 1.0e+0 -0 .0\nv 0 10e-1 0.\nfo 1 2 3\nl 1 2\np 1\n",
           "v 1e-400 0 -0.00000001e-320\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
           "\xef\xbb\xbfv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
           "vn 0 0 \\\n1\nv 0 0 0 1 1 \\\n1\nv 1 0 0\nv 0 1 0\nf 1 2 3\nl 1 2 \\\n3\ncstype bezier\nend\n",
           "# a path\\\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
       }) {
    SCOPED_TRACE(text);
    const auto motion = obj(text);
    ASSERT_TRUE(motion);
    EXPECT_EQ(triangles(*motion), kOneTriangle);
    EXPECT_EQ(frame(*motion, 0), kTrianglePositions);
  }
}

TEST_F(ObjTest, CutsPolygonsIntoFans) {
  const auto motion = obj("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nf 1 2 3 4 5\nf 1 2 5\nf 2 3 4 5\n");
  ASSERT_TRUE(motion);
  EXPECT_EQ(triangles(*motion),
            (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 1, 4}, {1, 2, 3}, {1, 3, 4}}));
}

TEST_F(ObjTest, KeepsDegenerateAndDuplicateTrianglesAndUnusedVertices) {
  const auto motion = obj("v 0 0 0\nv 0 0 0\nv 1 0 0\nv 7 7 7\nf 1 1 1\nf 1 2 3\nf 1 2 3\nf 3 2 1\n");
  ASSERT_TRUE(motion);
  EXPECT_EQ(motion->topology().vertex_count(), 4u);
  EXPECT_EQ(triangles(*motion), (std::vector<Triangle>{{0, 0, 0}, {0, 1, 2}, {0, 1, 2}, {2, 1, 0}}));
}

TEST_F(ObjTest, ReadsNumbersCorrectlyRounded) {
  const auto motion =
      obj("v 0.1 1.7976931348623157e308 4.9e-324\nv 9007199254740993 0 0\nv 0 0 0\nf 1 2 3\n");
  ASSERT_TRUE(motion);
  const auto x = frame(*motion, 0);
  EXPECT_EQ(x[0], 0.1);
  EXPECT_EQ(x[1], std::numeric_limits<double>::max());
  EXPECT_EQ(x[2], std::numeric_limits<double>::denorm_min());
  EXPECT_EQ(x[3], 9007199254740992.0);
}

TEST_F(ObjTest, CountsStatementsThatItSkips) {
  const std::string mesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  const auto notes = [&](const std::string& statements) { return obj(mesh + statements)->info().notes; };
  EXPECT_THAT(notes("vn 0 0 1\ns off\n"), IsEmpty());
  EXPECT_THAT(notes("seam 58\nstitch 1 2 3 0.0\nseam 59 \\\nf 1 1 1\n"),
              ElementsAre("3 statements are not known and were skipped: 'seam', 'stitch'"));
  EXPECT_THAT(notes("F 1 2 3\n"), ElementsAre("1 statement is not known and was skipped: 'F'"));
  EXPECT_THAT(notes("a\nb\nc\nd\na\n"),
              ElementsAre("5 statements are not known and were skipped: 'a', 'b', 'c' and others"));
  EXPECT_EQ(triangles(*obj(mesh + "seam 58\nf 3 2 1\n")), (std::vector<Triangle>{{0, 1, 2}, {2, 1, 0}}));
}

// What might collide is named in the verdict.
TEST_F(ObjTest, NamesGeometryThatItDoesNotRead) {
  const auto motion =
      obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\ncstype bezier\nsurf 0 1 0 1 1 2 3 1\nend\n"
          "surf 0 1 0 1 1 2 3 1\ncall b.obj\ncurv2 1 2\n");
  EXPECT_THAT(motion->info().unchecked,
              ElementsAre("2 statements 'surf' were not checked", "1 statement 'call' was not checked"));
  EXPECT_THAT(motion->info().notes, IsEmpty());
}

TEST_F(ObjTest, ReportsLineAndRemedy) {
  const std::string three = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  const std::string again = "; export the mesh again";
  const std::string not_finite = "; export the mesh without NaN or infinite coordinates";
  EXPECT_EQ(obj_error("v 0 0\n"), "a.obj:1: coordinate z of vertex 1 is missing" + again);
  EXPECT_EQ(obj_error("\nv 0 0 0\nv 0 1,5 0\n"), "a.obj:3: coordinate y of vertex 2 is not a number" + again);
  EXPECT_EQ(obj_error("v 0 0 0\nv nan 0 0\n"),
            "a.obj:2: coordinate x of vertex 2 is not finite" + not_finite);
  EXPECT_EQ(obj_error("v 0 0 -inf\n"), "a.obj:1: coordinate z of vertex 1 is not finite" + not_finite);
  for (const char* number : {"-1.#IND", "1.#QNAN", "1.#INF", "1#"}) {
    EXPECT_EQ(obj_error(three + "v 0 0 " + number + "\nf 1 2 3\n"),
              "a.obj:4: coordinate z of vertex 4 is not a number" + again);
  }
  EXPECT_EQ(obj_error("v 1e309 0 0\n"), "a.obj:1: coordinate x of vertex 1 is not finite" + not_finite);
  EXPECT_EQ(obj_error("v 0 1000000e99999999999999999999 0\n"),
            "a.obj:1: coordinate y of vertex 1 is not finite" + not_finite);
  EXPECT_EQ(obj_error(three + "f 1 2 4\n"), "a.obj:4: face refers to vertex 4, but there are 3" + again);
  EXPECT_EQ(obj_error("f 1 2 4\n" + three), "a.obj:1: face refers to vertex 4, but there are 3" + again);
  EXPECT_EQ(obj_error(three + "f 1 2 0\n"), "a.obj:4: face refers to vertex 0, but there are 3" + again);
  EXPECT_EQ(obj_error(three + "f 1 2 -4\n"), "a.obj:4: face refers to vertex -4, but there are 3" + again);
  EXPECT_EQ(obj_error(three + "f 1 2 4294967297\n"),
            "a.obj:4: face refers to vertex 4294967297, but there are 3" + again);
  EXPECT_EQ(obj_error(three + "f 1 2 99999999999999999999\n"),
            "a.obj:4: a vertex of the face is not a number" + again);
  EXPECT_EQ(obj_error(three + "f 1 2 3.5\n"), "a.obj:4: a vertex of the face is not a number" + again);
  EXPECT_EQ(obj_error(three + "f 1 2 3#4\n"), "a.obj:4: a vertex of the face is not a number" + again);
  EXPECT_EQ(obj_error(three + "f 1 2 /3\n"), "a.obj:4: a vertex of the face is not a number" + again);
  EXPECT_EQ(obj_error(three + "f 1 2\n"),
            "a.obj:4: face has 2 vertices; remove faces with fewer than three vertices");
  EXPECT_EQ(obj_error(three), "a.obj: has no faces; export the mesh with its faces");
  EXPECT_EQ(obj_error("\n"), "a.obj: has no vertices" + again);
  EXPECT_EQ(obj_error("f 1 2 3"), "a.obj:1: face refers to vertex 3, but there are 0" + again);
  EXPECT_EQ(obj_error(three + "f 1 \\\n2 \\\nx\n"), "a.obj:6: a vertex of the face is not a number" + again);
}

}  // namespace
}  // namespace foldproof::testing
