// Files on which a careless reader takes more than linear time or memory. They are so large that quadratic
// time exceeds the time limit of the tests.
#include <fmt/format.h>

#include "io/gltf_builder.h"
#include "io/memory_limit.h"

namespace foldproof::testing {
namespace {

class LinearTest : public GltfIoTest {};

std::string repeated(std::string_view text, std::size_t times) {
  std::string all;
  for (std::size_t i = 0; i < times; ++i) all += text;
  return all;
}

TEST_F(LinearTest, PolygonsOfManyCorners) {
  const auto obj =
      open({files.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf " + repeated("1 2 3 ", 300'000))});
  ASSERT_TRUE(obj);
  EXPECT_EQ(obj->topology().triangles().size(), 899'998u);
  EXPECT_EQ(obj->topology().edges().size(), 3u);
  const auto off =
      open({files.write("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n900000 " + repeated("0 1 2 ", 300'000))});
  ASSERT_TRUE(off);
  EXPECT_EQ(off->topology().triangles().size(), 899'998u);
}

// All edges at one vertex.
TEST_F(LinearTest, AVertexWithManyEdges) {
  std::string text = "v 0 0 0\n";
  for (int i = 0; i < 500'000; ++i) text += fmt::format("v {} 1 0\n", i);
  text += "f";
  for (int i = 1; i <= 500'001; ++i) text += fmt::format(" {}", i);
  const auto motion = open({files.write("a.obj", text)});
  ASSERT_TRUE(motion);
  EXPECT_EQ(motion->topology().edges().size(), 999'999u);
}

TEST_F(LinearTest, ObjLinesOfOneWordAndMixedFaces) {
  std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  text += repeated("f 1 2 3\nf 1 2 3 1\n", 300'000) + repeated("\\\n", 500'000) + repeated("#\n", 500'000);
  const auto motion = open({files.write("a.obj", text)});
  ASSERT_TRUE(motion);
  EXPECT_EQ(motion->topology().triangles().size(), 900'000u);
}

TEST_F(LinearTest, ManyLinesAndPoints) {
  std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  for (int i = 0; i < 300'000; ++i) text += fmt::format("v {} 1 0\nl -1 1 -1\nl 1 -1 -2\np -1 -2\n", i);
  const auto motion = open({files.write("a.obj", text + repeated("f 1 2 3\nf 1 2 4\n", 300'000))});
  ASSERT_TRUE(motion);
  EXPECT_EQ(motion->topology().face_count(), 600'000u);
}

TEST_F(LinearTest, ObjStatementsThatAreNotKnown) {
  std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  for (int i = 0; i < 1'000'000; ++i) text += fmt::format("a{}\n", i);
  EXPECT_TRUE(open({files.write("a.obj", text)}));
}

TEST_F(LinearTest, SectionsOfGmshThatDoNotEnd) {
  const std::string head = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n";
  EXPECT_THAT(open_error({files.write("a.msh", head + "$A\n" + repeated("$EndAA", 1'000'000))}),
              ::testing::HasSubstr("the file ends within $A;"));
  EXPECT_THAT(open_error({files.write(
                  "a.msh", head + "$" + repeated("$End", 500'000) + "\n" + repeated("$End", 500'000))}),
              ::testing::HasSubstr("the name of a section is too long"));
}

// Comparing each name with all before takes 10^12 steps.
TEST_F(LinearTest, PlyElementsAndProperties) {
  const std::string vertices = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
  const std::string faces = "element face 1\nproperty list uchar int vertex_index\n";
  const std::string body = "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
  std::string elements, properties;
  for (int i = 0; i < 1'000'000; ++i) elements += fmt::format("element e{} 0\n", i);
  for (int i = 0; i < 1'000'000; ++i) properties += fmt::format("property list uchar int p{}\n", i);
  for (const std::string& more : {elements, "element more 0\n" + properties}) {
    const auto motion =
        open({files.write("a.ply", "ply\nformat ascii 1.0\n" + vertices + faces + more + body)});
    ASSERT_TRUE(motion);
    EXPECT_EQ(triangles(*motion), kOneTriangle);
  }
  EXPECT_EQ(open_error({files.write("b.ply", "ply\nformat ascii 1.0\n" + vertices + faces + elements +
                                                 "element e17 0\n" + body)}),
            "b.ply:1000009: element 'e17' is declared twice; export the mesh as PLY again");
}

TEST_F(LinearTest, CsvOfManyColumnsAndOfManyFrames) {
  std::string wide = "a";
  for (int i = 0; i < 300'000; ++i) wide += fmt::format(",a{}", i);
  wide += "\n1" + repeated(",1", 300'000);
  const auto columns = read_csv(files.write("wide.csv", wide));
  ASSERT_TRUE(columns);
  EXPECT_EQ(columns->shape, (std::vector<std::uint64_t>{1, 300'001}));
  const auto rows = read_csv(files.write("long.csv", repeated("#\n\n1,2,3\n", 300'000)));
  ASSERT_TRUE(rows);
  EXPECT_EQ(rows->shape, (std::vector<std::uint64_t>{300'000, 3}));
}

TEST_F(LinearTest, WeldedVerticesAtOnePosition) {
  std::string text = repeated("v 1 2 3\n", 300'000) + "v 1 0 0\nv 0 1 0\n";
  for (int i = 1; i <= 300'000; ++i) text += fmt::format("f {} 300001 300002\n", i);
  const auto motion = open({files.write("a.obj", text)}, {.weld = Weld::Always});
  ASSERT_TRUE(motion);
  EXPECT_EQ(motion->topology().edges().size(), 3u);
}

TEST_F(LinearTest, GltfBuffersThatAreOneFile) {
  GltfBuilder b;
  b.triangle();
  b.json["nodes"] = {{{"mesh", 0}}};
  files.write("a.bin", b.buffer + std::string(1 << 20, '\0'));
  for (int i = 0; i < 2000; ++i) {  // 2 GB of copies
    b.json["buffers"].push_back({{"byteLength", b.buffer.size()}, {"uri", i % 2 ? "a.bin" : "./a.bin"}});
  }
  const std::string path = files.write("a.gltf", b.json.dump());
  const MemoryLimit limit(500'000'000);
  if (!limit.holds()) GTEST_SKIP() << "nothing limits memory here";
  const auto motion = open({path});
  ASSERT_TRUE(motion);
  EXPECT_EQ(frame(*motion, 0), kTrianglePositions);
}

// One list of replaced positions, which every primitive names.
TEST_F(LinearTest, GltfPrimitivesThatShareASparseAccessor) {
  GltfBuilder b;
  constexpr std::size_t kVertices = 300'000;
  std::vector<std::uint32_t> which(kVertices);
  for (std::size_t i = 0; i < kVertices; ++i) which[i] = static_cast<std::uint32_t>(i);
  const int base = b.floats("VEC3", std::vector<float>(3 * kVertices, 0));
  b.json["accessors"][base]["sparse"] = {
      {"count", kVertices},
      {"indices",
       {{"bufferView", b.json["accessors"][b.accessor("SCALAR", which)]["bufferView"]},
        {"componentType", 5125}}},
      {"values",
       {{"bufferView",
         b.json["accessors"][b.floats("VEC3", std::vector<float>(3 * kVertices, 1))]["bufferView"]}}}};
  const int indices = b.accessor<std::uint8_t>("SCALAR", {0, 1, 2});
  // None but the first is shown.
  for (int mesh = 0; mesh < 30'000; ++mesh) {
    b.json["meshes"].push_back(
        {{"primitives", {{{"attributes", {{"POSITION", base}}}, {"indices", indices}}}}});
  }
  b.json["nodes"] = {{{"mesh", 0}}};
  const auto motion = gltf(b);
  ASSERT_TRUE(motion);
  EXPECT_EQ(motion->topology().triangles().size(), 1u);
}

// Each node needs the joints of the skin that all share.
TEST_F(LinearTest, GltfNodesThatShareASkin) {
  GltfBuilder b;
  Json& primitive = b.triangle();
  primitive["attributes"]["JOINTS_0"] = b.accessor<std::uint8_t>("VEC4", std::vector<std::uint8_t>(12, 0));
  primitive["attributes"]["WEIGHTS_0"] = b.floats("VEC4", {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0});
  constexpr int kMany = 200'000;
  b.json["nodes"] = std::vector<Json>(kMany, {{"mesh", 0}, {"skin", 0}});
  b.json["skins"] = {{{"joints", std::vector<int>(kMany, 1)}}};
  b.json.erase("scene");
  const auto motion = gltf(b);
  ASSERT_TRUE(motion);
  const auto x = frame(*motion, 0);
  ASSERT_EQ(x.size(), std::size_t{9} * kMany);
  EXPECT_TRUE(std::equal(kTrianglePositions.begin(), kTrianglePositions.end(), x.end() - 9));
}

// Primitives without corners are processed for every node, too.
TEST_F(LinearTest, GltfNodesThatShareManyEmptyPrimitives) {
  GltfBuilder b;
  Json primitive = b.triangle();
  primitive["indices"] = b.accessor<std::uint8_t>("SCALAR", {0, 1, 2});
  Json empty = primitive;
  empty["indices"] = b.accessor<std::uint8_t>("SCALAR", {0, 1, 2});
  b.json["accessors"].back()["count"] = 0;
  std::vector<Json> primitives(100'000, empty);
  primitives.push_back(primitive);
  b.json["meshes"][0]["primitives"] = primitives;
  b.json["nodes"] = std::vector<Json>(100'000, {{"mesh", 0}});
  b.json.erase("scene");
  EXPECT_EQ(open_error({files.write("a.gltf", b.gltf())}),
            "a.gltf: shows more than 134217728 vertices or corners of triangles; export fewer copies of its "
            "meshes");
}

// Accessors that share bytes: a small file with many values.
TEST_F(LinearTest, GltfAccessorsThatShareBytes) {
  GltfBuilder b;
  b.triangle();
  b.json["nodes"] = {{{"mesh", 0}}};
  constexpr std::size_t kTimes = 100'000;
  std::vector<float> seconds(kTimes);
  for (std::size_t i = 0; i < kTimes; ++i) seconds[i] = static_cast<float>(i) / 1024;
  const int times = b.floats("SCALAR", seconds), values = b.floats("VEC3", std::vector<float>(3 * kTimes, 1));
  const Json same_times = b.json["accessors"][times];
  Json samplers = Json::array(), channels = Json::array();
  for (int i = 0; i < 20'000; ++i) {
    const auto accessor = b.json["accessors"].size();
    b.json["accessors"].push_back(same_times);
    samplers.push_back({{"input", accessor}, {"output", values}});
    channels.push_back({{"sampler", i}, {"target", {{"node", 0}, {"path", "translation"}}}});
  }
  b.json["animations"] = {{{"samplers", samplers}, {"channels", channels}}};
  EXPECT_THAT(open_error({files.write("a.gltf", b.gltf())}),
              ::testing::HasSubstr("with it, more than 134217728 indices and times are named"));
}

TEST_F(LinearTest, GltfMorphTargetsThatShareBytes) {
  GltfBuilder b;
  constexpr std::size_t kVertices = 100'000, kTargets = 100'000;
  const int positions = b.floats("VEC3", std::vector<float>(3 * kVertices, 0));
  const Json primitive = {{"attributes", {{"POSITION", positions}}},
                          {"indices", b.accessor<std::uint8_t>("SCALAR", {0, 1, 2})},
                          {"targets", std::vector<Json>(kTargets, {{"POSITION", positions}})}};
  b.json["meshes"] = {{{"primitives", {primitive}}, {"weights", std::vector<int>(kTargets, 1)}}};
  b.json["nodes"] = {{{"mesh", 0}}};
  EXPECT_THAT(open_error({files.write("a.gltf", b.gltf())}), ::testing::HasSubstr("morph targets"));
}

// Animated weights of nodes that nothing shows.
TEST_F(LinearTest, GltfMorphWeightsOfManyNodes) {
  GltfBuilder b;
  constexpr std::size_t kTargets = 10'000, kNodes = 10'000;
  b.triangle()["targets"] = std::vector<Json>(kTargets, Json::object());
  b.json["nodes"] = std::vector<Json>(kNodes, {{"mesh", 0}});
  const int times = b.floats("SCALAR", {0});
  const auto values = b.json["accessors"].size();
  b.json["accessors"].push_back({{"componentType", 5126}, {"count", kTargets}, {"type", "SCALAR"}});
  Json channels = Json::array();
  for (std::size_t i = 0; i < kNodes; ++i)
    channels.push_back({{"sampler", 0}, {"target", {{"node", i}, {"path", "weights"}}}});
  b.json["animations"] = {{{"samplers", {{{"input", times}, {"output", values}}}}, {"channels", channels}}};
  EXPECT_THAT(open_error({files.write("a.gltf", b.gltf())}),
              ::testing::HasSubstr("animates more than 67108864 weights of morph targets"));
}

// A skin of many joints, which many primitives share.
TEST_F(LinearTest, GltfJointsOfManyPrimitives) {
  GltfBuilder b;
  Json& triangle = b.triangle();
  triangle["attributes"]["JOINTS_0"] = b.accessor<std::uint8_t>("VEC4", std::vector<std::uint8_t>(12, 0));
  triangle["attributes"]["WEIGHTS_0"] = b.floats("VEC4", std::vector<float>(12, 0.25f));
  const Json one = triangle;
  b.json["meshes"][0]["primitives"] = std::vector<Json>(100'000, one);
  b.json["nodes"] = {{{"mesh", 0}, {"skin", 0}}, {{"name", "joint"}}};
  b.json["skins"] = {{{"joints", std::vector<int>(1'000'000, 1)}}};
  const auto motion = gltf(b);
  ASSERT_TRUE(motion);
  EXPECT_EQ(motion->topology().triangles().size(), 100'000u);
}

// One long animation among many short ones, whose durations must not be recomputed for every comparison.
TEST_F(LinearTest, GltfAnimationsOfManyChannels) {
  GltfBuilder b;
  b.triangle();
  b.json["nodes"] = {{{"mesh", 0}}};
  const int times = b.floats("SCALAR", {0, 0.01f}), values = b.floats("VEC3", {0, 0, 0, 0, 0, 0});
  const Json sampler = {{"input", times}, {"output", values}};
  const Json channel = {{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}};
  const Json one = {{"samplers", {sampler}}, {"channels", {channel}}};
  Json many = one;
  many["channels"] = std::vector<Json>(100'000, channel);
  b.json["animations"] = std::vector<Json>(100'000, one);
  b.json["animations"][50'000] = many;
  const auto motion = gltf(b);
  ASSERT_TRUE(motion);
  EXPECT_EQ(motion->frame_count(), 2u);
}

TEST_F(LinearTest, GltfThatIsNestedDeeply) {
  GltfBuilder b;
  b.triangle();
  b.json["nodes"] = {{{"mesh", 0}}};
  constexpr std::size_t kDeep = 1'000'000;
  std::string text = b.gltf();
  text.insert(1, "\"extras\":" + std::string(kDeep, '[') + std::string(kDeep, ']') + ",");
  const auto motion = open({files.write("a.gltf", text)});
  ASSERT_TRUE(motion);
  EXPECT_EQ(frame(*motion, 0), kTrianglePositions);
  EXPECT_THAT(open_error({files.write("b.gltf", std::string(kDeep, '['))}),
              ::testing::HasSubstr("is not valid JSON here"));
  // Where an animation names what it drives.
  text = b.gltf();
  const std::string pointer = R"({"path":"pointer","extensions":{"KHR_animation_pointer":{"pointer":)" +
                              std::string(kDeep, '[') + std::string(kDeep, ']') + "}}}";
  text.insert(1, R"("animations":[{"samplers":[{}],"channels":[{"sampler":0,"target":)" + pointer + "}]}],");
  EXPECT_THAT(open_error({files.write("d.gltf", text)}),
              ::testing::HasSubstr("'KHR_animation_pointer' is not read"));
  // A chain of nodes.
  b.json["nodes"] = Json::array();
  for (std::size_t i = 0; i < 200'000; ++i) b.json["nodes"].push_back({{"children", {i + 1}}});
  b.json["nodes"].push_back({{"mesh", 0}});
  EXPECT_TRUE(open({files.write("c.gltf", b.gltf())}));
}

}  // namespace
}  // namespace foldproof::testing
