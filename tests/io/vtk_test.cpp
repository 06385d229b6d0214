#include <fmt/format.h>
#include <zlib.h>

#include "io/cells.h"
#include "io/gltf_builder.h"

namespace foldproof::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

template <class T>
std::string raw(const std::vector<T>& values, std::endian order = std::endian::little) {
  std::string bytes;
  for (const T x : values) bytes += bytes_of(x, order);
  return bytes;
}

template <class T>
std::string text(const std::vector<T>& values) {
  std::string all;
  for (const T x : values) all += fmt::format("{} ", x);
  return all;
}

std::string file(const std::string& type, const std::string& body, const std::string& attributes = "",
                 const std::string& appended = "") {
  return "<?xml version=\"1.0\"?>\n<VTKFile type=\"" + type + "\" version=\"1.0\" " + attributes + ">\n<" +
         type + ">\n" + body + "</" + type + ">\n" + appended + "</VTKFile>\n";
}

std::string array(const std::string& name, const std::string& type, const std::string& rest,
                  const std::string& content = "") {
  return "<DataArray type=\"" + type + "\" Name=\"" + name + "\" " + rest + ">" + content + "</DataArray>\n";
}

std::string ascii(const std::string& name, const std::string& type, const std::string& content) {
  return array(name, type, "format=\"ascii\"", content);
}

const std::vector<double> kSquare{0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0.5};

std::string polygons(const std::string& cell_data = "") {
  return "<Piece NumberOfPoints=\"4\" NumberOfVerts=\"1\" NumberOfPolys=\"2\" NumberOfStrips=\"1\">\n" +
         cell_data + "<Points>" +
         array("Points", "Float64", "NumberOfComponents=\"3\" format=\"ascii\"", text(kSquare)) +
         "</Points>\n<Verts>" + ascii("connectivity", "Int64", "3") + ascii("offsets", "Int64", "1") +
         "</Verts><Polys>" + ascii("connectivity", "Int64", "0 1 2 3 0 1 3") +
         ascii("offsets", "Int64", "4 7") + "</Polys><Strips>" + ascii("connectivity", "Int32", "0 1 2 3") +
         ascii("offsets", "Int32", "4") + "</Strips></Piece>\n";
}

class VtkTest : public IoTest {
 protected:
  std::unique_ptr<Motion> vtp(const std::string& body) {
    return open({files.write("a.vtp", file("PolyData", body))});
  }
  std::string error(const std::string& body, const std::string& attributes = "") {
    return open_error({files.write("a.vtp", file("PolyData", body, attributes))});
  }
  /// Cells in a mesh of unit cubes' corners.
  std::unique_ptr<Motion> cells(const std::string& connectivity, const std::string& offsets,
                                const std::string& types) {
    std::string points;
    for (int i = 0; i < 12; ++i) points += fmt::format("{} {} {} ", i & 1, i >> 1 & 1, i >> 2);
    const auto count = std::count(types.begin(), types.end(), ' ') + 1;
    return open({files.write(
        "a.vtu", file("UnstructuredGrid",
                      fmt::format("<Piece NumberOfPoints=\"12\" NumberOfCells=\"{}\"><Points>", count) +
                          ascii("Points", "Float32", points) + "</Points><Cells>" +
                          ascii("connectivity", "Int64", connectivity) + ascii("offsets", "Int64", offsets) +
                          ascii("types", "UInt8", types) + "</Cells></Piece>\n"))});
  }
};

TEST_F(VtkTest, ReadsPolygonsStripsAndPieces) {
  const auto one = vtp(polygons());
  ASSERT_TRUE(one);
  const std::vector<Triangle> expected{{0, 1, 2}, {0, 2, 3}, {0, 1, 3}, {0, 1, 2}, {1, 3, 2}};
  EXPECT_EQ(triangles(*one), expected);
  EXPECT_EQ(frame(*one, 0), kSquare);
  const auto two = vtp(polygons() + polygons());
  ASSERT_TRUE(two);
  EXPECT_EQ(two->topology().vertex_count(), 8u);
  EXPECT_EQ(triangles(*two)[5], (Triangle{4, 5, 6}));
}

