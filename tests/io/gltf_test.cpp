#include "io/gltf_builder.h"

namespace foldproof::testing {
namespace {

using ::testing::DoubleNear;
using ::testing::Pointwise;

class GltfTest : public GltfIoTest {
 protected:
  void expect_frame(Motion& motion, Index k, const std::vector<double>& expected) {
    SCOPED_TRACE(k);
    EXPECT_THAT(frame(motion, k), Pointwise(DoubleNear(1e-7), expected));
  }

  /// What is said about an animated triangle whose JSON `spoil` has changed.
  std::string error(const std::function<void(Json&)>& spoil) {
    GltfBuilder b;
    Json& primitive = b.triangle();
    primitive["indices"] = b.accessor<std::uint16_t>("SCALAR", {0, 1, 2});
    b.json["nodes"] = {{{"mesh", 0}}};
    const int times = b.floats("SCALAR", {0, 1});
    b.animate(0, "translation", times, b.floats("VEC3", {0, 0, 0, 1, 1, 1}));
    b.gltf();  // fills in the buffers
    spoil(b.json);
    return open_error({files.write("a.gltf", b.json.dump())});
  }

  const std::string again = "; export the file again";
};

TEST_F(GltfTest, ReadsAStillTriangleFromEveryContainer) {
  GltfBuilder b;
  b.triangle();
  b.json["nodes"] = {{{"mesh", 0}}};
  files.write("a%20b.bin", "decoy");
  files.write("a b.bin", b.buffer);
  files.write("parts/c.bin", b.buffer);
  for (const std::string& path :
       {files.write("a.gltf", b.gltf()), files.write("b.glb", b.glb()), files.write("c.gltf", b.glb()),
        files.write("d.gltf", b.gltf_beside("a%20b.bin")),
        files.write("e.gltf", b.gltf_beside("parts/c.bin")),
        files.write("f.gltf", b.gltf_beside("parts/../a b.bin"))}) {
    SCOPED_TRACE(path);
    const auto motion = open({path});
    ASSERT_TRUE(motion);
    EXPECT_EQ(motion->frame_count(), 1u);
    EXPECT_EQ(triangles(*motion), kOneTriangle);
    EXPECT_EQ(frame(*motion, 0), kTrianglePositions);
  }
}

TEST_F(GltfTest, AppliesTheTransformsOfAllAncestors) {
  GltfBuilder b;
  b.triangle();
  const double h = std::sqrt(0.5);
  // The matrix moves by (10, 20, 30) and doubles; below it a quarter turn about z; below that a scale and a
  // shift.
  b.json["nodes"] = {{{"matrix", {2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 10, 20, 30, 1}}, {"children", {1}}},
                     {{"rotation", {0, 0, h, h}}, {"children", {2}}},
                     {{"mesh", 0}, {"scale", {1, 3, 1}}, {"translation", {1, 0, 0}}}};
  const auto motion = gltf(b);
  ASSERT_TRUE(motion);
  // (x,y,z) -> (x+1, 3y, z) -> (-3y, x+1, z) -> (10-6y, 20+2(x+1), 30+2z)
  expect_frame(*motion, 0, {10, 22, 30, 10, 24, 30, 4, 22, 30});
}

TEST_F(GltfTest, ShowsTheDefaultSceneDepthFirstAndEverythingWithoutOne) {
  GltfBuilder b;
  b.triangle();
  b.json["nodes"] = {{{"mesh", 0}, {"translation", {100, 0, 0}}},
                     {{"mesh", 0}, {"translation", {1, 0, 0}}, {"children", {3, 2}}},
                     {{"mesh", 0}, {"translation", {2, 0, 0}}},
                     {{"mesh", 0}, {"translation", {4, 0, 0}}}};
  b.json["scenes"] = {{{"nodes", {0}}}, {{"nodes", {1}}}};
  b.json["scene"] = 1;
  auto motion = gltf(b);
  ASSERT_TRUE(motion);
  EXPECT_EQ(triangles(*motion), (std::vector<Triangle>{{0, 1, 2}, {3, 4, 5}, {6, 7, 8}}));
  const auto x = frame(*motion, 0);
  EXPECT_THAT((std::vector<double>{x[0], x[9], x[18]}), ::testing::ElementsAre(1, 5, 3));
  b.json.erase("scene");
  motion = gltf(b);
  ASSERT_TRUE(motion);
  EXPECT_EQ(motion->topology().vertex_count(), 12u);
}

TEST_F(GltfTest, ReadsListsStripsAndFans) {
  GltfBuilder b;
  const int position = b.floats("VEC3", {0, 0, 0, 1, 0, 0, 2, 0, 0, 3, 0, 0, 4, 0, 0});
  const int bytes = b.accessor<std::uint8_t>("SCALAR", {4, 3, 2, 1, 0});
  const int shorts = b.accessor<std::uint16_t>("SCALAR", {0, 1, 2, 2, 1, 3});
  const int words = b.accessor<std::uint32_t>("SCALAR", {0, 1, 2, 3, 4});
  const Json attributes{{"POSITION", position}};
  b.json["meshes"] = {{{"primitives",
                        {{{"attributes", attributes}, {"indices", shorts}},
                         {{"attributes", attributes}, {"indices", bytes}, {"mode", 5}},
                         {{"attributes", attributes}, {"indices", words}, {"mode", 6}},
                         {{"attributes", attributes}, {"mode", 5}}}}}};
  b.json["nodes"] = {{{"mesh", 0}}};
  const auto motion = gltf(b);
  ASSERT_TRUE(motion);
  EXPECT_EQ(motion->topology().vertex_count(), 5u) << "primitives that name the same positions share them";
  EXPECT_EQ(triangles(*motion), (std::vector<Triangle>{{0, 1, 2},
                                                       {2, 1, 3},  // list
                                                       {4, 3, 2},
                                                       {3, 1, 2},
                                                       {2, 1, 0},  // strip: 4 3 2 1 0
                                                       {1, 2, 0},
                                                       {2, 3, 0},
                                                       {3, 4, 0},  // fan
                                                       {0, 1, 2},
                                                       {1, 3, 2},
                                                       {2, 3, 4}}));  // strip without indices
}

TEST_F(GltfTest, ReadsPointsLinesLoopsAndStrips) {
  GltfBuilder b;
  std::vector<float> positions;
  for (int v = 0; v < 9; ++v) positions.insert(positions.end(), {static_cast<float>(v), 0, 0});
  const Json attributes{{"POSITION", b.floats("VEC3", positions)}};
  const auto indices = [&](std::vector<std::uint16_t> list) { return b.accessor("SCALAR", list); };
  const auto primitive = [&](int mode, std::vector<std::uint16_t> list) {
    return Json{{"attributes", attributes}, {"indices", indices(std::move(list))}, {"mode", mode}};
  };
  b.json["meshes"] = {{{"primitives",
                        {primitive(0, {8, 8, 0}),           // the first one is in no line
                         primitive(3, {5, 4, 3}),           // strip
                         primitive(1, {1, 0, 4, 5, 6, 6}),  // the second repeats; the third is a point
                         primitive(2, {1, 2, 3}),           // loop; 1-2 is a side of the face
                         primitive(4, {0, 1, 2}), primitive(3, {7})}}}};  // a strip of one corner
  b.json["nodes"] = {{{"mesh", 0}}};
  const auto motion = gltf(b);
  ASSERT_TRUE(motion);
  const Topology& topology = motion->topology();
  EXPECT_EQ(topology.face_count(), 1u);
  EXPECT_EQ(topology.line_count(), 4u);
  EXPECT_EQ(triangles(*motion),
            (std::vector<Triangle>{
                {0, 1, 2}, {4, 5, 5}, {3, 4, 4}, {2, 3, 3}, {1, 3, 3}, {8, 8, 8}, {6, 6, 6}, {7, 7, 7}}));
}

TEST_F(GltfTest, ASceneMayHaveLinesOnlyAndLinesMayHaveNoJoints) {
  GltfBuilder b;
  b.triangle()["mode"] = 3;
  b.json["nodes"] = {{{"mesh", 0}, {"skin", 0}}, Json::object()};
  b.json["skins"] = {{{"joints", {1}}}};
  const auto motion = gltf(b);
  ASSERT_TRUE(motion);
  EXPECT_EQ(triangles(*motion), (std::vector<Triangle>{{0, 1, 1}, {1, 2, 2}}));
  EXPECT_EQ(frame(*motion, 0), kTrianglePositions);
}

TEST_F(GltfTest, ReadsInterleavedSparseAndNormalizedNumbers) {
  GltfBuilder b;
  std::string interleaved = "skip";
  for (int v = 0; v < 3; ++v) {
    for (const int x : {32767, v * 32767, -32768})
      interleaved += bytes_of(static_cast<std::int16_t>(x / (v == 2 ? 2 : 1)));
    interleaved += std::string(10, 'n');
  }
  b.view(interleaved.substr(0, interleaved.size() - 10), 16);
  const int which = b.view(std::string("\0\2", 2));
  const int values = b.view(bytes_of<std::int16_t>(0) + bytes_of<std::int16_t>(32767) +
                            bytes_of<std::int16_t>(-32767) + std::string(6, '\0'));
  b.json["accessors"] = {{{"bufferView", 0},
                          {"byteOffset", 4},
                          {"componentType", 5122},
                          {"normalized", true},
                          {"count", 3},
                          {"type", "VEC3"},
                          {"sparse",
                           {{"count", 2},
                            {"indices", {{"bufferView", which}, {"componentType", 5121}}},
                            {"values", {{"bufferView", values}}}}}}};
  b.json["meshes"] = {{{"primitives", {{{"attributes", {{"POSITION", 0}}}}}}}};
  b.json["nodes"] = {{{"mesh", 0}}};
  b.json["extensionsRequired"] = {"KHR_mesh_quantization"};
  const auto motion = gltf(b);
  ASSERT_TRUE(motion);
  expect_frame(*motion, 0, {0, 1, -1, 1, 1, -1, 0, 0, 0});  // -32768 and -32767 are both -1
  for (const int type : {5120, 5122, 5126}) {
    b.json["accessors"][0]["sparse"]["indices"]["componentType"] = type;
    EXPECT_EQ(open_error({files.write("b.gltf", b.gltf())}),
              "b.gltf, accessors[0]: 'sparse' indices are not unsigned integers" + again);
  }
}

TEST_F(GltfTest, SamplesTranslationFromFirstToLastKey) {
  GltfBuilder b;
  b.triangle();
  b.json["nodes"] = {{{"mesh", 0}}};
  const int times = b.floats("SCALAR", {0.5f, 1.0f, 1.25f});
  b.animate(0, "translation", times, b.floats("VEC3", {0, 0, 0, 2, 4, 6, 3, 4, 6}));
  const auto motion = gltf(b, {.fps = 4});
  ASSERT_TRUE(motion);
  ASSERT_EQ(motion->frame_count(), 6u);  // 0, 1/4, ... 5/4 seconds
  const auto shifted = [](double x, double y, double z) {
    std::vector<double> p = kTrianglePositions;
    for (std::size_t i = 0; i < 9; ++i) p[i] += i % 3 == 0 ? x : i % 3 == 1 ? y : z;
    return p;
  };
  expect_frame(*motion, 5, shifted(3, 4, 6));
  expect_frame(*motion, 0, shifted(0, 0, 0));  // before the first key
  expect_frame(*motion, 2, shifted(0, 0, 0));
  expect_frame(*motion, 3, shifted(1, 2, 3));
  expect_frame(*motion, 4, shifted(2, 4, 6));
  const auto coarse = gltf(b, {.fps = 1});
  ASSERT_TRUE(coarse);
  ASSERT_EQ(coarse->frame_count(), 3u) << "the last key is always a frame";
  expect_frame(*coarse, 2, shifted(3, 4, 6));
}

TEST_F(GltfTest, NodesAreShownOnceHoweverOftenASceneListsThem) {
  GltfBuilder b;
  b.triangle();
  b.json["nodes"] = {{{"children", {1}}, {"translation", {1, 0, 0}}},
                     {{"mesh", 0}, {"children", {2}}, {"translation", {1, 0, 0}}},
                     {{"mesh", 0}, {"translation", {1, 0, 0}}}};
  const auto shows = [&](Json listed, const std::vector<double>& moved_by) {
    SCOPED_TRACE(listed.dump());
    b.json["scenes"][0]["nodes"] = std::move(listed);
    const auto motion = gltf(b);
    ASSERT_TRUE(motion);
    std::vector<double> expected;
    for (const double x : moved_by) {
      for (std::size_t i = 0; i < 9; ++i) expected.push_back(kTrianglePositions[i] + (i % 3 == 0 ? x : 0));
    }
    expect_frame(*motion, 0, expected);
  };
  shows({0, 1}, {2, 3});
  shows({1, 0}, {2, 3});
  shows({2, 2, 0, 0, 1}, {2, 3});
  shows({2}, {3});  // where its parents put it
  shows({2, 1}, {2, 3});
}

TEST_F(GltfTest, SplitsAMatrixThatIsAnimated) {
  GltfBuilder b;
  b.triangle();
  // Turns by a quarter about z, doubles x, mirrors z; the animation replaces the translation.
  b.json["nodes"] = {{{"mesh", 0}, {"matrix", {0, 2, 0, 0, -1, 0, 0, 0, 0, 0, -1, 0, 7, 8, 9, 1}}}};
  b.animate(0, "translation", b.floats("SCALAR", {0, 1}), b.floats("VEC3", {0, 0, 0, 1, 1, 1}));
  auto motion = gltf(b, {.fps = 1});
  ASSERT_TRUE(motion);
  expect_frame(*motion, 0, {0, 0, 0, 0, 2, 0, -1, 0, 0});
  expect_frame(*motion, 1, {1, 1, 1, 1, 3, 1, 0, 1, 1});
  const std::string split =
      "1 node has a matrix and is animated, which glTF forbids: it was split into "
      "translation, rotation and scale, as viewers do";
  EXPECT_EQ(motion->info().notes, std::vector<std::string>{split});
  b.json["nodes"][0]["matrix"][4] = -3;  // the second axis is no longer at right angles
  b.json["nodes"][0]["matrix"][5] = 1;
  motion = gltf(b, {.fps = 1});
  ASSERT_TRUE(motion);
  EXPECT_EQ(motion->info().notes, std::vector<std::string>{split + ", which leaves out a shear"});
  // A flat axis.
  b.json["nodes"][0]["matrix"] = {0, 2, 0, 0, -1, 0, 0, 0, 0, 0, 0, 0, 7, 8, 9, 1};
  motion = gltf(b, {.fps = 1});
  ASSERT_TRUE(motion);
  expect_frame(*motion, 0, {0, 0, 0, 0, 2, 0, -1, 0, 0});
}

TEST_F(GltfTest, RotationTakesTheShorterWayAtConstantSpeed) {
  GltfBuilder b;
  b.triangle();
  b.json["nodes"] = {{{"mesh", 0}}};
  const auto h = static_cast<float>(std::sqrt(0.5));
  const int times = b.floats("SCALAR", {0, 1});
  // The second key is a quarter turn about z, written as its negative, which is the same rotation.
  b.animate(0, "rotation", times, b.floats("VEC4", {0, 0, 0, 1, 0, 0, -h, -h}));
  const auto motion = gltf(b, {.fps = 3});
  ASSERT_TRUE(motion);
  ASSERT_EQ(motion->frame_count(), 4u);
  for (Index k = 0; k < 4; ++k) {
    const double angle = k / 3.0 * std::acos(-1) / 2;
    expect_frame(*motion, k,
                 {0, 0, 0, std::cos(angle), std::sin(angle), 0, -std::sin(angle), std::cos(angle), 0});
  }
}

TEST_F(GltfTest, StepHoldsAndSplinesFollowTheirTangents) {
  GltfBuilder b;
  b.triangle();
  b.json["nodes"] = {{{"mesh", 0}}};
  const int times = b.floats("SCALAR", {0, 2});
  b.animate(0, "scale", times, b.floats("VEC3", {1, 1, 1, 5, 5, 5}))["interpolation"] = "STEP";
  // x: value 0 leaving at 1 a second, value 8 arriving at 4 a second. In-tangents of the first key and
  // out-tangents of the last (99) must not matter.
  b.animate(0, "translation", times,
            b.floats("VEC3", {99, 99, 99, 0, 0, 0, 1, 0, 0, 4, 0, 0, 8, 0, 0, 99, 99, 99}))["interpolation"] =
      "CUBICSPLINE";
  b.play_together();
  const auto motion = gltf(b, {.fps = 2});
  ASSERT_TRUE(motion);
  ASSERT_EQ(motion->frame_count(), 5u);
  // Hermite with span 2: at s, x = (s3-2s2+s)*2*1 + (3s2-2s3)*8 + (s3-s2)*2*4.
  const auto x = [](double s) {
    return (s * s * s - 2 * s * s + s) * 2 + (3 * s * s - 2 * s * s * s) * 8 + (s * s * s - s * s) * 8;
  };
  EXPECT_DOUBLE_EQ(x(0.5), 3.25);
  for (Index k = 0; k < 4; ++k)
    expect_frame(*motion, k, {x(k / 4.0), 0, 0, x(k / 4.0) + 1, 0, 0, x(k / 4.0), 1, 0});
  expect_frame(*motion, 4, {8, 0, 0, 13, 0, 0, 8, 5, 0});
}

TEST_F(GltfTest, MorphTargetsAddUp) {
  GltfBuilder b;
  Json& primitive = b.triangle();
  const int dense = b.floats("VEC3", {0, 0, 1, 0, 0, 2, 0, 0, 3});
  const int which = b.view("\1");
  const int values = b.view(bytes_of(10.0f) + bytes_of(20.0f) + bytes_of(30.0f));
  b.json["accessors"].push_back({{"componentType", 5126},
                                 {"count", 3},
                                 {"type", "VEC3"},
                                 {"sparse",
                                  {{"count", 1},
                                   {"indices", {{"bufferView", which}, {"componentType", 5121}}},
                                   {"values", {{"bufferView", values}}}}}});
  primitive["targets"] = {{{"POSITION", dense}}, {{"POSITION", dense + 1}}, {{"NORMAL", dense}}};
  b.json["meshes"][0]["weights"] = {1, 0, 0};
  b.json["nodes"] = {{{"mesh", 0}}};
  auto motion = gltf(b);
  ASSERT_TRUE(motion);
  expect_frame(*motion, 0, {0, 0, 1, 1, 0, 2, 0, 1, 3});
  b.json["nodes"][0]["weights"] = {2, 0.5, 1};  // a node's weights replace its mesh's
  motion = gltf(b);
  ASSERT_TRUE(motion);
  expect_frame(*motion, 0, {0, 0, 2, 6, 10, 19, 0, 1, 6});
  b.animate(0, "weights", b.floats("SCALAR", {0, 1}), b.floats("SCALAR", {0, 0, 0, 1, 1, 1}));
  motion = gltf(b, {.fps = 2});
  ASSERT_TRUE(motion);
  ASSERT_EQ(motion->frame_count(), 3u);
  expect_frame(*motion, 0, kTrianglePositions);
  expect_frame(*motion, 1, {0, 0, 0.5, 6, 10, 16, 0, 1, 1.5});
  expect_frame(*motion, 2, {0, 0, 1, 11, 20, 32, 0, 1, 3});
}

TEST_F(GltfTest, SkinsFollowTheirJoints) {
  GltfBuilder b;
  Json& primitive = b.triangle();
  // Vertex 0 follows joint 0, vertex 1 joint 1, vertex 2 both equally (stored weights sum to 2, in two sets).
  primitive["attributes"]["JOINTS_0"] =
      b.accessor<std::uint8_t>("VEC4", {0, 0, 0, 0, 1, 0, 0, 0, 0, 9, 9, 9});
  primitive["attributes"]["WEIGHTS_0"] = b.floats("VEC4", {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0});
  primitive["attributes"]["JOINTS_1"] =
      b.accessor<std::uint16_t>("VEC4", {0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0});
  primitive["attributes"]["WEIGHTS_1"] =
      b.accessor<std::uint8_t>("VEC4", {0, 0, 0, 0, 0, 0, 0, 0, 0, 255, 0, 0});
  b.json["accessors"].back()["normalized"] = true;
  // Joint 1 stands at (1,0,0) when bound.
  const int bind = b.floats("MAT4", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0,  0, 0, 1,  //
                                     1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -1, 0, 0, 1});
  b.json["skins"] = {{{"joints", {1, 2}}, {"inverseBindMatrices", bind}}};
  b.json["scenes"] = {{{"nodes", {0, 1}}}};
  b.json["nodes"] = {
      {{"mesh", 0}, {"skin", 0}, {"translation", {50, 50, 50}}},  // a skinned mesh ignores its own node
      {{"children", {2}}, {"translation", {0, 0, 5}}},
      {{"translation", {1, 0, 0}}}};
  const auto h = static_cast<float>(std::sqrt(0.5));
  b.animate(2, "rotation", b.floats("SCALAR", {0, 1}), b.floats("VEC4", {0, 0, 0, 1, 0, 0, h, h}));
  const auto motion = gltf(b, {.fps = 1});
  ASSERT_TRUE(motion);
  ASSERT_EQ(motion->frame_count(), 2u);
  expect_frame(*motion, 0, {0, 0, 5, 1, 0, 5, 0, 1, 5});
  // At 1 s joint 1 takes (x,y,z) to (1,0,5) + (-y, x-1, z): (0,1,0) goes to (0,-1,5); joint 0 to (0,1,5).
  expect_frame(*motion, 1, {0, 0, 5, 1, 0, 5, 0, 0, 5});
  EXPECT_EQ(open_error({files.write("b.gltf", b.gltf())}), "no error");

