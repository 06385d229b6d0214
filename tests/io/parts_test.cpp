// Parts that files name, and the unit of their lengths.
#include "io/parts.h"
#include "io/gltf_builder.h"
#include "io/npz_builder.h"

namespace foldproof::testing {
namespace {

using io::part_kind;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

class PartsTest : public IoTest {
 protected:
  /// The part of each triangle, by name.
  std::vector<std::string> parts(const std::vector<std::string>& arguments, const ReadOptions& options = {}) {
    const auto motion = open(arguments, options);
    std::vector<std::string> names;
    if (!motion) return names;
    const ObjectParts& parts = motion->info().parts;
    EXPECT_TRUE(parts.names.empty() || parts.of_triangle.size() == motion->topology().triangles().size());
    for (const Index part : parts.of_triangle) names.push_back(parts.names.at(part));
    return names;
  }
  std::vector<std::string> obj(const std::string& statements) {
    return parts({files.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\n" + statements)});
  }
};

TEST_F(PartsTest, OfObjAreObjectsElseGroupsElseMaterials) {
  const std::string f = "f 1 2 3\n";
  EXPECT_THAT(obj("o a\n" + f + "o b c\n" + f), ElementsAre("a", "b c"));
  EXPECT_THAT(obj("g a\n" + f + "g b#2 \r\n" + f), ElementsAre("a", "b#2"));
  EXPECT_THAT(obj("o one\ng a\n" + f + "g b\n" + f), ElementsAre("a", "b"));
  EXPECT_THAT(obj("o a\ng x\n" + f + "o b\ng x\n" + f), ElementsAre("a", "b"));
  EXPECT_THAT(obj("g all\nusemtl skin\n" + f + "usemtl hair\n" + f), ElementsAre("skin", "hair"));
  EXPECT_THAT(obj(f + "g a\n" + f), ElementsAre("default", "a"));
  EXPECT_THAT(obj("g a\n" + f + "g\n" + f), ElementsAre("a", "default"));
}

TEST_F(PartsTest, OfObjFollowTheTrianglesOfPolygons) {
  EXPECT_THAT(obj("g a\nf 1 2 4 3\ng b\nf 1 2 3\ng a\nf 1 2 3\n"), ElementsAre("a", "a", "b", "a"));
}

TEST_F(PartsTest, AreAtLeastTwo) {
  EXPECT_THAT(obj("o a\ng b\nusemtl c\nf 1 2 3\nf 1 2 4\n"), IsEmpty());
  EXPECT_THAT(obj("g empty\ng a\nf 1 2 3\ng also empty\n"), IsEmpty());
  EXPECT_THAT(obj("f 1 2 3\n"), IsEmpty());
}

TEST_F(PartsTest, OfSequencesAndCachesAreThoseOfTheFirstMesh) {
  const std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 0\ng a\nf 1 2 3\ng b\nf 4 2 3\n";
  files.write("run/f1.obj", text);
  files.write("run/f2.obj", "v 0 0 .1\nv 1 0 .1\nv 0 1 .1\nv 0 0 .1\nf 1 2 3\nf 4 2 3\n");
  EXPECT_THAT(parts({files.path("run")}), ElementsAre("a", "b"));
  EXPECT_THAT(parts({files.path("run")}, {.weld = Weld::Always}), ElementsAre("a", "b"));
  const auto motion = open({files.path("run")});
  const std::string mdd = files.write(
      "a.mdd", bytes_of(1, std::endian::big) + bytes_of(4, std::endian::big) + std::string(4 + 48, '\0'));
  EXPECT_THAT(parts({files.path("run/f1.obj"), mdd}), ElementsAre("a", "b"));
}

TEST_F(PartsTest, OfPlyAreLabelsOfFaces) {
  const std::string vertices =
      "element vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 2\n";
  const std::string list = "property list uchar int vertex_indices\n";
  const std::string points = "end_header\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n";
  const auto ascii = [&](const std::string& properties, const std::string& faces) {
    return parts({files.write("a.ply", "ply\nformat ascii 1.0\n" + vertices + properties + points + faces)});
  };
  EXPECT_THAT(ascii(list + "property int label\n", "4 0 1 3 2 7\n3 0 1 2 -2\n"),
              ElementsAre("label 7", "label 7", "label -2"));
  EXPECT_THAT(ascii("property uchar face_id\nproperty uchar part_id\n" + list, "0 1 3 0 1 2\n0 2 3 0 1 2\n"),
              ElementsAre("part 1", "part 2"));
  EXPECT_THAT(ascii(list + "property int label\nproperty int group\n", "3 0 1 2 1 9\n3 0 1 2 2 8\n"),
              ElementsAre("label 1", "label 2"));
  EXPECT_THAT(ascii(list + "property int label\n", "3 0 1 2 7\n3 0 1 2 7\n"), IsEmpty());
  EXPECT_THAT(ascii(list + "property float label\n", "3 0 1 2 7\n3 0 1 2 8\n"), IsEmpty());
  EXPECT_THAT(ascii(list + "property int label\n", "3 0 1 2 9223372036854775807\n3 0 1 2 0\n"),
              ElementsAre("label 9007199254740992", "label 0"));
  const std::vector<std::int32_t> groups{4, 5};
  const FaceProperty group{"group", groups};
  ASSERT_TRUE(write_ply_properties(files.path("b.ply"), *Topology::make(3, {{0, 1, 2}, {0, 2, 1}}),
                                   kTrianglePositions, std::span(&group, 1)));
  EXPECT_THAT(parts({files.path("b.ply")}), ElementsAre("group 4", "group 5"));
}

TEST_F(PartsTest, OfNpzAreAnArrayOfNumbersOrNames) {
  const std::string faces = npy("<i4", "2, 3", array<std::int32_t>({0, 1, 2, 0, 2, 1}));
  const std::string vertices = npy("<f8", "3, 3", array(kTrianglePositions));
  const auto npz = [&](const std::string& name, const std::string& labels, bool packed = false) {
    return parts({write_archive(files.path("a.npz"),
                                {{"faces.npy", faces}, {"vertices.npy", vertices}, {name, labels}}, packed)});
  };
  const std::string numbers = npy("<i8", "2,", array<std::int64_t>({3, -1}));
  EXPECT_THAT(npz("labels.npy", numbers), ElementsAre("label 3", "label -1"));
  EXPECT_THAT(npz("face_labels.npy", numbers, true), ElementsAre("label 3", "label -1"));
  EXPECT_THAT(npz("other.npy", numbers), IsEmpty());
  EXPECT_THAT(
      npz("parts.npy",
          npy(">U3", "2,", array<std::uint32_t>({'a', 0, 0, 0xe4, 0x20ac, 0x1f600}, std::endian::big))),
      ElementsAre("a", "\xc3\xa4\xe2\x82\xac\xf0\x9f\x98\x80"));
  EXPECT_THAT(npz("parts.npy", npy("<U1", "2,", array<std::uint32_t>({0xd800, 'b'}))),
              ElementsAre("\xef\xbf\xbd", "b"));
  EXPECT_THAT(npz("part_ids.npy", npy("|S2", "2,", std::string("a\0bc", 4)), true), ElementsAre("a", "bc"));
  // What is no list of parts is no error.
  EXPECT_THAT(npz("labels.npy", npy("<i8", "3,", array<std::int64_t>({3, -1, 2}))), IsEmpty());
  EXPECT_THAT(npz("labels.npy", npy("<f8", "2,", array<double>({3, -1}))), IsEmpty());
  EXPECT_THAT(npz("labels.npy", npy("|O", "2,", "pickled")), IsEmpty());
  EXPECT_THAT(npz("labels.npy", npy("<U0", "2,", "")), IsEmpty());
}

TEST_F(PartsTest, OfGltfAreNodesWithTheirMeshesTriangles) {
  GltfBuilder b;
  b.triangle() = {{"attributes", {{"POSITION", 0}}}, {"mode", 5}};
  b.json["meshes"][0]["name"] = "mesh";
  b.json["nodes"] = {
      {{"name", "arm"}, {"mesh", 0}}, {{"name", "leg"}, {"mesh", 0}}, {{"mesh", 0}}, {{"name", 3}}};
  b.json["scenes"] = {{{"nodes", {1, 0, 2}}}};
  const std::string file = files.write("a.gltf", b.gltf());
  EXPECT_THAT(parts({file}), ElementsAre("leg", "arm", "mesh"));
  EXPECT_THAT(parts({file}, {.weld = Weld::Always}), ElementsAre("leg", "arm", "mesh"));
  EXPECT_EQ(open({file})->info().unit, "m");
  EXPECT_EQ(open({file}, {.weld = Weld::Always})->info().unit, "m");
}

TEST_F(PartsTest, OfOneGltfNodeAreMaterials) {
  GltfBuilder b;
  b.triangle();
  auto& primitives = b.json["meshes"][0]["primitives"];
  for (int i = 0; i < 3; ++i) primitives.push_back(primitives[0]);
  primitives[1]["material"] = 1;
  primitives[2]["material"] = 0;
  primitives[3]["material"] = 7;  // does not exist, which does not matter for positions
  b.json["materials"] = {{{"name", "skin"}}, {{"name", ""}}};
  b.json["nodes"] = {{{"name", "body"}, {"mesh", 0}}};
  EXPECT_THAT(parts({files.write("a.gltf", b.gltf())}),
              ElementsAre("no material", "material 1", "skin", "material 7"));
}

TEST_F(PartsTest, OfOneGltfNodeOfOneMaterialAreTheJointsWithTheLargestWeights) {
  GltfBuilder b;
  Json& primitive = b.triangle();
  b.json["accessors"][0]["count"] = 3;
  primitive["indices"] = b.accessor<std::uint8_t>("SCALAR", {0, 1, 2, 0, 0, 1, 2, 2, 2});
  primitive["attributes"]["JOINTS_0"] =
      b.accessor<std::uint8_t>("VEC4", {0, 1, 0, 0, 1, 0, 0, 0, 2, 9, 0, 0});
  primitive["attributes"]["WEIGHTS_0"] =
      b.floats("VEC4", {0.6f, 0.4f, 0, 0, 0.4f, 0.2f, 0, 0, 0.75f, 4, 0, 0});
  b.json["skins"] = {{{"joints", {1, 2, 3}}}};
  b.json["nodes"] = {
      {{"name", "body"}, {"mesh", 0}, {"skin", 0}}, {{"name", "hip"}}, {{"name", "knee"}}, Json::object()};
  // Sums of (hip, knee, node 3): (0.8, 0.8, 0.75), (1.4, 1.2, 0), (0, 0, 2.25); joint 9 does not exist.
  // A joint without a name has that of the mesh, or of the nearest joint above it that has one.
  EXPECT_THAT(parts({files.write("a.gltf", b.gltf())}), ElementsAre("hip", "hip", "body"));
  b.json["nodes"][1]["children"] = {4};
  b.json["nodes"].push_back({{"children", {3}}});
  EXPECT_THAT(parts({files.write("b.gltf", b.gltf())}), ElementsAre());
  b.json["nodes"][2]["children"] = {4};
  b.json["nodes"][1].erase("children");
  EXPECT_THAT(parts({files.write("c.gltf", b.gltf())}), ElementsAre("hip", "hip", "knee"));
}

TEST_F(PartsTest, NamesSayWhatANumberIs) {
  EXPECT_EQ(part_kind("label"), "label");
  EXPECT_EQ(part_kind("groups"), "group");
  EXPECT_EQ(part_kind("face_segment_ids"), "segment");
  for (const char* other : {"", "s", "_id", "face_", "labels_of_points", "departs"})
    EXPECT_EQ(part_kind(other), "");
}

TEST_F(PartsTest, OtherFormatsDefineNoUnit) {
  EXPECT_EQ(open({files.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")})->info().unit, "");
}

}  // namespace
}  // namespace foldproof::testing