TEST_F(VtkTest, LabelsOfCellsAreParts) {
  const auto motion = vtp(polygons("<CellData>" + ascii("mark", "Int32", "1 2 3 4") +
                                   ascii("group", "Int32", "9 7 5 7") + "</CellData>"));
  ASSERT_TRUE(motion);
  EXPECT_THAT(motion->info().parts.names, ElementsAre("group 7", "group 5"));
  EXPECT_THAT(motion->info().parts.of_triangle, ElementsAre(0, 0, 1, 0, 0));
}

constexpr std::endian kOrder = std::endian::big;
using Three = std::array<std::string, 3>;  // of points, connectivity and offsets

std::string word(std::size_t value) { return bytes_of(static_cast<std::uint32_t>(value), kOrder); }

// Header and blocks of 40 bytes, the last of which is shorter.
std::array<std::string, 2> packed(const std::string& bytes) {
  std::string sizes, blocks;
  std::uint32_t count = 0;
  for (std::size_t at = 0; at < bytes.size(); at += 40, ++count) {
    const std::string block = bytes.substr(at, 40);
    std::vector<Bytef> out(100);
    uLongf length = out.size();
    EXPECT_EQ(compress(out.data(), &length, reinterpret_cast<const Bytef*>(block.data()), block.size()),
              Z_OK);
    sizes += word(length);
    blocks.append(reinterpret_cast<const char*>(out.data()), length);
  }
  return {word(count) + word(40) + word(bytes.size() % 40) + sizes, blocks};
}

std::string square(const Three& rest, const Three& content) {
  return "<Piece NumberOfPoints=\"4\" NumberOfPolys=\"1\"><Points>" +
         array("Points", "Float64", rest[0], content[0]) + "</Points><Polys>" +
         array("connectivity", "Int32", rest[1], content[1]) +
         array("offsets", "Int32", rest[2], content[2]) + "</Polys></Piece>";
}

std::string inline_file(const std::string& attributes, const Three& content) {
  const std::string binary = "format=\"binary\"";
  return file("PolyData", square({binary, binary, binary}, content),
              "byte_order=\"BigEndian\" " + attributes);
}

std::string appended_file(const std::string& attributes, const std::string& encoding, const Three& data) {
  Three rest;
  std::string all;
  for (std::size_t i = 0; i < 3; ++i) {
    rest[i] = fmt::format("format=\"appended\" offset=\"{}\"", all.size());
    all += data[i];
  }
  return file("PolyData", square(rest, {}), "byte_order=\"BigEndian\" " + attributes,
              "<AppendedData encoding=\"" + encoding + "\">\n _" + all + "\n</AppendedData>");
}

TEST_F(VtkTest, ReadsEveryEncoding) {
  const Three bytes{raw(kSquare, kOrder), raw(std::vector<std::int32_t>{0, 1, 2, 3}, kOrder),
                    raw(std::vector<std::int32_t>{4}, kOrder)};
  Three plain, wide, plain64, packed_raw, packed64;
  for (std::size_t i = 0; i < 3; ++i) {
    plain[i] = word(bytes[i].size()) + bytes[i];
    wide[i] = bytes_of(std::uint64_t{bytes[i].size()}, kOrder) + bytes[i];
    plain64[i] = GltfBuilder::base64(plain[i]);
    const auto [header, blocks] = packed(bytes[i]);
    packed_raw[i] = header + blocks;
    packed64[i] = GltfBuilder::base64(header) + GltfBuilder::base64(blocks);
  }
  const std::string zlib = "compressor=\"vtkZLibDataCompressor\"";
  for (const std::string& text :
       {inline_file("", {"\n  " + plain64[0] + "\n", plain64[1], plain64[2]}), inline_file(zlib, packed64),
        appended_file("header_type=\"UInt32\"", "raw", plain), appended_file("", "base64", plain64),
        appended_file(zlib, "raw", packed_raw), appended_file(zlib, "base64", packed64),
        appended_file("header_type=\"UInt64\"", "raw", wide)}) {
    const auto motion = open({files.write("a.vtp", text)});
    ASSERT_TRUE(motion) << text;
    EXPECT_EQ(triangles(*motion), (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}}));
    EXPECT_EQ(frame(*motion, 0), kSquare);
  }
}

