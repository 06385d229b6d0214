#include "io/support.h"

namespace foldproof::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

const std::string kNames = "$PhysicalNames\n2\n2 7 \"left wing\"\n2 8 \"right\"\n$EndPhysicalNames\n";

// Nodes 10, 20, 30 and 5; a line, a triangle of group 7 and a quad of group 8.
const std::string kOld =
    "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n" + kNames +
    "$Nodes\n4\n10 0 0 0\n20 1 0 0\n30 0 1 0\n5 1 1 0.5\n$EndNodes\n"
    "$Elements\n3\n1 1 2 0 1 10 20\n2 2 2 7 1 10 20 30\n3 3 2 8 2 10 20 5 30\n$EndElements\n";
const std::string kNew =
    "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n" + kNames +
    "$Entities\n1 0 2 0\n1 0 0 0 0\n1 0 0 0 1 1 1 1 7 1 4\n2 0 0 0 1 1 1 1 8 0\n$EndEntities\n"
    "$Nodes\n2 4 5 30\n2 1 0 3\n10\n20\n30\n0 0 0\n1 0 0\n0 1 0\n2 2 1 1\n5\n1 1 0.5 0.1 0.2\n$EndNodes\n"
    "$Elements\n3 3 1 3\n1 1 1 1\n1 10 20\n2 1 2 1\n2 10 20 30\n2 2 3 1\n3 10 20 5 30\n$EndElements\n";

const std::string kV40 =
    "$MeshFormat\n4 0 8\n$EndMeshFormat\n" + kNames +
    "$Entities\n1 1 2 0\n1 0 0 0 0 0 0 0\n1 0 0 0 1 0 0 0 2 1 -2\n1 0 0 0 1 1 1 1 7 1 4\n2 0 0 0 1 1 1 1 8 "
    "0\n"
    "$EndEntities\n$Nodes\n2 4\n1 2 0 3\n10 0 0 0\n20 1 0 0\n30 0 1 0\n2 2 1 1\n5 1 1 0.5 0.1 "
    "0.2\n$EndNodes\n"
    "$Elements\n3 3\n1 1 1 1\n1 10 20\n1 2 2 1\n2 10 20 30\n2 2 3 1\n3 10 20 5 30\n$EndElements\n";

/// The same meshes in binary.
std::string binary_old(std::endian order) {
  const auto i = [&](std::initializer_list<std::int32_t> values) {
    std::string bytes;
    for (const std::int32_t value : values) bytes += bytes_of(value, order);
    return bytes;
  };
  const auto node = [&](std::int32_t tag, double x, double y, double z) {
    return i({tag}) + bytes_of(x, order) + bytes_of(y, order) + bytes_of(z, order);
  };
  return "$MeshFormat\n2.2 1 8\n" + i({1}) + "\n$EndMeshFormat\n" + kNames + "$Nodes\n4\n" +
         node(10, 0, 0, 0) + node(20, 1, 0, 0) + node(30, 0, 1, 0) + node(5, 1, 1, 0.5) +
         "\n$EndNodes\n$Elements\n3\n" + i({1, 1, 2, 1, 0, 1, 10, 20}) + i({2, 1, 2, 2, 7, 1, 10, 20, 30}) +
         i({3, 1, 2, 3, 8, 2, 10, 20, 5, 30}) + "\n$EndElements\n";
}

struct Binary {
  static std::string ints(std::initializer_list<std::int32_t> values) { return all(values); }
  static std::string sizes(std::initializer_list<std::uint64_t> values) { return all(values); }
  static std::string doubles(std::initializer_list<double> values) { return all(values); }

 private:
  template <class T>
  static std::string all(std::initializer_list<T> values) {
    std::string bytes;
    for (const T value : values) bytes += bytes_of(value);
    return bytes;
  }
};

