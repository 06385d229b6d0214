// Lines and points beside faces, in every format that has them.
#include "io/readers.h"
#include "io/support.h"

namespace foldproof::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

class LooseTest : public IoTest {
 protected:
  io::MeshData read(const std::string& name, std::string_view bytes) {
    auto mesh = io::read_mesh(files.write(name, bytes));
    EXPECT_TRUE(mesh) << (mesh ? "" : mesh.error().line());
    return mesh ? std::move(*mesh) : io::MeshData();
  }
  io::MeshData obj(const std::string& statements) {
    return read("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nf 1 2 3\n" + statements);
  }
};

TEST_F(LooseTest, ObjHasPolylinesAndPoints) {
  const auto mesh = obj("l 4/7 5/8 -1\nl 1 2 6\np 4 3\n");
  EXPECT_THAT(mesh.lines, ElementsAre(Edge{3, 4}, Edge{4, 5}, Edge{0, 1}, Edge{1, 5}));
  EXPECT_THAT(mesh.points, ElementsAre(3, 2));
  EXPECT_EQ(mesh.triangles, kOneTriangle);
}

TEST_F(LooseTest, LinesWithoutLengthArePoints) {
  const auto mesh = obj("l 4 4\nl 5\nl 6 6 5\n");
  EXPECT_THAT(mesh.lines, ElementsAre(Edge{5, 4}));
  EXPECT_THAT(mesh.points, ElementsAre(3, 4, 5));
}

