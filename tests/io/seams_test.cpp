// Vertices that become one: by the format in glTF, by place with Weld::Always; layers of one surface.
#include <bit>
#include <random>

#include "io/gltf_builder.h"
#include "io/npz_builder.h"

namespace foldproof::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class SeamsTest : public GltfIoTest {
 protected:
  static std::vector<Index> merged(const Motion& motion) { return motion.info().merged; }
  static std::vector<std::string> notes(const Motion& motion) { return motion.info().notes; }
};

const std::vector<float> kTwoTriangles{0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};

/// A square as two triangles with vertices of their own: 1 and 3, and 2 and 5, are at one place.
GltfBuilder square() {
  GltfBuilder b;
  const int position = b.floats("VEC3", kTwoTriangles);
  b.json["meshes"] = {{{"primitives", {{{"attributes", {{"POSITION", position}}}}}}}};
  b.json["nodes"] = {{{"mesh", 0}}};
  return b;
}

TEST_F(SeamsTest, OfAMeshAreOneVertex) {
  GltfBuilder b = square();
  const auto motion = gltf(b);
  ASSERT_TRUE(motion);
  EXPECT_EQ(motion->topology().vertex_count(), 6u) << "vertices keep their numbers";
  EXPECT_EQ(triangles(*motion), (std::vector<Triangle>{{0, 1, 2}, {1, 4, 2}}));
  EXPECT_THAT(merged(*motion), ElementsAre(0, 1, 2, 1, 4, 2));
  EXPECT_EQ(frame(*motion, 0), std::vector<double>(kTwoTriangles.begin(), kTwoTriangles.end()));
  EXPECT_THAT(notes(*motion), ElementsAre("2 of 6 vertices lie on seams and were merged; what meets there "
                                          "counts as neighbors"));
}

TEST_F(SeamsTest, StayOnRequest) {
  GltfBuilder b = square();
  const auto motion = gltf(b, {.weld = Weld::Never});
  ASSERT_TRUE(motion);
  EXPECT_EQ(triangles(*motion), (std::vector<Triangle>{{0, 1, 2}, {3, 4, 5}}));
  EXPECT_THAT(merged(*motion), IsEmpty());
  EXPECT_THAT(notes(*motion), IsEmpty());
  EXPECT_FALSE(motion->info().layered);
}

