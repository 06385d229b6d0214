// Progress while files are read whole.
#include <map>

#include "io/gltf_builder.h"
#include "io/npz_builder.h"
#include "io/progress.h"

namespace foldproof::testing {
namespace {

constexpr std::size_t kLarge = 9'000'000;  // more than one block
const std::string kTriangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

class ProgressTest : public IoTest {
 protected:
  /// Opens a motion and reads a frame. Per file that was read: how often progress was called, always with
  /// more bytes than before, to the last one.
  std::map<std::string, int> calls(const std::vector<std::string>& arguments) {
    std::map<std::string, int> calls;
    std::string current;
    std::uint64_t before = 0, expected = 0;
    const auto progress = [&](const std::string& file, std::uint64_t done, std::uint64_t all) {
      if (file != current) {
        EXPECT_EQ(before, expected) << current;
        current = file;
        before = 0;
        expected = all;
      }
      EXPECT_EQ(all, expected) << file;
      EXPECT_GT(done, before) << file;
      before = done;
      ++calls[file];
    };
    auto motions = io::open_with_progress(arguments, {}, progress);
    EXPECT_TRUE(motions);
    EXPECT_EQ(before, expected) << current;
    const auto while_opened = calls;
    if (motions) frame(*motions->front(), motions->front()->frame_count() - 1);
    EXPECT_EQ(calls, while_opened) << "called when a frame was read";
    return calls;
  }
};

TEST_F(ProgressTest, OfAMeshCoversItsBytes) {
  const std::string mesh = files.write("a.obj", kTriangle + std::string(kLarge, '\n'));
  EXPECT_EQ(calls({mesh}), (std::map<std::string, int>{{mesh, 3}}));
  const std::string small = files.write("b.obj", kTriangle);
  EXPECT_EQ(calls({small}), (std::map<std::string, int>{{small, 1}}));
}

TEST_F(ProgressTest, OfFramesCoversTheFirst) {
  const std::string first = files.write("run/f1.obj", kTriangle + std::string(kLarge, '\n'));
  files.write("run/f2.obj", kTriangle);
  EXPECT_EQ(calls({files.path("run")}), (std::map<std::string, int>{{first, 3}}));
}

TEST_F(ProgressTest, OfGltfCoversItsBuffers) {
  GltfBuilder scene;
  scene.json["nodes"] = {{{"mesh", 0}}};
  scene.triangle();
  scene.view(std::string(kLarge, 'x'));
  const std::string glb = files.write("a.glb", scene.glb());
  EXPECT_EQ(calls({glb}), (std::map<std::string, int>{{glb, 3}}));
  const std::string gltf = files.write("a.gltf", scene.gltf_beside("b.bin"));
  const std::string buffer = std::filesystem::canonical(files.write("b.bin", scene.buffer)).generic_string();
  EXPECT_EQ(calls({gltf}), (std::map<std::string, int>{{gltf, 1}, {buffer, 3}}));
}

TEST_F(ProgressTest, OfAnArchiveCoversFramesThatArePacked) {
  const std::vector<std::pair<std::string, std::string>> arrays{
      {"faces.npy", npy("<i4", "1, 3", array<std::int32_t>({0, 1, 2}))},
      {"vertices.npy", npy("<f4", "75000, 3, 3", std::string(75000 * 36, '\0'))}};
  const std::string packed = write_archive(files.path("a.npz"), arrays, true);
  EXPECT_EQ(calls({packed}), (std::map<std::string, int>{{packed + ", array 'vertices'", 3}}));
  EXPECT_THAT(calls({write_archive(files.path("b.npz"), arrays)}), ::testing::IsEmpty());
}

}  // namespace
}  // namespace foldproof::testing