std::string binary_v40() {
  const auto i = Binary::ints;
  const auto n = Binary::sizes;
  const auto d = Binary::doubles;
  const std::string box = d({0, 0, 0, 1, 1, 1});
  return "$MeshFormat\n4 1 8\n" + i({1}) + "\n$EndMeshFormat\n" + kNames + "$Entities\n" + n({1, 0, 2, 0}) +
         i({1}) + box + n({0}) + i({1}) + box + n({1}) + i({7}) + n({1}) + i({4}) + i({2}) + box + n({1}) +
         i({8}) + n({0}) + "\n$EndEntities\n$Nodes\n" + n({2, 4}) + i({1, 2, 0}) + n({3}) + i({10}) +
         d({0, 0, 0}) + i({20}) + d({1, 0, 0}) + i({30}) + d({0, 1, 0}) + i({2, 2, 1}) + n({1}) + i({5}) +
         d({1, 1, 0.5, 0.1, 0.2}) + "\n$EndNodes\n$Elements\n" + n({3, 3}) + i({1, 1, 1}) + n({1}) +
         i({1, 10, 20}) + i({1, 2, 2}) + n({1}) + i({2, 10, 20, 30}) + i({2, 2, 3}) + n({1}) +
         i({3, 10, 20, 5, 30}) + "\n$EndElements\n";
}

std::string binary_new() {
  const auto i = Binary::ints;
  const auto n = Binary::sizes;
  const auto d = Binary::doubles;
  const std::string box = d({0, 0, 0, 1, 1, 1});
  return "$MeshFormat\n4.1 1 8\n" + i({1}) + "\n$EndMeshFormat\n" + kNames + "$Entities\n" + n({1, 0, 2, 0}) +
         i({1}) + d({0, 0, 0}) + n({0}) + i({1}) + box + n({1}) + i({7}) + n({1}) + i({4}) + i({2}) + box +
         n({1}) + i({8}) + n({0}) + "\n$EndEntities\n$Nodes\n" + n({2, 4, 5, 30}) + i({2, 1, 0}) +
         n({3, 10, 20, 30}) + d({0, 0, 0, 1, 0, 0, 0, 1, 0}) + i({2, 2, 1}) + n({1, 5}) +
         d({1, 1, 0.5, 0.1, 0.2}) + "\n$EndNodes\n$Elements\n" + n({3, 3, 1, 3}) + i({1, 1, 1}) +
         n({1, 1, 10, 20}) + i({2, 1, 2}) + n({1, 2, 10, 20, 30}) + i({2, 2, 3}) + n({1, 3, 10, 20, 5, 30}) +
         "\n$EndElements\n";
}

class MshTest : public IoTest {};

TEST_F(MshTest, ReadsBothVersionsInTextAndBinary) {
  for (const std::string& bytes : {kOld, kV40, kNew, binary_old(std::endian::little),
                                   binary_old(std::endian::big), binary_v40(), binary_new()}) {
    const auto motion = open({files.write("a.msh", bytes)});
    ASSERT_TRUE(motion) << bytes;
    EXPECT_EQ(triangles(*motion), (std::vector<Triangle>{{0, 1, 2}, {0, 1, 3}, {0, 3, 2}}));
    EXPECT_EQ(frame(*motion, 0), (std::vector<double>{0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0.5}));
    EXPECT_THAT(motion->info().parts.names, ElementsAre("left wing", "right"));
    EXPECT_THAT(motion->info().parts.of_triangle, ElementsAre(0, 1, 1));
  }
}

// Some writers put no line end between binary data and the end of a section.
TEST_F(MshTest, SectionsThatAreSkippedMayEndBehindBinaryData) {
  const std::string data = std::string("\x01\0\0\0\0\0\0\0\0\0\xe0\x3f", 12);
  for (const std::string& section :
       {"$ElementData\n1\n\"E\"\n1\n0\n3\n0\n1\n1\n" + data + "$EndElementData\n",
        "$ElementData\n" + data + "$EndElementDat\n$EndElementDataX\n" + data + "$EndElementData"}) {
    EXPECT_EQ(triangles(*open({files.write("a.msh", binary_old(std::endian::little) + section)})).size(), 3u);
  }
  EXPECT_THAT(open_error({files.write("a.msh", kOld + "$ElementData\n" + data + "$EndElementDataX\n")}),
              HasSubstr("the file ends within $ElementData; "));
}

