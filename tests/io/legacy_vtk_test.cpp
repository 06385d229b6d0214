#include <fmt/format.h>

#include "io/readers.h"
#include "io/support.h"

namespace foldproof::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::string head(const std::string& version, const std::string& encoding, const std::string& type) {
  return "# vtk DataFile Version " + version + "\na title\n" + encoding + "\nDATASET " + type + "\n";
}

template <class T>
std::string big(std::initializer_list<T> values) {
  std::string bytes;
  for (const T x : values) bytes += bytes_of(x, std::endian::big);
  return bytes;
}

const std::string kPoints = "POINTS 6 float\n0 0 0 1 0 0 0 1 0\n0 0 1 2 2 2 3 2 2\n";
const std::vector<double> kPositions{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 2, 2, 2, 3, 2, 2};
const std::string kMetadata = "METADATA\nINFORMATION 1\nNAME POINTS LOCATION vtkDataArray\nDATA 2 0 3.7\n\n";

class LegacyVtkTest : public IoTest {
 protected:
  io::MeshData read(std::string_view bytes) {
    auto mesh = io::read_mesh(files.write("a.vtk", bytes));
    EXPECT_TRUE(mesh) << (mesh ? "" : mesh.error().line());
    return mesh ? std::move(*mesh) : io::MeshData();
  }
  std::string error(std::string_view bytes) { return open_error({files.write("a.vtk", bytes)}); }
};

TEST_F(LegacyVtkTest, ReadsPolygonsOfEveryVersion) {
  const std::string points = big<float>({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 2, 2, 2, 3, 2, 2});
  const std::string old = head("3.0", "ASCII", "POLYDATA") + kPoints + kMetadata +
                          "VERTICES 1 2\n1 0\nLINES 1 3\n2 4 5\nPOLYGONS 2 9\n4 0 1 2 3\n3 0 1 3\n"
                          "TRIANGLE_STRIPS 1 5\n4 0 1 2 3\nPOINT_DATA 6\nNORMALS n float\n";
  const std::string old_binary = head("4.2", "BINARY", "POLYDATA") + "FIELD FieldData 2\nTIME 1 1 double\n" +
                                 big<double>({0.5}) + "\n" + "n 2 1 int\n" + big<std::int32_t>({1, 2}) +
                                 "\nPOINTS 6 float\n" + points + "\n" + kMetadata + "LINES 1 3\n" +
                                 big<std::int32_t>({2, 4, 5}) + "\nPOLYGONS 2 9\n" +
                                 big<std::int32_t>({4, 0, 1, 2, 3, 3, 0, 1, 3}) + "\nTRIANGLE_STRIPS 1 5\n" +
                                 big<std::int32_t>({4, 0, 1, 2, 3}) + "\n";
  const std::string offsets = head("5.1", "ascii", "polydata") +
                              "field FieldData 1\nnote 1 1 string\na%20b\n" + kPoints +
                              "VERTICES 0 0\nLINES 2 2\nOFFSETS vtktypeint64\n0 2\n" +
                              "CONNECTIVITY vtktypeint64\n4 5\nPOLYGONS 3 7\nOFFSETS vtktypeint64\n0 4 7\n" +
                              "CONNECTIVITY vtktypeint64\n0 1 2 3 0 1 3\nTRIANGLE_STRIPS 2 4\n" +
                              "OFFSETS vtktypeint64\n0 4\nCONNECTIVITY vtktypeint64\n0 1 2 3";
  const auto array = [](const std::string& type, const std::string& bytes) {
    return " " + type + "\n" + bytes + "\n";
  };
  const auto wide = [&](std::initializer_list<std::int64_t> ends, std::initializer_list<std::int64_t> ids) {
    return "OFFSETS" + array("vtktypeint64", big(ends)) + "CONNECTIVITY" + array("vtktypeint64", big(ids));
  };
  const std::string offsets_binary = head("5.1", "BINARY", "POLYDATA") + "POINTS 6 float\n" + points +
                                     "\nLINES 2 2\n" + wide({0, 2}, {4, 5}) + "POLYGONS 3 7\n" +
                                     wide({0, 4, 7}, {0, 1, 2, 3, 0, 1, 3}) + "TRIANGLE_STRIPS 2 4\n" +
                                     wide({0, 4}, {0, 1, 2, 3});
  for (const std::string& bytes : {old, old_binary, offsets, offsets_binary}) {
    SCOPED_TRACE(bytes);
    const auto mesh = read(bytes);
    EXPECT_EQ(mesh.positions, kPositions);
    EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}, {0, 1, 3}, {0, 1, 2}, {1, 3, 2}}));
    EXPECT_THAT(mesh.lines, ElementsAre(Edge{4, 5}));
    EXPECT_EQ(mesh.points, bytes == old ? std::vector<Index>{0} : std::vector<Index>());
  }
}

