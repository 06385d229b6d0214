#include "io/support.h"

namespace foldproof::testing {
namespace {

class PlyTest : public IoTest {
 protected:
  std::unique_ptr<Motion> ply(std::string_view text) { return open({files.write("a.ply", text)}); }
  std::string ply_error(std::string_view text) { return open_error({files.write("a.ply", text)}); }
};

const char* const kAsciiHeader =
    "ply\nformat ascii 1.0\ncomment generated\nobj_info none\nelement vertex 3\nproperty float x\nproperty "
    "float y\n"
    "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";

template <class Coordinate, class Id>
std::string binary_triangle(const std::string& coordinate, const std::string& id, std::endian order) {
  std::string text = "ply\nformat ";
  text += order == std::endian::little ? "binary_little_endian" : "binary_big_endian";
  text += " 1.0\nelement vertex 3\n";
  for (const char axis : {'x', 'y', 'z'}) text += "property " + coordinate + " " + axis + "\n";
  text += "element face 1\nproperty list uchar " + id + " vertex_index\nend_header\n";
  for (const double x : kTrianglePositions) text += bytes_of(static_cast<Coordinate>(x), order);
  text += '\3';
  for (const Id v : {0, 1, 2}) text += bytes_of(v, order);
  return text;
}

TEST_F(PlyTest, ReadsBinaryOfEveryTypeAndByteOrder) {
  for (const std::endian order : {std::endian::little, std::endian::big}) {
    for (const std::string& text : {binary_triangle<float, std::int32_t>("float", "int", order),
                                    binary_triangle<double, std::uint32_t>("double", "uint", order),
                                    binary_triangle<float, std::uint8_t>("float32", "uint8", order),
                                    binary_triangle<double, std::int8_t>("float64", "char", order),
                                    binary_triangle<std::int16_t, std::int16_t>("short", "int16", order),
                                    binary_triangle<std::uint16_t, std::uint16_t>("uint16", "ushort", order),
                                    binary_triangle<std::int8_t, std::int32_t>("int8", "int32", order)}) {
      SCOPED_TRACE(text);
      const auto motion = ply(text);
      ASSERT_TRUE(motion);
      EXPECT_EQ(triangles(*motion), kOneTriangle);
      EXPECT_EQ(frame(*motion, 0), kTrianglePositions);
    }
  }
}

TEST_F(PlyTest, ReadsAscii) {
  for (const std::string& text : {
           std::string(kAsciiHeader) + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
           std::string(kAsciiHeader) + "0 0 0\r\n\r\n 1 0 0\n0 1 0 \n3 0 1 2",
       }) {
    SCOPED_TRACE(text);
    const auto motion = ply(text);
    ASSERT_TRUE(motion);
    EXPECT_EQ(triangles(*motion), kOneTriangle);
    EXPECT_EQ(frame(*motion, 0), kTrianglePositions);
  }
}

TEST_F(PlyTest, SkipsWhatItDoesNotNeed) {
  const auto motion =
      ply("ply\nformat ascii 1.0\nelement camera 1\nproperty float view\nproperty list uchar float lens\n"
          "element nothing 99999999999\nelement face 2\nproperty uchar red\nproperty list int uint "
          "vertex_indices\n"
          "property list uchar float texcoord\nelement vertex 4\nproperty float nz\nproperty double z\n"
          "property list uchar int tags\nproperty double x\nproperty double y\nelement edge 1\nproperty int "
          "vertex1\n"
          "end_header\n"
          "0.5 2 1 nan\n"
          "255 3 0 1 2 6 0 0 1 0 1 1\n7 4 0 1 2 3 0\n"
          "nan 3 2 5 6 1 2\n9 6 0 4 5\n9 9 1 1 7 8\n9 0 0 0 -0\n"
          "1\n");
  ASSERT_TRUE(motion);
  EXPECT_EQ(triangles(*motion), (std::vector<Triangle>{{0, 1, 2}, {0, 1, 2}, {0, 2, 3}}));
  EXPECT_EQ(frame(*motion, 0), (std::vector<double>{1, 2, 3, 4, 5, 6, 7, 8, 9, 0, 0, 0}));
}

TEST_F(PlyTest, SkipsExtraBinaryProperties) {
  std::string text =
      "ply\nformat binary_big_endian 1.0\nelement vertex 3\nproperty uchar red\nproperty float z\nproperty "
      "float x\n"
      "property list ushort double history\nproperty float y\nelement face 1\nproperty short flags\n"
      "property list uint uchar vertex_indices\nelement tail 2\nproperty double d\nend_header\n";
  const auto big = std::endian::big;
  for (int v = 0; v < 3; ++v) {
    text += "\x7f" + bytes_of(float(3 * v + 2), big) + bytes_of(float(3 * v), big) +
            bytes_of(std::uint16_t(v), big);
    for (int i = 0; i < v; ++i) text += bytes_of(std::numeric_limits<double>::quiet_NaN(), big);
    text += bytes_of(float(3 * v + 1), big);
  }
  text += bytes_of(std::int16_t{-1}, big) + bytes_of(std::uint32_t{3}, big) + std::string("\2\1\0", 3) +
          std::string(16, '\xff');
  const auto motion = ply(text);
  ASSERT_TRUE(motion);
  EXPECT_EQ(triangles(*motion), (std::vector<Triangle>{{2, 1, 0}}));
  EXPECT_EQ(frame(*motion, 0), (std::vector<double>{0, 1, 2, 3, 4, 5, 6, 7, 8}));
}

TEST_F(PlyTest, KeepsABodyThatStartsWithALineFeed) {
  // The coordinates of the first vertex are (10, 0, 0), and 10 is LF.
  const std::string body = std::string("\x0a\0\0\0\1\0\0\0\1", 9) + std::string("\3\0\1\2", 4);
  for (const std::string end : {"\r", "\n", "\r\n"}) {
    std::string text;
    for (const char* line :
         {"ply", "format binary_little_endian 1.0", "element vertex 3", "property char x", "property char y",
          "property char z", "element face 1", "property list uchar uchar vertex_indices", "end_header"}) {
      text += line + end;
    }
    const auto motion = ply(text + body);
    ASSERT_TRUE(motion);
    EXPECT_EQ(frame(*motion, 0), (std::vector<double>{10, 0, 0, 0, 1, 0, 0, 0, 1}));
  }
}

TEST_F(PlyTest, NamesPlaceAndMendInAscii) {
  const std::string head = kAsciiHeader, again = "; export the mesh again";
  EXPECT_EQ(ply_error(head + "0 0 0\n1 0\n0 1 0\n3 0 1 2\n"),
            "a.ply:13: a value of vertex 1 is missing" + again);
  EXPECT_EQ(ply_error(head + "0 0 0\n1 0 0 0\n0 1 0\n3 0 1 2\n"),
            "a.ply:13: vertex 1 has more values than declared" + again);
  EXPECT_EQ(
      ply_error(head + "0 0 0\n1 0 NaN\n0 1 0\n3 0 1 2\n"),
      "a.ply:13: a value of vertex 1 is not finite; export the mesh without NaN or infinite coordinates");
  EXPECT_EQ(
      ply_error(head + "0 0 0\n1 0 1e999\n0 1 0\n3 0 1 2\n"),
      "a.ply:13: a value of vertex 1 is not finite; export the mesh without NaN or infinite coordinates");
  EXPECT_EQ(ply_error(head + "0 0 0\n1 0 x\n0 1 0\n3 0 1 2\n"),
            "a.ply:13: a value of vertex 1 is not a number" + again);
  EXPECT_EQ(ply_error(head + "0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n"),
            "a.ply:15: face 0 refers to vertex 3, but there are 3 (counting from 0)" + again);
  EXPECT_EQ(ply_error(head + "0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n"),
            "a.ply:15: face 0 refers to vertex -1, but there are 3 (counting from 0)" + again);
  EXPECT_EQ(ply_error(head + "0 0 0\n1 0 0\n0 1 0\n2 0 1\n"),
            "a.ply:15: face 0 has a list of 2 values; remove faces with fewer than three vertices");
  EXPECT_EQ(ply_error(head + "0 0 0\n1 0 0\n0 1 0\n9000000000000000000 0 1\n"),
            "a.ply:15: a value of face 0 is missing" + again);
  EXPECT_EQ(ply_error(head + "0 0 0\n1 0 0\n0 1 0\n"),
            "a.ply:15: header announces 1 of element 'face', but the file ends before; copy or export the "
            "mesh again");
  EXPECT_EQ(ply_error(head + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n3 0 1 2\n"),
            "a.ply:16: there is more data than the header announces" + again);
}

TEST_F(PlyTest, NamesPlaceAndMendInHeaders) {
  const std::string again = "; export the mesh as PLY again", start = "ply\nformat ascii 1.0\n";
  const std::string vertex = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
  EXPECT_EQ(ply_error("\n"), "a.ply:1: does not start with the line 'ply'" + again);
  EXPECT_EQ(ply_error("plywood\n"), "a.ply:1: does not start with the line 'ply'" + again);
  EXPECT_EQ(
      ply_error(start + vertex +
                "element face 1\nproperty list uchar int vertex_indices\nelement tristrips 1\n"
                "property list int int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n3 0 1 2\n"),
      "a.ply:11: header declares triangle strips, which are not read; export the mesh as PLY with its faces");
  EXPECT_EQ(ply_error("ply\n"), "a.ply:2: the file ends before 'end_header'" + again);
  EXPECT_EQ(ply_error("ply\nformat utf8 1.0\n"),
            "a.ply:2: format is not ascii, binary_little_endian or binary_big_endian" + again);
  EXPECT_EQ(ply_error(start + "element vertex -3\n"), "a.ply:3: element has no proper count" + again);
  EXPECT_EQ(ply_error(start + "element vertex\n"), "a.ply:3: element has no proper count" + again);
  EXPECT_EQ(ply_error(start + "property float x\n"), "a.ply:3: property stands before any element" + again);
  EXPECT_EQ(ply_error(start + vertex + "property half w\n"), "a.ply:7: property has an unknown type" + again);
  EXPECT_EQ(ply_error(start + vertex + "property double x\n"),
            "a.ply:7: property 'x' is declared twice" + again);
  EXPECT_EQ(ply_error(start + vertex + "element vertex 3\n"),
            "a.ply:7: element 'vertex' is declared twice" + again);
  EXPECT_EQ(ply_error(start + vertex + "property list float int tags\n"),
            "a.ply:7: the count of a list is not an integer type" + again);
  EXPECT_EQ(ply_error(start + vertex + "element face 1\nproperty list uchar float vertex_indices\n"),
            "a.ply:8: the vertices of a face are not a list of integers" + again);
  EXPECT_EQ(ply_error(start + "banana\n"), "a.ply:3: header has an unknown keyword" + again);
  EXPECT_EQ(ply_error(start + "element vertex 3\nproperty float x\nproperty float z\nend_header\n"),
            "a.ply:6: header declares no vertices with x, y and z" + again);
  EXPECT_EQ(ply_error(start + vertex + "end_header\n"),
            "a.ply:7: header declares no faces with vertex_indices; export the mesh with its faces");
  EXPECT_EQ(
      ply_error("ply\n" + vertex + "element face 1\nproperty list uchar int vertex_index\nend_header\n"),
      "a.ply:8: header has no line 'format'" + again);
}

TEST_F(PlyTest, NamesByteInBinary) {
  std::string good = binary_triangle<float, std::int32_t>("float", "int", std::endian::little);
  const std::size_t body = good.find("end_header\n") + 11;
  std::string text = good;
  text.replace(body + 16, 4, bytes_of(std::numeric_limits<float>::infinity()));
  EXPECT_EQ(ply_error(text), "a.ply, byte " + std::to_string(body + 16) +
                                 ": a value of vertex 1 is not finite; "
                                 "export the mesh without NaN or infinite coordinates");
  text = good;
  text.replace(body + 41, 4, bytes_of(std::int32_t{-2}));
  EXPECT_EQ(ply_error(text),
            "a.ply, byte " + std::to_string(body + 41) +
                ": face 0 refers to vertex -2, but there are 3 (counting from 0); export the mesh again");
  EXPECT_EQ(ply_error(good + "x"),
            "a.ply, byte " + std::to_string(good.size()) +
                ": there is more data than the header announces; export the mesh again");
  EXPECT_TRUE(ply(good + "\n")) << "a line end after the data does no harm";
  text = good;
  text.replace(text.find("vertex 3"), 8, "vertex 99999999");
  EXPECT_EQ(ply_error(text), "a.ply, byte " + std::to_string(body + 7) +
                                 ": header announces 99999999 of element 'vertex', but the file ends before; "
                                 "copy or export the mesh again");
}

}  // namespace
}  // namespace foldproof::testing