// The fuzzers' seeds were written by VTK 9.1.
TEST_F(VtkTest, ReadsWhatVtkWrites) {
  const std::string seeds = FOLDPROOF_SOURCE_DIR "/tests/fuzz/corpus/";
  for (const char* encoding : {"ascii", "binary", "appended"}) {
    const auto polygons = open({fmt::format("{}vtp/{}.vtp", seeds, encoding)}),
               grid = open({fmt::format("{}vtu/{}.vtu", seeds, encoding)});
    ASSERT_TRUE(polygons && grid) << encoding;
    EXPECT_EQ(triangles(*polygons), (std::vector<Triangle>{{0, 1, 3}, {0, 3, 2}, {0, 1, 3}}));
    EXPECT_EQ(frame(*polygons, 0), (std::vector<double>{0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0.5}));
    EXPECT_THAT(polygons->info().parts.names, ElementsAre("group 5", "group 6"));
    EXPECT_EQ(grid->topology().triangles().size(), 6u);
    EXPECT_EQ(grid->topology().vertex_count(), 5u);
  }
}

TEST_F(VtkTest, OfVolumesOnlyTheBoundaryIsLeft) {
  EXPECT_EQ(triangles(*cells("0 1 2 4", "4", "10")),
            (std::vector<Triangle>{{0, 1, 4}, {1, 2, 4}, {2, 0, 4}, {0, 2, 1}}));
  const auto two = triangles(*cells("0 1 2 4 1 2 4 7", "4 8", "10 10"));
  EXPECT_EQ(two.size(), 6u);
  EXPECT_EQ(std::count(two.begin(), two.end(), Triangle{1, 2, 4}), 0);
  // Each is closed and oriented outward: its volume is that of the cell.
  const auto volume = [&](const std::string& connectivity, const std::string& type) {
    const auto motion = cells(
        connectivity, std::to_string(std::count(connectivity.begin(), connectivity.end(), ' ') + 1), type);
    const std::vector<double> x = frame(*motion, 0);
    double six = 0;
    for (const Triangle& t : triangles(*motion)) {
      const auto p = [&](int k) { return Vec3(x[3 * t[k]], x[3 * t[k] + 1], x[3 * t[k] + 2]); };
      six += p(0).dot(p(1).cross(p(2)));
    }
    return six / 6;
  };
  EXPECT_NEAR(volume("0 1 2 4", "10"), 1 / 6., 1e-12);
  EXPECT_NEAR(volume("0 1 2 3 4 5 6 7", "11"), 1, 1e-12);
  EXPECT_NEAR(volume("0 1 3 2 4 5 7 6", "12"), 1, 1e-12);
  EXPECT_NEAR(volume("0 2 1 4 6 5", "13"), 0.5, 1e-12);
  EXPECT_NEAR(volume("0 1 3 2 4", "14"), 1 / 3., 1e-12);
}

TEST_F(VtkTest, VolumesWithTheSameCornersAreOne) {
  const auto one = triangles(*cells("0 1 2 4", "4", "10"));
  EXPECT_EQ(triangles(*cells("0 1 2 4 0 1 2 4", "4 8", "10 10")), one);
  EXPECT_EQ(triangles(*cells("0 1 2 4 4 2 1 0 1 0 2 4", "4 8 12", "10 10 10")), one);
  EXPECT_EQ(triangles(*cells("0 1 2 4 1 2 4 7 0 1 2 4 7 4 2 1", "4 8 12 16", "10 10 10 10")),
            triangles(*cells("0 1 2 4 1 2 4 7", "4 8", "10 10")));
  // A voxel and a hexahedron.
  EXPECT_EQ(triangles(*cells("0 1 2 3 4 5 6 7 0 1 3 2 4 5 7 6", "8 16", "11 12")),
            triangles(*cells("0 1 2 3 4 5 6 7", "8", "11")));
}

TEST_F(VtkTest, VolumesWithoutThicknessKeepTheirFaces) {
  const auto found = triangles(*cells("0 1 2 0 1 2", "6", "13"));  // a wedge with both ends at one place
  EXPECT_EQ(std::count(found.begin(), found.end(), Triangle{0, 1, 2}), 1);
}