TEST_F(LegacyVtkTest, ReadsTheSurfaceOfCells) {
  const std::string points = "POINTS 6 double\n0 0 0 1 0 0 0 1 0 0 0 1 2 2 2 3 2 2\n";
  const std::string old = head("2.0", "ASCII", "UNSTRUCTURED_GRID") + points +
                          "CELLS 4 12\n4 0 1 2 3\n3 1 2 4\n1 5\n0\nCELL_TYPES 4\n10 5 1 0\n";
  const std::string offsets = head("5.1", "ASCII", "UNSTRUCTURED_GRID") + points +
                              "CELLS 5 8\nOFFSETS vtktypeint64\n0 4 7 8 8\nCONNECTIVITY vtktypeint64\n"
                              "0 1 2 3 1 2 4 5\nCELL_TYPES 4\n10\n5\n1\n0\n";
  for (const std::string& bytes : {old, offsets}) {
    const auto mesh = read(bytes);
    EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{1, 2, 4}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}, {0, 2, 1}}));
    EXPECT_THAT(mesh.points, ElementsAre(5));
  }
}

TEST_F(LegacyVtkTest, LabelsOfCellsAreParts) {
  const std::string mesh = head("4.2", "ASCII", "POLYDATA") + kPoints +
                           "POLYGONS 2 8\n3 0 1 2\n3 0 1 3\nLINES 1 3\n2 4 5\nCELL_DATA 3\n";
  for (const char* labels : {"SCALARS group int\nLOOKUP_TABLE default\n9 7 5\n",
                             "SCALARS part_id short 1\nLOOKUP_TABLE t\n9 7 5\n",
                             "SCALARS heat float 2\nLOOKUP_TABLE default\n1 2 3 4 5 6\nFIELD FieldData 2\n"
                             "x 2 3 double\n1 nan 3 4 5 6\nlabels 1 3 vtkIdType\n9 7 5\n"}) {
    const auto parts = read(mesh + labels).parts;  // lines come before polygons
    ASSERT_EQ(parts.names.size(), 2u) << labels;
    EXPECT_THAT(parts.names[0], ::testing::EndsWith(" 7"));
    EXPECT_THAT(parts.of_triangle, ElementsAre(0, 1));
  }
  EXPECT_THAT(read(mesh + "VECTORS group float\n1 2 3 4 5 6 7 8 9\n").parts.names, IsEmpty());
}

// The fuzzer's seeds were written by VTK 9.1.
TEST_F(LegacyVtkTest, ReadsWhatVtkWrites) {
  for (const char* name : {"poly_42_ascii", "poly_42_binary", "poly_51_ascii", "poly_51_binary"}) {
    const auto mesh = io::read_mesh(fmt::format(FOLDPROOF_SOURCE_DIR "/tests/fuzz/corpus/vtk/{}.vtk", name));
    ASSERT_TRUE(mesh) << mesh.error().line();
    EXPECT_EQ(mesh->triangles,
              (std::vector<Triangle>{{0, 1, 3}, {0, 3, 2}, {0, 1, 2}, {0, 1, 2}, {1, 3, 2}}));
    EXPECT_THAT(mesh->lines, ElementsAre(Edge{3, 4}, Edge{4, 5}));
    EXPECT_THAT(mesh->points, ElementsAre(6));
    EXPECT_THAT(mesh->parts.names, ElementsAre("group 3", "group 4", "group 5"));
  }
  for (const char* name : {"grid_42_ascii", "grid_42_binary", "grid_51_ascii", "grid_51_binary"}) {
    const auto mesh = io::read_mesh(fmt::format(FOLDPROOF_SOURCE_DIR "/tests/fuzz/corpus/vtk/{}.vtk", name));
    ASSERT_TRUE(mesh) << mesh.error().line();
    EXPECT_EQ(mesh->triangles.size(), 5u);
    EXPECT_THAT(mesh->lines, ElementsAre(Edge{4, 5}));
    EXPECT_THAT(mesh->points, ElementsAre(6));
  }
}

