// A repaired motion in the glTF file that it came from.
#include "io/gltf_repair.h"

#include "io/gltf_builder.h"

namespace foldproof::testing {
namespace {

using ::testing::DoubleNear;
using ::testing::HasSubstr;
using ::testing::Pointwise;

/// A triangle with two morph targets and a skin, and the same mesh once more, doubled and without the skin.
/// In clip "Bend" a joint turns, weights have a key between frames, and the second node moves; in clip
/// "Still" weights hold.
class GltfRepairTest : public GltfIoTest {
 protected:
  GltfRepairTest() {
    Json& primitive = b.triangle();
    primitive["attributes"]["JOINTS_0"] =
        b.accessor<std::uint8_t>("VEC4", {0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0});
    primitive["attributes"]["WEIGHTS_0"] =
        b.floats("VEC4", {1, 0, 0, 0, 0.5F, 0.5F, 0, 0, 0.25F, 0.75F, 0, 0});
    primitive["attributes"]["NORMAL"] = b.floats("VEC3", {0, 0, 1, 0, 0, 1, 0, 0, 1});
    const int up = b.floats("VEC3", {0, 0, 1, 0, 0, 1, 0, 0, 0}),
              none = b.floats("VEC3", std::vector<float>(9));
    primitive["targets"] = {{{"POSITION", up}, {"NORMAL", none}}, {{"POSITION", none}, {"NORMAL", none}}};
    primitive["material"] = 0;
    b.json["materials"] = {{{"name", "Skin"}}};
    b.json["meshes"][0]["name"] = "Body";
    b.json["meshes"][0]["extras"]["targetNames"] = {"smile", "frown"};
    b.json["nodes"] = {{{"mesh", 0}, {"skin", 0}, {"name", "A"}},
                       {{"mesh", 0}, {"scale", {2, 2, 2}}, {"name", "B"}},
                       {{"name", "root"}},
                       {{"name", "tip"}, {"translation", {0, 0, 1}}}};
    b.json["scenes"] = {{{"nodes", {0, 1, 2, 3}}}};
    b.json["skins"] = {{{"joints", {2, 3}}}};
    const int times = b.floats("SCALAR", {0, 1}), uneven = b.floats("SCALAR", {0, 0.3F, 1});
    b.animate(3, "rotation", times, b.floats("VEC4", {0, 0, 0, 1, 0, 0, 1, 0}));
    b.animate(1, "translation", times, b.floats("VEC3", {0, 0, 0, 0, 5, 0}));
    b.animate(0, "weights", uneven, b.floats("SCALAR", {0, 0, 1, 0, 0.5F, 0}));
    b.play_together();
    b.json["animations"][0]["name"] = "Bend";
    b.animate(0, "weights", b.floats("SCALAR", {0, 0.5F}), b.floats("SCALAR", {0.25F, 0, 0.75F, 0}));
    b.json["animations"][1]["name"] = "Still";
    options.fps = 4;
  }

  /// Frames as they are read, from `first` to `last`, and in some of them vertices that were moved.
  std::unique_ptr<Motion> repaired(Index first, Index last,
                                   const std::map<std::pair<Index, Index>, std::array<double, 3>>& moved) {
    auto source = open({path}, options);
    std::vector<std::vector<double>> frames;
    for (Index k = first; k <= last; ++k) frames.push_back(frame(*source, k));
    for (const auto& [where, by] : moved) {
      for (std::size_t c = 0; c < 3; ++c) frames[where.first - first][3 * where.second + c] += by[c];
    }
    return memory_motion("repaired", source->topology(), std::move(frames));
  }

  void expect_written(Motion& motion, Index first) {
    const std::string written = files.path("written.glb");
    const auto done = io::write_gltf_repair(written, path, options, motion, first, {"Proven.", true});
    ASSERT_TRUE(done) << done.error().line();
    const auto source = open({path}, options), read = open({written}, options);
    ASSERT_EQ(read->frame_count(), source->frame_count());
    EXPECT_EQ(read->topology(), source->topology());
    for (Index k = 0; k < read->frame_count(); ++k) {
      const bool in_range = k >= first && k - first < motion.frame_count();
      const auto expected = in_range ? frame(motion, k - first) : frame(*source, k);
      EXPECT_THAT(frame(*read, k), Pointwise(DoubleNear(2e-6), expected)) << k;
    }
  }

