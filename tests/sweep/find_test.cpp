// Finding the motions below a directory.
#include <gmock/gmock.h>

#include "report/sinking_triangle.h"
#include "sweep/sweep.h"

namespace foldproof {
namespace {

using namespace foldproof::testing;
using ::testing::ElementsAre;
using ::testing::Field;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// A directory with files of these names; their content does not matter.
struct Library : TemporaryDirectory {
  explicit Library(const std::vector<std::string>& files) {
    for (const std::string& file : files) {
      const std::filesystem::path path = *this / file;
      std::filesystem::create_directories(path.parent_path());
      std::ofstream(path) << "12345";
    }
  }

  void link(const std::string& file, const std::string& to) const {
    std::filesystem::create_directories(std::filesystem::path(*this / file).parent_path());
    std::filesystem::create_symlink(*this / to, *this / file);
  }

  /// Paths of the motions, seen from the directory.
  std::vector<std::string> found(bool poses = false, bool separate = false) const {
    std::vector<std::string> names;
    for (const SweepMotion& motion : input(poses, separate).motions) names.push_back(name(motion.path));
    return names;
  }

  SweepInput input(bool poses = false, bool separate = false) const {
    const std::string directories[] = {path()};
    const auto found = find_motions(directories, poses, separate);
    EXPECT_TRUE(found) << found.error().line();
    return found.value_or(SweepInput{});
  }