TEST_F(LegacyVtkTest, BadFilesAreOneLineErrors) {
  const std::string again = "; write the file again";
  const std::string start = head("3.0", "ASCII", "POLYDATA");
  EXPECT_EQ(error("vtk"), "a.vtk:1: does not start with '# vtk DataFile Version'" + again);
  EXPECT_EQ(error("# vtk DataFile Version 3.0\nt\nTEXT\n"), "a.vtk:3: is neither ASCII nor BINARY" + again);
  EXPECT_EQ(
      error(head("3.0", "ASCII", "STRUCTURED_GRID")),
      "a.vtk:4: holds structured_grid, which is not read; extract its surface in ParaView, and save that "
      "as .vtp");
  EXPECT_EQ(error(start + "POINTS 3 string\n"),
            "a.vtk:5: numbers of the type 'string' are not read here" + again);
  EXPECT_EQ(error(start + "POINTS 4000000000 float\n0 0 0\n"),
            "a.vtk:5: 12000000000 numbers are announced, but the file ends before" + again);
  EXPECT_EQ(error(start + "POINTS -1 float\n"), "a.vtk:5: a count is missing or wrong" + again);
  EXPECT_EQ(error(start + "POINTS 1 float\n0 x 0\n"),
            "a.vtk:6: value 1 is not a number; export the mesh again");
  EXPECT_THAT(error(start + "POINTS 1 float\n0 nan 0\n"), HasSubstr("a.vtk:6: value 1 is not finite"));
  EXPECT_EQ(error(start + kPoints + kPoints), "a.vtk:8: has points twice" + again);
  EXPECT_EQ(error(start + kPoints + "POLYGONS 1 4\n4 0 1 2\n"),
            "a.vtk:9: a cell is longer than its section" + again);
  EXPECT_EQ(error(start + kPoints + "POLYGONS 2 4\n3 0 1 2\n"),
            "a.vtk:9: 2 cells are announced, but there are 1" + again);
  EXPECT_EQ(error(start + kPoints + "POLYGONS 1 4\n3 0 1 6\n"),
            "a.vtk, polygons: cell 0 refers to vertex 6, but there are 6 (counting from 0)" + again);
  EXPECT_EQ(error(start + kPoints + "EDGES 1 4\n"), "a.vtk:8: 'edges' is not understood" + again);
  const std::string grid = head("3.0", "ASCII", "UNSTRUCTURED_GRID") + kPoints + "CELLS 1 5\n4 0 1 2 3\n";
  EXPECT_EQ(error(grid), "a.vtk, cells: has 0 types for 1 cells" + again);
  EXPECT_EQ(error(grid + "CELL_TYPES 1\n24\n"),
            "a.vtk, cells: cell 0 is of VTK's type 24, which is not read" + again);
  const std::string offsets = head("5.1", "ASCII", "POLYDATA") + kPoints + "POLYGONS 2 3\n";
  EXPECT_EQ(error(offsets + "3 0 1 2\n"), "a.vtk:9: OFFSETS are missing" + again);
  EXPECT_EQ(error(offsets + "OFFSETS int\n1 3\nCONNECTIVITY int\n0 1 2\n"),
            "a.vtk:12: the first offset is not 0" + again);
  EXPECT_EQ(error(offsets + "OFFSETS int\n0 4\nCONNECTIVITY int\n0 1 2\n"),
            "a.vtk, polygons: cell 0 has an offset that is not within its vertices" + again);
  const std::string binary = head("3.0", "BINARY", "POLYDATA") + "POINTS 1 double\n" + std::string(23, 'a');
  EXPECT_THAT(error(binary), HasSubstr("a.vtk, byte 75: 3 numbers are announced, but the file ends before"));
}

}  // namespace
}  // namespace foldproof::testing