  GltfBuilder b;
  ReadOptions options;
  std::string path;
};

TEST_F(GltfRepairTest, FramesAreWhatWasRepairedAndAllElseIsKept) {
  path = files.write("a.gltf", b.gltf());
  const auto motion = repaired(
      0, 4,
      {{{1, 0}, {0.1, -0.2, 0.3}}, {{2, 1}, {0, 0.5, 0}}, {{2, 5}, {-1, 0, 0}}, {{4, 2}, {0, 0, 1e-3}}});
  expect_written(*motion, 0);
  const std::string bytes = read_bytes(files.path("written.glb"));
  const std::uint32_t length =
      static_cast<unsigned char>(bytes[12]) + 256u * static_cast<unsigned char>(bytes[13]);
  const Json json = Json::parse(bytes.substr(20, length));
  EXPECT_EQ(json["asset"]["extras"]["foldproof"]["verdict"], "Proven.");
  EXPECT_EQ(json["asset"]["extras"]["foldproof"]["clip"], "Bend");
  EXPECT_EQ(json["materials"], b.json["materials"]);
  // Two nodes share a mesh, of which each gets its own.
  EXPECT_NE(json["nodes"][0]["mesh"], json["nodes"][1]["mesh"]);
  const Json& of_a = json["meshes"][json["nodes"][0]["mesh"].get<std::size_t>()];
  EXPECT_EQ(of_a["name"], "Body");
  EXPECT_EQ(of_a["extras"]["targetNames"],
            Json({"smile", "frown", "foldproof, frame 1", "foldproof, frame 2", "foldproof, frame 4"}));
  const Json& target = of_a["primitives"][0]["targets"][2];
  EXPECT_TRUE(target.contains("NORMAL"));
  const Json& accessor = json["accessors"][target["POSITION"].get<std::size_t>()];
  EXPECT_EQ(accessor["sparse"]["count"], 1);
  EXPECT_FALSE(accessor.contains("bufferView"));
}

TEST_F(GltfRepairTest, OtherClipsAndOtherFramesAreAsTheyWere) {
  path = files.write("a.glb", b.glb());
  const auto motion = repaired(2, 3, {{{2, 0}, {0.1, -0.2, 0.3}}, {{3, 0}, {0.1, -0.2, 0.3}}});
  expect_written(*motion, 2);
  options.clip = "Still";
  const auto source = open({path}, options), read = open({files.path("written.glb")}, options);
  for (Index k = 0; k < source->frame_count(); ++k) EXPECT_EQ(frame(*read, k), frame(*source, k)) << k;
  expect_written(*repaired(0, 1, {{{1, 1}, {1, 0, 0}}}), 0);
}

TEST_F(GltfRepairTest, WhatHasNoClipIsMovedForGood) {
  b.json.erase("animations");
  path = files.write("a.glb", b.glb());
  expect_written(*repaired(0, 0, {{{0, 0}, {0.1, -0.2, 0.3}}, {{0, 4}, {0, 0, 2}}}), 0);
}

TEST_F(GltfRepairTest, WhatWasNotMovedIsTheSameToTheLastBit) {
  b.json["animations"][0]["channels"].erase(2);  // frames are at no keys of the weights, which are rounded
  path = files.write("a.glb", b.glb());
  const auto motion = repaired(0, 4, {{{1, 0}, {0.1, 0, 0}}});
  expect_written(*motion, 0);
  const auto read = open({files.path("written.glb")}, options);
  auto expected = frame(*motion, 1), found = frame(*read, 1);
  std::fill_n(expected.begin(), 3, 0), std::fill_n(found.begin(), 3, 0);
  EXPECT_EQ(found, expected);
}

TEST_F(GltfRepairTest, RefusesWhatCannotBeWrittenAgain) {
  const auto error = [&](const std::string& out) {
    const auto done = io::require_gltf_can_be_repaired(files.path(out), path);
    return done ? "" : done.error().line();
  };
  path = files.write("a.gltf", b.gltf());
  EXPECT_EQ(error("b.glb"), "");
  b.json["images"] = {{{"uri", "skin.png"}}};
  path = files.write("a.gltf", b.gltf());
  EXPECT_EQ(error("b.glb"), "");
  files.write("elsewhere/x", "");
  EXPECT_THAT(error("elsewhere/b.glb"), HasSubstr("would not find the image 'skin.png'"));
  b.json["extensionsUsed"] = {"KHR_draco_mesh_compression"};
  path = files.write("a.gltf", b.gltf());
  EXPECT_THAT(error("b.glb"), HasSubstr("is compressed (KHR_draco_mesh_compression)"));
  b.json["extensionsUsed"] = Json::array();
  b.json["images"] = {7};
  path = files.write("a.gltf", b.gltf());
  EXPECT_THAT(error("b.glb"), HasSubstr("of another form than glTF's"));
  path = files.write("a.obj", "v 0 0 0\n");
  EXPECT_THAT(error("b.glb"), HasSubstr("is no glTF file; name it .npz, .obj or .ply"));
}

TEST_F(GltfRepairTest, RefusesToMoveWhatIsFlat) {
  b.json["nodes"][1]["scale"] = {2, 0, 2};
  path = files.write("a.gltf", b.gltf());
  const auto motion = repaired(0, 4, {{{1, 4}, {0, 0.5, 0}}});
  const auto done = io::write_gltf_repair(files.path("written.glb"), path, options, *motion, 0, {});
  ASSERT_FALSE(done);
  EXPECT_THAT(done.error().line(),
              HasSubstr("frame 1, vertex 4: was moved, but its joints or its node flatten it"));
}

}  // namespace
}  // namespace foldproof::testing