  std::string name(const std::string& whole) const {
    return whole == path() ? "." : whole.substr(path().size() + 1);
  }
};

TEST(FindMotions, TakesEveryAnimationInNaturalOrder) {
  const Library library({"walk10.glb", "walk9.GLB", "deep/er/run.npz", "deep/jump.gltf", "notes.txt",
                         ".hidden.glb", ".hidden/a.glb"});
  EXPECT_THAT(library.found(), ElementsAre("deep/er/run.npz", "deep/jump.gltf", "walk9.GLB", "walk10.glb"));
}

TEST(FindMotions, GivesEachCacheTheMeshOfItsStemOrTheOnlyOne) {
  const Library library({"a/walk.pc2", "a/walk.obj", "a/run.mdd", "a/run.ply", "b/one.pc2", "b/two.mdd",
                         "b/body.off", "c/lost.pc2", "c/x.obj", "c/y.obj"});
  const SweepInput input = library.input();
  std::vector<std::string> pairs;
  for (const SweepMotion& motion : input.motions)
    pairs.push_back(library.name(motion.path) + " " + library.name(motion.files[0]));
  EXPECT_THAT(pairs, ElementsAre("a/run.mdd a/run.ply", "a/walk.pc2 a/walk.obj", "b/one.pc2 b/body.off",
                                 "b/two.mdd b/body.off", "c/lost.pc2 c/lost.pc2"));
  EXPECT_EQ(input.single_meshes, 2u);
}

TEST(FindMotions, PairsArraysWhoseNamesDifferInTheLastWordOnly) {
  const Library library({"a/vertices.npy", "a/faces.npy", "b/arm_V.npy", "b/arm_F.npy", "b/leg-points.npy",
                         "b/leg-tris.npy", "lost/arm_v.npy", "lost/leg_f.npy", "lost/weights.npy",
                         "many/x.npy", "many/v.npy", "many/f.npy"});
  const SweepInput input = library.input();
  std::vector<std::string> pairs;
  for (const SweepMotion& motion : input.motions)
    pairs.push_back(library.name(motion.path) + " " + library.name(motion.files[0]));
  EXPECT_THAT(pairs, ElementsAre("a/vertices.npy a/faces.npy", "b/arm_V.npy b/arm_F.npy",
                                 "b/leg-points.npy b/leg-tris.npy"));
  EXPECT_EQ(input.motions[0].bytes, 10u);
  EXPECT_EQ(input.single_arrays, 6u);
}

TEST(FindMotions, TakesMeshesThatDifferInTheirLastNumberAsFrames) {
  const Library library({"frames/f10.obj", "frames/f9.obj", "frames/f11.obj", "takes/a1_001.ply",
                         "takes/a1_002.ply", "takes/a2_001.ply", "takes/a2_002.ply", "takes/a2_002.off",
                         "other/chair.obj"});
  const SweepInput input = library.input();
  EXPECT_THAT(library.found(), ElementsAre("frames", "takes/a1_*.ply", "takes/a2_*.ply"));
  std::vector<std::string> frames;
  for (const std::string& file : input.motions[0].files) frames.push_back(library.name(file));
  EXPECT_THAT(frames, ElementsAre("frames/f9.obj", "frames/f10.obj", "frames/f11.obj"));
  EXPECT_EQ(input.motions[0].bytes, 15u);
  EXPECT_EQ(input.single_meshes, 2u);
}

TEST(FindMotions, KeepsNumbersThatMayBeNegativeBesideOthers) {
  const Library library({"a/f-1.obj", "a/f-2.obj", "a/f0.obj", "a/g.obj", "b/f.-1.obj", "b/f.0.obj",
                         "b/g.obj", "c/f-1.obj", "c/f-2.obj", "c/g.obj"});
  EXPECT_THAT(library.found(), ElementsAre("a/f-*.obj", "b/f.-*.obj", "c/f-*.obj"));
  EXPECT_EQ(library.input().motions[0].files.size(), 3u);
  EXPECT_EQ(library.input().motions[1].files.size(), 2u);
}

TEST(FindMotions, TakesSingleMeshesForPosesOnly) {
  const Library library({"chair.obj", "table.ply"});
  EXPECT_THAT(library.found(), IsEmpty());
  EXPECT_THAT(library.found(true), ElementsAre("chair.obj", "table.ply"));
}

TEST(FindMotions, TakesNumberedMeshesAsSingleOnesIfAsked) {
  const Library library({"run1.obj", "run2.obj", "walk.npz"});
  EXPECT_THAT(library.found(true, true), ElementsAre("run1.obj", "run2.obj", "walk.npz"));
  EXPECT_THAT(library.found(false, true), ElementsAre("walk.npz"));
  EXPECT_EQ(library.input(false, true).single_meshes, 2u);
}

TEST(FindMotions, TakesTheMeshesOfACollectionAsItsFrames) {
  const Library library({"run/f1.vtp", "run/f2.vtp", "run/f3.vtp", "more/f1.vtp", "more/f2.vtp"});
  std::ofstream(library / "run.pvd") << "<VTKFile type=\"Collection\"><Collection>"
                                        "<DataSet timestep=\"0\" file=\"run/f1.vtp\"/>"
                                        "<DataSet timestep=\"1\" file=\"run/f2.vtp\"/>"
                                        "</Collection></VTKFile>";
  const SweepInput input = library.input();
  EXPECT_THAT(library.found(), ElementsAre("more", "run.pvd"));
  EXPECT_EQ(input.single_meshes, 1u);
  EXPECT_EQ(input.motions[1].bytes, std::filesystem::file_size(library / "run.pvd") + 10);
}

TEST(FindMotions, FindsNothingTwiceAndFollowsNoLinkToADirectory) {
  const Library library({"a/walk.glb"});
  std::filesystem::create_directory_symlink(library.path(), library / "a/round");
  std::filesystem::create_symlink(library / "a/walk.glb", library / "again.glb");
  const std::string directories[] = {library.path() + "/a//", library.path()};
  const auto found = find_motions(directories);
  ASSERT_TRUE(found);
  EXPECT_THAT(found->motions, ElementsAre(Field(&SweepMotion::path, library / "a/walk.glb")));
  EXPECT_THAT(found->directories, ElementsAre(library / "a", library.path()));
}

TEST(FindMotions, FindsMotionsThatShareOnlySomeOfTheirFiles) {
  const Library library({"a/f1.obj", "a/f2.obj", "b/f1.obj", "cache/body.obj", "cache/walk.pc2",
                         "cache2/body.obj", "array/faces.npy", "array/v.npy", "array2/faces.npy", "g/x.gltf",
                         "g/x.bin", "g2/x.bin"});
  library.link("b/f2.obj", "a/f2.obj");
  library.link("backward/f1.obj", "a/f2.obj");
  library.link("backward/f2.obj", "a/f1.obj");
  library.link("cache2/walk.pc2", "cache/walk.pc2");
  library.link("array2/v.npy", "array/v.npy");
  std::ofstream(library / "g/x.gltf") << R"({"buffers":[{"uri":"x.bin"}]})";
  library.link("g2/x.gltf", "g/x.gltf");
  const std::vector<std::string> all = library.found();
  EXPECT_THAT(all, ElementsAre("a", "array/v.npy", "array2/v.npy", "b", "backward", "cache/walk.pc2",
                               "cache2/walk.pc2", "g/x.gltf", "g2/x.gltf"));

  for (const char* file : {"a/f1.obj", "a/f2.obj", "b/f1.obj", "b/f2.obj", "cache2/body.obj",
                           "cache2/walk.pc2", "array2/faces.npy", "array2/v.npy", "g2/x.gltf", "g2/x.bin"})
    library.link(std::string("same/") + file, file);
  EXPECT_EQ(library.found(), all) << "those of the same files are found once";
}

TEST(FindMotions, FindsMotionsThatShareFramesWithACollection) {
  const Library library({"run/f1.vtp", "run/f2.vtp", "other/f1.vtp"});
  std::ofstream(library / "run.pvd") << "<VTKFile type=\"Collection\"><Collection>"
                                        "<DataSet timestep=\"0\" file=\"run/f1.vtp\"/>"
                                        "<DataSet timestep=\"1\" file=\"run/f2.vtp\"/>"
                                        "</Collection></VTKFile>";
  library.link("other/f2.vtp", "run/f2.vtp");
  EXPECT_THAT(library.found(), ElementsAre("other", "run.pvd"));
}

TEST(FindMotions, SeesThatABufferOfAGltfChanged) {
  const Library library({"a.gltf", "below/a b.bin", "other.bin"});
  const std::string json = R"({"buffers":[{"uri":"below/a%20b.bin"},{"uri":"data:;base64,AA=="},{}]})";
  std::ofstream(library / "a.gltf") << json;
  EXPECT_EQ(library.input().motions[0].bytes, json.size() + 5);
  const auto later = std::filesystem::file_time_type::clock::now() + std::chrono::hours(1);
  const SweepMotion before = library.input().motions[0];
  std::filesystem::last_write_time(library / "other.bin", later);
  EXPECT_EQ(library.input().motions[0].status, before.status);
  std::filesystem::last_write_time(library / "below/a b.bin", later);
  EXPECT_GT(library.input().motions[0].modified, before.modified);
  EXPECT_NE(library.input().motions[0].status, before.status);
}

TEST(FindMotions, SaysWhatIsNoDirectory) {
  const Library library({"walk.glb"});
  for (const auto& [name, said] : {std::pair("walk.glb", "is no directory"), {"none", "does not exist"}}) {
    const std::string directories[] = {library / name};
    const auto found = find_motions(directories);
    ASSERT_FALSE(found);
    EXPECT_THAT(found.error().line(), HasSubstr(said));
  }
}

}  // namespace
}  // namespace foldproof