TEST_F(SeamsTest, AreOneAlsoBetweenPrimitivesButNotBetweenNodes) {
  GltfBuilder b;
  const int one = b.floats("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0});
  const int other = b.floats("VEC3", {1, 0, 0, 1, 1, 0, 0, 1, 0});
  b.json["meshes"] = {
      {{"primitives", {{{"attributes", {{"POSITION", one}}}}, {{"attributes", {{"POSITION", other}}}}}}}};
  b.json["nodes"] = {{{"mesh", 0}}, {{"mesh", 0}}};
  b.json["scenes"] = {{{"nodes", {0, 1}}}};
  const auto motion = gltf(b);
  ASSERT_TRUE(motion);
  EXPECT_EQ(triangles(*motion), (std::vector<Triangle>{{0, 1, 2}, {1, 4, 2}, {6, 7, 8}, {7, 10, 8}}));
}

TEST_F(SeamsTest, AreNotWhereSomethingMovesThemApart) {
  const auto merged_with = [&](const std::function<void(GltfBuilder&, Json&)>& add) {
    GltfBuilder b = square();
    b.json["nodes"] = {{{"mesh", 0}, {"skin", 0}}, Json::object(), Json::object()};
    b.json["skins"] = {{{"joints", {1, 2}}}};
    Json& primitive = b.json["meshes"][0]["primitives"][0];
    primitive["attributes"]["JOINTS_0"] =
        b.accessor<std::uint8_t>("VEC4", {0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0,  //
                                          0, 1, 1, 1, 0, 1, 0, 0, 0, 1, 0, 0});
    primitive["attributes"]["WEIGHTS_0"] = b.floats("VEC4", {1,  0,  0, 0, .5, .5, 0, 0, .5, .5, 0, 0,  //
                                                             .5, .5, 0, 0, 1,  0,  0, 0, .5, .5, 0, 0});
    add(b, primitive);
    const auto motion = gltf(b);
    return motion ? merged(*motion) : std::vector<Index>{99};
  };
  EXPECT_THAT(merged_with([](GltfBuilder&, Json&) {}), ElementsAre(0, 1, 2, 1, 4, 2))
      << "joints without a weight do not count";
  EXPECT_THAT(merged_with([](GltfBuilder& b, Json& p) {
                p["attributes"]["WEIGHTS_0"] =
                    b.floats("VEC4", {1,  0,   0, 0, .5, .5, 0, 0, .5, .5, 0, 0,  //
                                      .5, .25, 0, 0, 1,  0,  0, 0, .5, .5, 0, 0});
              }),
              ElementsAre(0, 1, 2, 3, 4, 2));
  EXPECT_THAT(merged_with([](GltfBuilder& b, Json& p) {
                p["attributes"]["JOINTS_0"] =
                    b.accessor<std::uint8_t>("VEC4", {0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0,  //
                                                      0, 1, 1, 1, 0, 1, 0, 0, 1, 1, 0, 0});
              }),
              ElementsAre(0, 1, 2, 1, 4, 5));
  EXPECT_THAT(merged_with([](GltfBuilder& b, Json& p) {
                p["targets"] = {{{"POSITION", b.floats("VEC3", std::vector<float>(18, 0))}},
                                {{"POSITION", b.floats("VEC3", {0, 0, 0, 0, 0, 1, 0, 0, 0,  //
                                                                0, 0, 2, 0, 0, 0, 0, 0, 0})}}};
              }),
              ElementsAre(0, 1, 2, 3, 4, 2));
}

// What is compared decides where a vertex is, so it is there for all of them, to the last bit.
TEST_F(SeamsTest, StayAtOnePlaceInEveryFrame) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> number(-3, 3);
  // 40 vertices, each twice, in an order of chance; zeros of both signs.
  constexpr std::size_t kKinds = 40;
  std::vector<std::size_t> kind;
  for (std::size_t i = 0; i < 2 * kKinds; ++i) kind.push_back(i % kKinds);
  std::ranges::shuffle(kind, random);
  const auto of_kinds = [&](std::size_t width, const std::function<float()>& draw) {
    std::vector<float> kinds(kKinds * width), all;
    for (float& x : kinds) x = draw();
    for (const std::size_t k : kind) {
      for (std::size_t c = 0; c < width; ++c) {
        const float x = kinds[k * width + c];
        all.push_back(x == 0 && random() % 2 == 0 ? -x : x);
      }
    }
    return all;
  };
  const auto some_zero = [&] { return random() % 4 == 0 ? 0 : number(random); };
  GltfBuilder b;
  std::vector<std::uint8_t> joints;
  for (const float j : of_kinds(4, [&] { return static_cast<float>(random() % 3); }))
    joints.push_back(static_cast<std::uint8_t>(j));
  Json primitive = {{"attributes",
                     {{"POSITION", b.floats("VEC3", of_kinds(3, some_zero))},
                      {"JOINTS_0", b.accessor("VEC4", joints)},
                      {"WEIGHTS_0", b.floats("VEC4", of_kinds(4, [&] { return std::abs(some_zero()); }))}}},
                    {"mode", 5},
                    {"targets",
                     {{{"POSITION", b.floats("VEC3", of_kinds(3, some_zero))}},
                      {{"POSITION", b.floats("VEC3", of_kinds(3, some_zero))}}}}};
  b.json["meshes"] = {{{"primitives", {primitive}}}};
  b.json["skins"] = {{{"joints", {1, 2, 3}}}};
  b.json["nodes"] = {{{"mesh", 0}, {"skin", 0}}, Json::object(), Json::object(), Json::object()};
  const int times = b.floats("SCALAR", {0, 1});
  for (int joint = 1; joint <= 3; ++joint) {
    b.animate(joint, "translation", times, b.floats("VEC3", {0, 0, 0, number(random), 1, 2}));
    b.animate(joint, "rotation", times, b.floats("VEC4", {0, 0, 0, 1, number(random), .5, 0, 1}));
  }
  b.animate(0, "weights", times, b.floats("SCALAR", {0, .3f, 1, -2}));
  const auto motion = gltf(b);
  ASSERT_TRUE(motion);
  ASSERT_EQ(motion->frame_count(), 25u);
  const std::vector<Index> first = merged(*motion);
  ASSERT_EQ(first.size(), 2 * kKinds);
  for (std::size_t v = 0; v < first.size(); ++v)
    ASSERT_EQ(first[v], static_cast<Index>(std::ranges::find(kind, kind[v]) - kind.begin()));
  for (Index k = 0; k < motion->frame_count(); ++k) {
    const auto x = frame(*motion, k);
    for (std::size_t v = 0; v < first.size(); ++v) {
      for (std::size_t c = 0; c < 3; ++c) {
        ASSERT_EQ(std::bit_cast<std::uint64_t>(x[3 * v + c]),
                  std::bit_cast<std::uint64_t>(x[3 * std::size_t{first[v]} + c]))
            << "frame " << k << ", vertex " << v;
      }
    }
  }
}