TEST_F(VtkTest, SurfacesComeBeforeTheBoundaryOfVolumes) {
  const std::vector<Triangle> tetrahedron{{0, 1, 4}, {1, 2, 4}, {2, 0, 4}, {0, 2, 1}};
  // A triangle elsewhere, one of the four faces, all of them, and one between two volumes.
  auto expected = tetrahedron;
  expected.insert(expected.begin(), {8, 9, 10});
  EXPECT_EQ(triangles(*cells("0 1 2 4 8 9 10", "4 7", "10 5")), expected);
  EXPECT_EQ(triangles(*cells("0 1 2 4 0 1 2", "4 7", "10 5")),
            (std::vector<Triangle>{{0, 1, 2}, {0, 1, 4}, {1, 2, 4}, {2, 0, 4}}));
  EXPECT_EQ(triangles(*cells("0 1 2 4 0 1 4 1 2 4 2 0 4 0 2 1", "4 7 10 13 16", "10 5 5 5 5")), tetrahedron);
  EXPECT_EQ(triangles(*cells("0 1 2 4 1 2 4 7 1 2 4", "4 8 11", "10 10 5")).size(), 7u);
  // The bottom of a cube as a quad that starts elsewhere, as two triangles on either diagonal, and half of
  // it.
  const std::string cube = "0 1 3 2 4 5 7 6";
  EXPECT_EQ(triangles(*cells(cube + " 1 3 2 0", "8 12", "12 9")).size(), 12u);
  EXPECT_EQ(triangles(*cells(cube + " 0 1 3 0 3 2", "8 11 14", "12 5 5")).size(), 12u);
  EXPECT_EQ(triangles(*cells(cube + " 0 1 2 1 3 2", "8 11 14", "12 5 5")).size(), 12u);
  EXPECT_EQ(triangles(*cells(cube + " 0 1 3", "8 11", "12 5")).size(), 12u);
  EXPECT_EQ(triangles(*cells(cube + " 0 1 2", "8 11", "12 5")).size(), 12u);
}

TEST_F(VtkTest, CellsOfSurfacesAreKeptAndLinesIgnored) {
  EXPECT_EQ(
      triangles(*cells("0 1 0 1 2 0 1 2 3 0 1 3 2 0 1 2 3", "2 5 9 13 17", "3 5 8 9 6")),
      (std::vector<Triangle>{{0, 1, 2}, {0, 1, 3}, {0, 3, 2}, {0, 1, 3}, {0, 3, 2}, {0, 1, 2}, {1, 3, 2}}));
}

TEST_F(VtkTest, CollectionsAreFramesInTheOrderOfTheirTimes) {
  const auto moved = [&](const char* z) {
    std::string body = polygons();
    body.replace(body.find("0.5"), 3, z);
    return file("PolyData", body);
  };
  files.write("run/a.vtp", moved("1"));
  files.write("run/b.vtp", moved("2"));
  const auto set = [](const std::string& time, const std::string& name) {
    return "<DataSet timestep=\"" + time + "\" file=\"" + name + "\"/>\n";
  };
  const auto pvd = [&](const std::string& sets) { return files.write("a.pvd", file("Collection", sets)); };
  const auto motion = open({pvd(set("1.5", "run/a.vtp") + set("0", "run/b.vtp"))});
  ASSERT_TRUE(motion);
  EXPECT_EQ(motion->frame_count(), 2u);
  EXPECT_EQ(frame(*motion, 0)[11], 2);
  EXPECT_EQ(frame(*motion, 1)[11], 1);
  EXPECT_EQ(open_error({pvd(set("0", "../x.vtp"))}),
            "a.pvd: refers to '../x.vtp', which is not below its directory; keep the files of a collection "
            "beside it");
  EXPECT_THAT(open_error({pvd(set("0", "/etc/passwd"))}), HasSubstr("not below its directory"));
  EXPECT_THAT(open_error({pvd(set("0", "run/a.vtp") + set("0", "run/b.vtp"))}),
              HasSubstr("has several parts at time 0;"));
  EXPECT_EQ(open_error({pvd(set("nan", "run/a.vtp"))}),
            "a.pvd: the time of 'run/a.vtp' is not a finite number; write the file again");
  for (const char* time : {"1,5", "t1", "1 2", "1s", ""}) {
    EXPECT_EQ(open_error({pvd(set(time, "run/a.vtp"))}),
              "a.pvd: the time of 'run/a.vtp' is not a finite number; write the file again");
  }
  EXPECT_EQ(open({pvd("<DataSet file=\"run/a.vtp\"/>")})->frame_count(), 1u);
  EXPECT_EQ(open_error({pvd("")}), "a.pvd: refers to no files; write the file again");
}