  b.json["skins"][0]["joints"] = {1};
  const auto bad = gltf(b);
  ASSERT_TRUE(bad);
  EXPECT_EQ(frame_error(*bad, 0),
            "a.gltf, frame 0, vertex 1: refers to joint 1, but the skin has 1; export the file again");
}

TEST_F(GltfTest, RefusesNormalizedIndicesAndJoints) {
  EXPECT_EQ(error([](Json& j) { j["accessors"][1]["normalized"] = true; }),
            "a.gltf, meshes[0].primitives[0]: indices are normalized" + again);
  EXPECT_EQ(error([](Json& j) { j["accessors"][1]["normalized"] = false; }), "no error");
  GltfBuilder b;
  Json& attributes = b.triangle()["attributes"];
  attributes["WEIGHTS_0"] = b.floats("VEC4", {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0});
  attributes["JOINTS_0"] = b.accessor<std::uint8_t>("VEC4", {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0});
  b.json["skins"] = {{{"joints", {0, 0}}}};
  b.json["nodes"] = {{{"mesh", 0}, {"skin", 0}}};
  EXPECT_EQ(open_error({files.write("a.gltf", b.gltf())}), "no error");
  b.json["accessors"].back()["normalized"] = true;
  EXPECT_EQ(open_error({files.write("a.gltf", b.gltf())}),
            "a.gltf, meshes[0].primitives[0]: joints are normalized" + again);
}

TEST_F(GltfTest, RefusesPointersToWhatMoves) {
  const auto with_target = [&](const Json& target) {
    return error([&](Json& j) { j["animations"][0]["channels"][0]["target"] = target; });
  };
  const auto with_pointer = [&](const Json& pointer) {
    return with_target(
        {{"path", "pointer"}, {"extensions", {{"KHR_animation_pointer", {{"pointer", pointer}}}}}});
  };
  const std::string refused =
      "a.gltf, animations[0].channels[0]: 'KHR_animation_pointer' is not read; "
      "bake the animation to node transforms";
  EXPECT_EQ(with_pointer("/nodes/0/translation"), refused);
  EXPECT_EQ(with_pointer("/meshes/0/weights/0"), refused);
  EXPECT_EQ(with_pointer(7), refused);
  EXPECT_EQ(with_target({{"path", "pointer"}}), refused);
  EXPECT_EQ(with_target({{"path", "pointer"}, {"node", 0}}), refused);
  EXPECT_EQ(with_target({{"path", "pointer"}, {"extensions", 7}}), refused);
  EXPECT_EQ(with_pointer("/materials/0/emissiveFactor"), "no error") << "it moves nothing";
  EXPECT_EQ(with_target({{"path", "translation"}}), "no error") << "without a node it has no effect";
}

TEST_F(GltfTest, ReportsLocationAndRemedyInTheScene) {
  EXPECT_EQ(error([](Json&) {}), "no error");
  EXPECT_EQ(error([](Json& j) { j["asset"]["version"] = "1.0"; }), "a.gltf: is not glTF 2; export glTF 2.0");
  EXPECT_EQ(error([](Json& j) { j["nodes"][0]["mesh"] = 1; }),
            "a.gltf, nodes[0]: refers to meshes[1], but there are 1" + again);
  EXPECT_EQ(error([](Json& j) { j["nodes"][0]["mesh"] = -1; }),
            "a.gltf, nodes[0]: refers to meshes[-1], but there are 1" + again);
  EXPECT_EQ(error([](Json& j) { j["nodes"][0]["children"] = {0}; }),
            "a.gltf, nodes: a node is its own ancestor" + again);
  EXPECT_EQ(error([](Json& j) {
              j["nodes"].push_back({{"children", {0, 0}}});
            }),
            "a.gltf, nodes[1]: nodes[0] has two parents" + again);
  EXPECT_EQ(error([](Json& j) {
              j["nodes"][0]["scale"] = {1, 2};
            }),
            "a.gltf, nodes[0]: 'scale' is not a list of 3 numbers" + again);
  EXPECT_EQ(error([](Json& j) { j["scene"] = 4; }),
            "a.gltf, file: refers to scenes[4], but there are 1" + again);
  EXPECT_EQ(error([](Json& j) { j["scenes"][0]["nodes"] = Json::array(); }),
            "a.gltf: shows no triangles, lines or points; export a scene with meshes");
}

TEST_F(GltfTest, NamesPlaceAndMendInBuffers) {
  EXPECT_EQ(error([](Json& j) { j["accessors"][0]["count"] = 4; }),
            "a.gltf, accessors[0]: needs 48 bytes from byte 0, but bufferViews[0] has 36" + again);
  EXPECT_EQ(
      error([](Json& j) { j["accessors"][0]["byteOffset"] = 1099511627775; }),
      "a.gltf, accessors[0]: needs 36 bytes from byte 1099511627775, but bufferViews[0] has 36" + again);
  EXPECT_EQ(error([](Json& j) { j["accessors"][0]["count"] = 18446744073709551615u; }),
            "a.gltf, accessors[0]: 'count' is not a number from 0 to 1099511627775" + again);
  EXPECT_EQ(error([](Json& j) {
              j["accessors"][0].erase("bufferView");
              j["accessors"][0]["count"] = 1099511627775;
            }),
            "a.gltf, meshes[0].primitives[0]: positions are not in a buffer" + again);
  EXPECT_EQ(
      error([](Json& j) { j["accessors"][0]["type"] = "VEC4"; }),
      "a.gltf, accessors[0]: is not of a type that meshes[0].primitives[0] may have; VEC3 is needed" + again);
  EXPECT_EQ(
      error([](Json& j) { j["accessors"][0]["componentType"] = 5130; }),
      "a.gltf, accessors[0]: is not of a type that meshes[0].primitives[0] may have; VEC3 is needed" + again);
  EXPECT_EQ(error([](Json& j) { j["bufferViews"][0]["byteStride"] = 8; }),
            "a.gltf, accessors[0]: has an unknown component type or stride" + again);
  EXPECT_EQ(error([](Json& j) { j["bufferViews"][0]["byteLength"] = 4000; }),
            "a.gltf, bufferViews[0]: needs bytes 0 to 4000, but buffers[0] has 76" + again);
  EXPECT_EQ(
      error([](Json& j) { j["buffers"][0]["byteLength"] = 1000000000000; }),
      "a.gltf, buffers[0]: announces 1000000000000 bytes, but there are 76; copy or export the file again");
  EXPECT_EQ(error([](Json& j) { j["buffers"][0].erase("uri"); }),
            "a.gltf, buffers[0]: has neither a uri nor a binary chunk" + again);
  EXPECT_EQ(error([](Json& j) { j["buffers"][0]["uri"] = "data:text/plain,hello"; }),
            "a.gltf, buffers[0]: embedded data is not base64" + again);
  EXPECT_EQ(error([](Json& j) { j["buffers"][0]["uri"] = "data:;base64,A*=="; }),
            "a.gltf, buffers[0]: embedded data is not base64" + again);
}

TEST_F(GltfTest, NamesPlaceAndMendInMeshesAndAnimations) {
  EXPECT_EQ(error([](Json& j) { j["meshes"][0]["primitives"][0]["mode"] = 7; }),
            "a.gltf, meshes[0].primitives[0]: 'mode' is not known" + again);
  EXPECT_EQ(error([](Json& j) {
              j["meshes"][0]["primitives"][0]["attributes"] = {{"NORMAL", 0}};
            }),
            "a.gltf, meshes[0].primitives[0]: has no positions" + again);
  EXPECT_EQ(error([](Json& j) { j["accessors"][1]["count"] = 2; }),
            "a.gltf, meshes[0].primitives[0]: has 2 corners, which are not whole triangles" + again);
  EXPECT_EQ(error([](Json& j) { j["bufferViews"][1]["byteOffset"] = 28; }),
            "a.gltf, meshes[0].primitives[0]: triangle 0 refers to vertex 16256, but there are 3 (counting "
            "from 0)" +
                again);
  EXPECT_EQ(error([](Json& j) { j["animations"][0]["samplers"][0]["interpolation"] = "BEZIER"; }),
            "a.gltf, animations[0].channels[0]: its path or interpolation is not known" + again);
  EXPECT_EQ(error([](Json& j) { j["animations"][0]["channels"][0]["sampler"] = 1; }),
            "a.gltf, animations[0].channels[0]: has no target, or a sampler that does not exist" + again);
  EXPECT_EQ(error([](Json& j) { j["accessors"][2]["count"] = 1; }),
            "a.gltf, animations[0].channels[0]: has 1 times for 2 values" + again);
  EXPECT_EQ(error([](Json& j) { j["bufferViews"][2]["byteOffset"] = 0; }),
            "a.gltf, accessors[2]: time 1 of an animation is not finite, negative or not ascending" + again);
}

TEST_F(GltfTest, NamesPlaceAndMendOfTheWholeFile) {
  EXPECT_EQ(error([](Json& j) {
              j["extensionsRequired"] = {"KHR_materials_unlit", "KHR_draco_mesh_compression"};
            }),
            "a.gltf, extensionsRequired: 'KHR_draco_mesh_compression' is not read; export without it");
  EXPECT_EQ(open_error({files.write("a.gltf", "{\"asset\": }")}),
            "a.gltf, byte 11: is not valid JSON here" + again);
  EXPECT_EQ(open_error({files.write("a.gltf", "{\"asset\": 1e999}")}),
            "a.gltf: has a JSON number that is too large" + again);
}

TEST_F(GltfTest, ReadsBuffersBesideTheFileOnly) {
  GltfBuilder b;
  b.triangle();
  b.json["nodes"] = {{{"mesh", 0}}};
  const std::string secret = files.write("secret.bin", b.buffer);
  std::filesystem::create_directory(files.path("inner"));
  std::vector<std::string> elsewhere{
      "../secret.bin", "%2e%2e/secret.bin", secret, "file://" + secret, ".", "",
      "a%00b",         "x/../../secret.bin"};
  std::error_code no_links;
  std::filesystem::create_symlink(secret, files.path("inner/link.bin"), no_links);
  if (!no_links) elsewhere.emplace_back("link.bin");
  for (const std::string& uri : elsewhere) {
    EXPECT_THAT(
        open_error({files.write("inner/a.gltf", b.gltf_beside(uri))}),
        ::testing::AllOf(
            ::testing::StartsWith("inner/a.gltf, buffers[0]: '"),
            ::testing::EndsWith("' is not a file beside this one; put the buffer beside it, or export GLB")))
        << uri;
  }
  EXPECT_EQ(open_error({files.write("inner/a.gltf", b.gltf_beside("none.bin"))}),
            "inner/a.gltf, buffers[0]: buffer 'none.bin' does not exist; check the name");
}

TEST_F(GltfTest, NamesWhatIsWrongWithAGlb) {
  GltfBuilder b;
  b.triangle();
  b.json["nodes"] = {{{"mesh", 0}}};
  const std::string good = b.glb(), again = "; copy or export the file again";
  const auto error = [&](std::size_t at, std::uint32_t word) {
    std::string bytes = good;
    bytes.replace(at, 4, bytes_of(word));
    return open_error({files.write("a.glb", bytes)});
  };
  EXPECT_EQ(error(4, 1), "a.glb, byte 4: GLB version 1 is not read; export glTF 2.0");
  const std::string size = std::to_string(good.size());
  EXPECT_EQ(error(8, 7), "a.glb, byte 8: header announces 7 bytes, but the file has " + size + again);
  EXPECT_EQ(error(12, 0xffffffff), "a.glb, byte 12: a chunk reaches beyond the end of the file" + again);
  EXPECT_EQ(error(16, 0), "a.glb, byte 20: the first chunk is not JSON" + again);
  EXPECT_EQ(open_error({files.write("a.glb", "glTF\2")}), "a.glb: is too short for a GLB header" + again);
}

TEST_F(GltfTest, RefusesRatesAndLengthsThatAreNoMotion) {
  GltfBuilder b;
  b.triangle();
  b.json["nodes"] = {{{"mesh", 0}}};
  const std::string still = files.write("a.gltf", b.gltf());
  for (const double fps :
       {0.0, -1.0, std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_THAT(open_error({still}, {.fps = fps}),
                ::testing::AllOf(::testing::StartsWith("--fps: "),
                                 ::testing::EndsWith(" is not a sampling rate; give a number above zero")));
  }
  b.animate(0, "translation", b.floats("SCALAR", {0, 1e30f}), b.floats("VEC3", {0, 0, 0, 1, 1, 1}));
  EXPECT_THAT(open_error({files.write("b.gltf", b.gltf())}),
              ::testing::EndsWith("seconds at 24 frames a second are too many frames; choose a lower --fps"));
}

TEST_F(GltfTest, NamesFrameAndVertexThatIsNotFinite) {
  GltfBuilder b;
  b.triangle();
  b.json["nodes"] = {{{"mesh", 0}}};
  const float infinity = std::numeric_limits<float>::infinity();
  b.animate(0, "scale", b.floats("SCALAR", {0, 1, 2}), b.floats("VEC3", {1, 1, 1, 1, 1, 1, 1, infinity, 1}));
  const auto motion = gltf(b, {.fps = 1});
  ASSERT_TRUE(motion);
  EXPECT_EQ(frame_error(*motion, 0), "no error");
  EXPECT_THAT(
      frame_error(*motion, 2),
      ::testing::AllOf(::testing::StartsWith("a.gltf, frame 2, vertex "),
                       ::testing::EndsWith(": a coordinate is not finite; export the mesh without NaN or "
                                           "infinite coordinates")));
}

}  // namespace
}  // namespace foldproof::testing