/// A triangle and one with the same vertices in the other order, with vertices and a material of its own.
GltfBuilder two_sides(const std::vector<std::string>& materials) {
  GltfBuilder b;
  const int front = b.floats("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0});
  const int back = b.floats("VEC3", {0, 0, 0, 0, 1, 0, 1, 0, 0});
  b.json["meshes"] = {{{"primitives",
                        {{{"attributes", {{"POSITION", front}}}, {"material", 0}},
                         {{"attributes", {{"POSITION", back}}}, {"material", materials.size() - 1}}}}}};
  for (const std::string& name : materials) b.json["materials"].push_back({{"name", name}});
  b.json["nodes"] = {{{"mesh", 0}}};
  return b;
}

TEST_F(SeamsTest, SidesOfOneSurfaceAreLayers) {
  for (const std::vector<std::string>& materials :
       {std::vector<std::string>{"leaf"}, {"Leaf_front", "leaf.Back"}, {"coat", "coat inside"}}) {
    GltfBuilder b = two_sides(materials);
    const auto motion = gltf(b);
    ASSERT_TRUE(motion);
    EXPECT_TRUE(motion->info().layered);
    EXPECT_EQ(triangles(*motion), (std::vector<Triangle>{{0, 1, 2}, {0, 2, 1}}));
    EXPECT_THAT(
        notes(*motion),
        ElementsAre("3 of 6 vertices lie on seams and were merged; what meets there counts as neighbors; "
                    "1 face lies on another of its surface and counts as one with it"));
  }
}

TEST_F(SeamsTest, FacesThatLieOnOthersAreNamedOnce) {
  GltfBuilder b = two_sides({"skin", "shirt"});
  const auto motion = gltf(b);
  ASSERT_TRUE(motion);
  EXPECT_TRUE(motion->info().layered);
  EXPECT_THAT(notes(*motion),
              ElementsAre(HasSubstr("3 of 6 vertices"),
                          "1 face lies on another, turned around; that is not counted as contact, and "
                          "--no-weld counts it"));
}

TEST_F(SeamsTest, WeldMergesEqualVerticesOfTheFirstFrame) {
  // Two separate triangles: vertices 3 and 5 repeat 1 and 2, as -0 equals 0. Vertex 6 is unused.
  const std::string faces = "f 1 2 3\nf 4 5 6\n";
  files.write("run/0.obj", "v 9 9 9\nv 1 0 0\nv 0 1 0\nv 1 -0 0\nv 1 1 0\nv 0 1 -0\nv 5 5 5\n" + faces);
  files.write("run/1.obj", "v 8 8 8\nv 2 0 0\nv 0 2 0\nv 2 0 0\nv 2 2 0\nv -0 2 0\nv 4 4 4\n" + faces);
  files.write("run/2.obj", "v 8 8 8\nv 2 0 0\nv 0 2 0\nv 2 0 0\nv 2 2 0\nv 0 2 1e-9\nv 4 4 4\n" + faces);
  const auto motion = open({files.path("run")}, {.weld = Weld::Always});
  ASSERT_TRUE(motion);
  EXPECT_EQ(motion->topology().vertex_count(), 7u);
  EXPECT_EQ(triangles(*motion), (std::vector<Triangle>{{0, 1, 2}, {1, 4, 2}}));
  EXPECT_THAT(merged(*motion), ElementsAre(0, 1, 2, 1, 4, 2, 6));
  EXPECT_THAT(notes(*motion), ElementsAre(HasSubstr("2 of 7 vertices lie on seams")));
  EXPECT_EQ(frame(*motion, 1),
            (std::vector<double>{8, 8, 8, 2, 0, 0, 0, 2, 0, 2, 0, 0, 2, 2, 0, 0, 2, 0, 4, 4, 4}));
  EXPECT_EQ(frame_error(*motion, 2),
            "run: vertices 2 and 5, which --weld merged, part in frame 2; check without --weld");
  const auto plain = open({files.path("run")});
  EXPECT_THAT(merged(*plain), IsEmpty()) << "only on request";
  EXPECT_EQ(triangles(*plain), (std::vector<Triangle>{{0, 1, 2}, {3, 4, 5}}));
}

TEST_F(SeamsTest, AnArchiveSaysWhichVerticesAreOne) {
  const auto archive = [&](const std::string& merged, double last) {
    std::vector<double> frames;
    for (const double z : {0.0, last})
      frames.insert(frames.end(), {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, -0.0, 0, 1, 1, 0, 0, 1, z, 5, 5, 5});
    return write_archive(files.path("a.npz"),
                         {{"faces.npy", npy("<i4", "2, 3", array<std::int32_t>({0, 1, 2, 3, 4, 5}))},
                          {"vertices.npy", npy("<f8", "2, 7, 3", array(frames))},
                          {"merged.npy", merged}});
  };
  const auto map = [](const std::vector<std::int64_t>& of) {
    return npy("<i8", fmt::format("{},", of.size()), array(of));
  };
  const std::vector<std::int64_t> good{0, 1, 2, 1, 4, 2, 6};
  const auto motion = open({archive(map(good), 0)});
  ASSERT_TRUE(motion);
  EXPECT_EQ(triangles(*motion), (std::vector<Triangle>{{0, 1, 2}, {1, 4, 2}}));
  EXPECT_THAT(merged(*motion), ElementsAre(0, 1, 2, 1, 4, 2, 6));
  EXPECT_THAT(motion->info().unchecked, ElementsAre(HasSubstr("1 vertex in no face")));
  EXPECT_THAT(merged(*open({files.path("a.npz")}, {.weld = Weld::Never})), IsEmpty());
  EXPECT_EQ(
      frame_error(*open({archive(map(good), 1)}), 1),
      "a.npz: vertices 2 and 5, which its array 'merged' merged, part in frame 1; check with --no-weld");
  const std::string no_map =
      "is not merged into itself or into an earlier vertex that is merged into itself; "
      "save the first vertex at its place";
  for (const auto& [bad, where] :
       std::vector<std::pair<std::vector<std::int64_t>, std::string>>{{{0, 1, 2, 4, 4, 2, 6}, "vertex 3"},
                                                                      {{0, 1, 2, 1, 4, 3, 6}, "vertex 5"},
                                                                      {{-1, 1, 2, 1, 4, 2, 6}, "vertex 0"}})
    EXPECT_EQ(open_error({archive(map(bad), 0)}),
              fmt::format("a.npz, array 'merged', {}: {}", where, no_map));
  for (const std::string& bad :
       {map({0, 1}), npy("<f8", "7,", array<double>({0, 1, 2, 1, 4, 2, 6})), npy("<i8", "7, 1", array(good))})
    EXPECT_THAT(open_error({archive(bad, 0)}),
                HasSubstr("does not hold an integer for each vertex; save the"));
}

TEST_F(SeamsTest, WeldOfAGltfMergesBetweenNodes) {
  GltfBuilder b;
  b.triangle();
  b.json["nodes"] = {{{"mesh", 0}}, {{"mesh", 0}}};
  b.json["scenes"] = {{{"nodes", {0, 1}}}};
  const auto motion = gltf(b, {.weld = Weld::Always});
  ASSERT_TRUE(motion);
  EXPECT_EQ(triangles(*motion), (std::vector<Triangle>{{0, 1, 2}, {0, 1, 2}}));
  EXPECT_THAT(merged(*motion), ElementsAre(0, 1, 2, 0, 1, 2));
}

TEST_F(SeamsTest, LinesThatShrinkToNothingArePoints) {
  GltfBuilder b;
  const int position = b.floats("VEC3", {0, 0, 0, 0, 0, 0, 5, 5, 5, 6, 5, 5, 7, 7, 7});
  b.json["meshes"] = {{{"primitives", {{{"attributes", {{"POSITION", position}}}, {"mode", 3}}}}}};
  b.json["nodes"] = {{{"mesh", 0}}};
  const auto motion = gltf(b);
  ASSERT_TRUE(motion);
  // 0-1 is a point of the line 0-2.
  EXPECT_EQ(triangles(*motion), (std::vector<Triangle>{{0, 2, 2}, {2, 3, 3}, {3, 4, 4}}));
}

// As many compared values as a frame may have; the file is small, because accessors share bytes.
TEST_F(SeamsTest, ManyVerticesAndTargetsThatShareBytes) {
  GltfBuilder b;
  const int position = b.floats("VEC3", std::vector<float>(3 * 20'000, 1));
  const int other = b.floats("VEC3", std::vector<float>(3 * 20'000, 2));
  Json targets = Json::array();
  for (int t = 0; t < 200; ++t) targets.push_back({{"POSITION", t % 2 == 0 ? position : other}});
  b.json["meshes"] = {
      {{"primitives", {{{"attributes", {{"POSITION", position}}}, {"targets", targets}, {"mode", 5}}}}}};
  b.json["nodes"] = {{{"mesh", 0}}};
  const auto motion = gltf(b);
  ASSERT_TRUE(motion);
  EXPECT_EQ(merged(*motion).back(), 0u);
}

}  // namespace
}  // namespace foldproof::testing