TEST_F(VtkTest, BadFilesAreOneLineErrors) {
  const std::string again = "; write the file again";
  EXPECT_EQ(open_error({files.write("a.vtp", " ")}),
            "a.vtp, byte 1: is not XML: No document element found" + again);
  EXPECT_THAT(open_error({files.write("a.vtp", "<a></b>")}), HasSubstr("a.vtp, byte "));
  EXPECT_THAT(open_error({files.write("a.vtp", "<a/>")}), HasSubstr("a.vtp: is not a VTK XML file; "));
  EXPECT_THAT(open_error({files.write("a.vtu", file("PolyData", ""))}),
              HasSubstr("a.vtu: holds PolyData, not UnstructuredGrid; "));
  EXPECT_EQ(open_error({files.write("a.vtp", "<VTKFile type=\"PolyData\"/>")}),
            "a.vtp: has no element PolyData" + again);
  EXPECT_EQ(error("", "compressor=\"vtkLZ4DataCompressor\""),
            "a.vtp: is compressed with vtkLZ4DataCompressor; write it with zlib, or not compressed");
  const auto changed = [&](const std::string& from, const std::string& to) {
    std::string body = polygons();
    body.replace(body.find(from), from.size(), to);
    return error(body);
  };
  EXPECT_EQ(changed("0.5", "nan"), "a.vtp, DataArray 'Points': value 11 is not a finite number" + again);
  EXPECT_EQ(changed("0.5", ""), "a.vtp, DataArray 'Points': has 11 numbers for 4 points" + again);
  EXPECT_EQ(changed("Points=\"4\"", "Points=\"4000000000\""),
            "a.vtp, DataArray 'Points': has 12 numbers for 4000000000 points" + again);
  EXPECT_EQ(changed("Points=\"4\"", "Points=\"x\""), "a.vtp, Piece: NumberOfPoints is not a count" + again);
  EXPECT_EQ(changed("NumberOfPoints=\"4\"", ""), "a.vtp, Piece: has Points, but no NumberOfPoints" + again);
  EXPECT_EQ(changed("NumberOfPolys=\"2\"", ""), "a.vtp, Piece: has Polys, but no NumberOfPolys" + again);
  EXPECT_EQ(changed("NumberOfStrips=\"1\"", "NumberOfStrips=\"\""),
            "a.vtp, Piece: has Strips, but no NumberOfStrips" + again);
  EXPECT_EQ(changed("1 3<", "1 4<"),
            "a.vtp, Polys: cell 1 refers to vertex 4, but there are 4 (counting from 0)" + again);
  EXPECT_EQ(changed("4 7", "4 8"),
            "a.vtp, Polys: cell 1 has an offset that is not within its vertices" + again);
  EXPECT_EQ(changed("4 7", "2 7"), "a.vtp, Polys: cell 0 has 2 vertices" + again);
  EXPECT_EQ(changed("4 7", "4"), "a.vtp, Polys: has 1 offsets for 2 cells" + again);
  EXPECT_EQ(changed("Int64\" Name=\"offsets", "Float64\" Name=\"offsets"),
            "a.vtp, DataArray 'offsets': does not hold integers" + again);
  EXPECT_EQ(changed("format=\"ascii\"", "format=\"appended\" offset=\"9\""),
            "a.vtp, DataArray 'Points': its offset is not within the appended data" + again);
  EXPECT_EQ(changed("format=\"ascii\"", "format=\"binary\""),
            "a.vtp, DataArray 'Points': ends before its last value" + again);
}

// Arrays that share their bytes would make a small file a large mesh.
TEST_F(VtkTest, ArraysMayNotShareTheirBytes) {
  std::string piece = "<Piece NumberOfPoints=\"4\" NumberOfPolys=\"0\"><Points>" +
                      array("Points", "Float64", "format=\"appended\" offset=\"0\"") + "</Points></Piece>",
              body;
  for (int i = 0; i < 1000; ++i) body += piece;
  const std::string data(96 * 4000, '\0');
  body.replace(body.find("\"4\""), 3, "\"16000\"");
  const std::string bytes =
      file("PolyData", body, "",
           "<AppendedData encoding=\"raw\">_" + bytes_of(static_cast<std::uint32_t>(data.size())) + data +
               "</AppendedData>");
  EXPECT_THAT(open_error({files.write("a.vtp", bytes)}), HasSubstr("ends before its last value"));
}

}  // namespace
}  // namespace foldproof::testing