TEST_F(LooseTest, ObjNamesWhatRefersToNoVertex) {
  const auto error = [&](const std::string& statement) {
    return open_error({files.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n" + statement)});
  };
  EXPECT_EQ(error("l 1 4\n"), "a.obj:5: line refers to vertex 4, but there are 3; export the mesh again");
  EXPECT_EQ(error("p -4\n"), "a.obj:5: point refers to vertex -4, but there are 3; export the mesh again");
  EXPECT_EQ(error("l 1 x\n"), "a.obj:5: a vertex of the line is not a number; export the mesh again");
}

TEST_F(LooseTest, PlyHasEdges) {
  const auto header = [](const char* format, const char* edge) {
    return std::string("ply\nformat ") + format +
           " 1.0\nelement vertex 4\nproperty double x\nproperty double y\nproperty double z\n" +
           "element face 1\nproperty list uchar int vertex_index\nelement edge 2\n" + edge +
           "property uchar red\nend_header\n";
  };
  const std::string ends = "property int vertex1\nproperty int vertex2\n";
  const std::string body = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 1 2\n";
  EXPECT_THAT(read("a.ply", header("ascii", ends.c_str()) + body + "1 0 9\n3 1 9\n").lines,
              ElementsAre(Edge{1, 0}, Edge{3, 1}));
  std::string binary = header("binary_big_endian", ends.c_str());
  for (const double x : {0., 0., 0., 1., 0., 0., 0., 1., 0., 0., 0., 1.})
    binary += bytes_of(x, std::endian::big);
  const auto ints = [](std::initializer_list<std::int32_t> values) {
    std::string bytes;
    for (const std::int32_t value : values) bytes += bytes_of(value, std::endian::big);
    return bytes;
  };
  binary += '\3' + ints({0, 1, 2}) + ints({3, 2}) + '\0' + ints({2, 0}) + '\0';
  EXPECT_THAT(read("b.ply", binary).lines, ElementsAre(Edge{3, 2}, Edge{2, 0}));
  EXPECT_EQ(open_error({files.write("c.ply", header("ascii", ends.c_str()) + body + "1 0 9\n3 4 9\n")}),
            "c.ply:21: edge 1 refers to vertex 4, but there are 4 (counting from 0); export the mesh again");
  const auto other = read(
      "d.ply", header("ascii", "property float vertex1\nproperty int vertex2\n") + body + "1 0 9\n3 1 9\n");
  EXPECT_THAT(other.lines, IsEmpty());
  EXPECT_THAT(other.unchecked, ElementsAre("2 edges without vertex1 and vertex2 were not checked"));
}

TEST_F(LooseTest, EveryFrameLeavesOutTheSame) {
  const std::string mesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nsurf 0 1\nseam 1\n";
  files.write("run/1.obj", mesh);
  files.write("run/2.obj", mesh + "seam 2\n");
  files.write("run/3.obj", mesh + "surf 0 1\n");
  const auto motion = open({files.path("run")});
  ASSERT_TRUE(motion);
  EXPECT_THAT(motion->info().notes, ElementsAre("1 statement is not known and was skipped: 'seam'"));
  EXPECT_THAT(motion->info().unchecked, ElementsAre("1 statement 'surf' was not checked"));
  EXPECT_EQ(frame_error(*motion, 1), "no error");
  EXPECT_THAT(frame_error(*motion, 2),
              ::testing::HasSubstr(
                  "run/3.obj (frame 2): has other things than the first frame that are not checked; "));
  const std::string mdd = files.write(
      "a.mdd", bytes_of(1, std::endian::big) + bytes_of(3, std::endian::big) + std::string(4 + 36, '\0'));
  const auto cached = open({files.path("run/1.obj"), mdd});
  ASSERT_TRUE(cached);
  EXPECT_EQ(cached->info().notes, motion->info().notes);
  EXPECT_EQ(cached->info().unchecked, motion->info().unchecked);
}

TEST_F(LooseTest, VtpHasVertsAndLines) {
  const auto array = [](const std::string& type, const std::string& name, const std::string& values) {
    return "<DataArray type=\"" + type + "\" Name=\"" + name + "\" format=\"ascii\">" + values +
           "</DataArray>";
  };
  const auto section = [&](const std::string& name, const std::string& ids, const std::string& ends) {
    return "<" + name + ">" + array("Int32", "connectivity", ids) + array("Int32", "offsets", ends) + "</" +
           name + ">";
  };
  const std::string points =
      "<Points>" + array("Float32", "Points", "0 0 0 1 0 0 0 1 0 0 0 1 1 1 1 2 1 1 3 1 1") + "</Points>";
  const auto mesh =
      read("a.vtp",
           "<VTKFile type=\"PolyData\"><PolyData><Piece NumberOfPoints=\"7\" NumberOfVerts=\"2\" "
           "NumberOfLines=\"2\" NumberOfPolys=\"1\">" +
               points + section("Verts", "6 5 1", "2 3") + section("Lines", "3 4 5 0 1", "3 5") +
               section("Polys", "0 1 2", "3") + "</Piece></PolyData></VTKFile>");
  EXPECT_THAT(mesh.lines, ElementsAre(Edge{3, 4}, Edge{4, 5}, Edge{0, 1}));
  EXPECT_THAT(mesh.points, ElementsAre(6, 5, 1));
  const auto cells =
      read("a.vtu",
           "<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid><Piece NumberOfPoints=\"7\" "
           "NumberOfCells=\"6\">" +
               points + "<Cells>" + array("Int32", "connectivity", "0 1 2 3 3 4 4 5 0 6 0") +
               array("Int32", "offsets", "4 6 9 10 10 11") + array("UInt8", "types", "10 3 4 1 0 2") +
               "</Cells></Piece></UnstructuredGrid></VTKFile>");
  EXPECT_THAT(cells.lines, ElementsAre(Edge{3, 4}, Edge{4, 5}, Edge{5, 0}));
  EXPECT_THAT(cells.points, ElementsAre(6, 0));
  EXPECT_EQ(cells.triangles.size(), 4u);
}

TEST_F(LooseTest, MshHasPointsAndLines) {
  const auto mesh =
      read("a.msh",
           "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n6\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n"
           "5 2 0 0\n6 3 0 0\n$EndNodes\n$Elements\n5\n1 15 2 0 1 1\n2 15 2 0 2 6\n3 1 2 0 1 1 2\n"
           "4 1 2 0 2 4 5\n5 4 2 0 1 1 2 3 4\n$EndElements\n");
  EXPECT_THAT(mesh.lines, ElementsAre(Edge{0, 1}, Edge{3, 4}));
  EXPECT_THAT(mesh.points, ElementsAre(0, 5));
  EXPECT_EQ(mesh.triangles.size(), 4u);
  EXPECT_THAT(mesh.parts.names, IsEmpty());
}

}  // namespace
}  // namespace foldproof::testing