TEST_F(MshTest, WithoutGroupsPartsAreEntities) {
  std::string bytes = kOld;
  for (const char* group : {" 2 7 1 ", " 2 8 2 "}) bytes[bytes.find(group) + 3] = '0';
  EXPECT_THAT(open({files.write("a.msh", bytes)})->info().parts.names, ElementsAre("surface 1", "surface 2"));
}

TEST_F(MshTest, OfVolumesOnlyTheBoundaryIsLeft) {
  const std::string head =
      "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$EndNodes\n";
  const auto read = [&](const std::string& elements) {
    return open({files.write("a.msh", head + "$Elements\n" + elements + "$EndElements\n")});
  };
  const std::vector<Triangle> faces{{0, 1, 3}, {1, 2, 3}, {2, 0, 3}, {0, 2, 1}};
  EXPECT_EQ(triangles(*read("1\n1 4 0 1 2 3 4\n")), faces);
  EXPECT_EQ(triangles(*read("2\n1 4 0 1 2 3 4\n2 2 0 1 2 3\n")),
            (std::vector<Triangle>{{0, 1, 2}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}));
  const auto grouped = read("3\n1 4 2 1 1 1 2 3 4\n2 4 2 2 1 1 2 3 4\n3 4 2 2 1 2 1 4 3\n");
  EXPECT_EQ(triangles(*grouped), faces) << "an element per physical group";
}

TEST_F(MshTest, BadFilesAreOneLineErrors) {
  const std::string again = "; save the mesh again as Gmsh 4.1 or 2.2";
  const auto changed = [&](const std::string& bytes, const std::string& from, const std::string& to) {
    std::string copy = bytes;
    copy.replace(copy.find(from), from.size(), to);
    return open_error({files.write("a.msh", copy)});
  };
  EXPECT_EQ(open_error({files.write("a.msh", "Mesh")}), "a.msh:1: does not start with $MeshFormat" + again);
  EXPECT_EQ(changed(kNew, "4.1 0", "4.2 0"), "a.msh:3: Gmsh's format '4.2 0 8' is not read" + again);
  EXPECT_EQ(changed(kOld, "\n4\n10", "\n4000000000\n10"),
            "a.msh:11: announces more than the file holds" + again);
  EXPECT_EQ(
      changed(kOld, "1 0 0\n", "1 0 nan\n"),
      "a.msh:12: coordinate z of node 20 is not finite; export the mesh without NaN or infinite coordinates");
  EXPECT_EQ(changed(kOld, "20 1 0 0", "10 1 0 0"), "a.msh:14: node 10 is there twice" + again);
  EXPECT_EQ(changed(kOld, "7 1 10 20 30", "7 1 10 20 31"),
            "a.msh:19: an element refers to node 31, which is not there" + again);
  EXPECT_EQ(
      changed(kOld, "2 2 2 7", "2 9 2 7"),
      "a.msh:19: elements of Gmsh's type 9 are not read; save the mesh with elements of the first order");
  EXPECT_THAT(changed(kOld, "$EndElements", ""), HasSubstr("the file ends within $Elements"));
  for (const auto& [from, to] :
       {std::pair("$Elements\n3\n", "$Elements\n2\n"), std::pair("$Nodes\n4\n", "$Nodes\n3\n"),
        std::pair("PhysicalNames\n2\n", "PhysicalNames\n1\n")}) {
    EXPECT_THAT(changed(kOld, from, to), HasSubstr(" holds more than it announces")) << from;
  }
  EXPECT_THAT(changed(kNew, "$Elements\n3 3 ", "$Elements\n2 3 "),
              HasSubstr("$Elements holds more than it announces"));
  EXPECT_THAT(changed(kNew, "$Entities\n1 0 2 0\n", "$Entities\n1 0 1 0\n"),
              HasSubstr("$Entities holds more than it announces"));
  EXPECT_THAT(changed(kNew, "2 1 0 3\n", "2 1 0 300000000\n"), HasSubstr("a number is missing or wrong"));
  for (const std::string& binary : {binary_new(), binary_v40()}) {
    for (std::size_t length = 0; length + 14 < binary.size(); ++length)
      EXPECT_NE(open_error({files.write("a.msh", binary.substr(0, length))}), "no error") << length;
  }
}

}  // namespace
}  // namespace foldproof::testing
