// What several mesh files are: frames of one motion, or bodies.
#include <fmt/format.h>

#include <Eigen/Geometry>

#include "io/cube.h"
#include "io/gltf_builder.h"
#include "io/support.h"

namespace foldproof::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// A cube, moved and then stretched along x.
std::string cube(const Eigen::Isometry3d& place, double stretch = 1) {
  return cube_at([&](int x, int y, int z) {
    Eigen::Vector3d moved = place * Eigen::Vector3d(x, y, z);
    moved[0] *= stretch;
    return moved;
  });
}

std::string cube(double x, double y, double z, double stretch = 1) {
  return cube(Eigen::Isometry3d(Eigen::Translation3d(x, y, z)), stretch);
}

class FramesOrBodiesTest : public IoTest {
 protected:
  /// Names and numbers of frames of the motions, without the scratch directory.
  std::vector<std::string> found(const std::vector<std::string>& arguments, const ReadOptions& options = {}) {
    const auto motions = open_motions(arguments, options);
    if (!motions) return {shown(motions.error())};
    std::vector<std::string> all;
    for (const auto& motion : *motions) {
      std::string name = motion->name();
      for (std::size_t at; (at = name.find(files.path(""))) != name.npos;)
        name.erase(at, files.path("").size());
      all.push_back(fmt::format("{}: {}", name, motion->frame_count()));
    }
    return all;
  }
  std::string error(const std::vector<std::string>& arguments, const ReadOptions& options = {}) {
    return found(arguments, options)[0];
  }

  static constexpr const char* kWhich = "; say which it is: --sequence or --separate";
  const ReadOptions separate{.mesh_files = MeshFiles::Separate}, sequence{.mesh_files = MeshFiles::Sequence},
      poses{.mesh_files = MeshFiles::Poses};
};

TEST_F(FramesOrBodiesTest, CopiesThatAreFarApartAreAskedFor) {
  const std::vector<std::string> list{files.write("bodies/body_1.obj", cube(0, 0, 0)),
                                      files.write("bodies/body_2.obj", cube(0.5, 0.4, 0.3)),
                                      files.write("bodies/body_3.obj", cube(0.9, 0.7, 0.6))};
  const std::string range = "bodies/body_1.obj to bodies/body_3.obj";
  const std::string why =
      ": may be 3 frames of one mesh or 3 bodies: body_2.obj is 0.41 times its size away from body_1.obj";
  const std::vector<std::string> three{"bodies/body_1.obj: 1", "bodies/body_2.obj: 1",
                                       "bodies/body_3.obj: 1"};
  for (const auto& [arguments, name] : std::vector<std::pair<std::vector<std::string>, std::string>>{
           {{files.path("bodies")}, "bodies"},
           {{files.path("bodies/*.obj")}, "bodies/*.obj"},
           {{files.path("bodies/body_%d.obj")}, "bodies/body_%d.obj"},
           {list, range}}) {
    SCOPED_TRACE(name);
    EXPECT_EQ(error(arguments), name + why + kWhich);
    EXPECT_EQ(open_motions(arguments).error().code, ErrorCode::Ambiguous);
    EXPECT_EQ(found(arguments, separate), three);
    EXPECT_THAT(found(arguments, sequence), ElementsAre(name + ": 3"));
    EXPECT_THAT(found(arguments, poses), ElementsAre(name + ": 3"));
    EXPECT_EQ(open(arguments, sequence)->info().taken_as, "3 frames of one mesh");
  }
  EXPECT_EQ((*open_motions(list, separate))[0]->info().taken_as, "");
}

TEST_F(FramesOrBodiesTest, PosesOfOtherNamesKeepThem) {
  files.write("poses/squat.obj", cube(0, 0, 0));
  files.write("poses/jump.obj", cube(0, 0, 1));
  EXPECT_THAT(open({files.path("poses")}, poses)->info().frame_names, ElementsAre("jump", "squat"));
  files.write("run/f1.obj", cube(0, 0, 0));
  files.write("run/f2.obj", cube(0, 0, 0.1));
  EXPECT_THAT(open({files.path("run")}, poses)->info().frame_names, IsEmpty());
}

TEST_F(FramesOrBodiesTest, BodiesMayBeTurnedAndDiffer) {
  const Eigen::AngleAxisd turn(1, Eigen::Vector3d(1, 2, 3).normalized());
  const auto found_with = [&](const std::string& second) {
    files.write("run/2.obj", second);
    return found({files.path("run")})[0];
  };
  files.write("run/1.obj", cube(0, 0, 0));
  const Eigen::Isometry3d turned(turn), aside(Eigen::Translation3d(1, 0, 0) * turn);
  EXPECT_THAT(found_with(cube(aside)), HasSubstr("run: may be 2 frames of one mesh or 2 bodies: 2.obj is "));
  EXPECT_THAT(found_with(cube(2, 0, 0, 1.1)), HasSubstr("2.obj is 1.3 times its size away from 1.obj"));
  // Up to a quarter of the diagonal it is a motion.
  EXPECT_EQ(found_with(cube(turned)), "run: 2");
  EXPECT_EQ(found_with(cube(0.42, 0, 0)), "run: 2");
  EXPECT_THAT(found_with(cube(0.44, 0, 0)), HasSubstr("0.25 times its size"));
  // A part that stays in place makes frames, up to half the diagonal.
  const auto with_ground = [](double z) {
    return fmt::format("v 0 0 0\nv 0 1 0\nv 0 0 {0}\nv 1 0 {0}\nv 0 1 {0}\nf 3 4 5\nf 1 2 3\n", z);
  };
  files.write("run/1.obj", with_ground(1));
  EXPECT_EQ(found_with(with_ground(0)), "run: 2");
  // What has no size is at one place.
  files.write("run/1.obj", "v 0 0 0\nf 1 1 1\n");
  EXPECT_EQ(found_with("v 1 0 0\nf 1 1 1\n"), "run: 2");
}

TEST_F(FramesOrBodiesTest, OneStepThatIsShortMakesFrames) {
  files.write("fall/f1.obj", cube(0, 0, 0));
  files.write("fall/f2.obj", cube(0, 0, -1));
  files.write("fall/f3.obj", cube(0, 0, -1.1));
  files.write("fall/f4.obj", cube(0, 0, -9));
  EXPECT_THAT(found({files.path("fall")}), ElementsAre("fall: 4"));
  files.write("fall/f3.obj", cube(0, 0, -2));
  EXPECT_THAT(error({files.path("fall")}), HasSubstr("fall: may be 4 frames of one mesh or 4 bodies"));
  // A frame that cannot be read says so when it is read.
  files.write("fall/f2.obj", "v 0 0 0\n");
  EXPECT_THAT(found({files.path("fall")}), ElementsAre("fall: 4"));
}

TEST_F(FramesOrBodiesTest, NamesThatDifferInMoreThanANumberAreBodies) {
  files.write("lr/left.obj", cube(0, 0, 0));
  files.write("lr/right.obj", cube(0.5, 0.4, 0.3));
  EXPECT_THAT(found({files.path("lr")}), ElementsAre("lr/left.obj: 1", "lr/right.obj: 1"));
  EXPECT_THAT(found({files.path("lr/*")}), ElementsAre("lr/left.obj: 1", "lr/right.obj: 1"));
  EXPECT_THAT(found({files.path("lr")}, poses), ElementsAre("lr: 2"));
  EXPECT_THAT(found({files.path("lr")}, sequence), ElementsAre("lr: 2"));
  const std::vector<std::string> list{files.path("lr/left.obj"), files.path("lr/right.obj")};
  EXPECT_THAT(found(list), ElementsAre("lr/left.obj: 1", "lr/right.obj: 1"));
  EXPECT_THAT(found(list, poses), ElementsAre("lr/left.obj: 1", "lr/right.obj: 1"));
  EXPECT_THAT(found(list, sequence), ElementsAre("lr/left.obj to lr/right.obj: 2"));

  for (const char* name : {"a1_v2", "a2_v2", "a10_v2", "a1_v3", "b", "c1", "d1", "d-2"})
    files.write(std::string("many/") + name + ".obj", cube(0, 0, 0));
  // a1_v2 and a1_v3 differ in the last number, before which others count.
  EXPECT_THAT(found({files.path("many")}),
              ElementsAre("many/a1_v2.obj to many/a1_v3.obj: 2", "many/a2_v2.obj to many/a10_v2.obj: 2",
                          "many/b.obj: 1", "many/c1.obj: 1", "many/d-2.obj to many/d1.obj: 2"));
}

TEST_F(FramesOrBodiesTest, FilesThatAreNoFramesOfTheOthersAreBodies) {
  const std::string s1 = files.write("s1.obj", cube(0, 0, 0)),
                    s2 = files.write("s2.obj", cube(0.5, 0.5, 0.5));
  for (const int k : {1, 2, 3}) files.write(fmt::format("cloth/c{}.obj", k), cube(0, 0, 5 + 0.1 * k));
  const std::string cloth = files.path("cloth");
  ReadOptions together{.still = true};
  EXPECT_THAT(found({s1, s2, cloth}, together), ElementsAre("s1.obj: 3", "s2.obj: 3", "cloth: 3"));
  const auto motions = open_motions(std::vector{s1, s2, cloth}, together);
  EXPECT_THAT((*motions)[0]->info().notes, ElementsAre(HasSubstr("s2.obj are bodies, not 2 frames: ")));
  EXPECT_THAT((*motions)[1]->info().notes, IsEmpty());
  EXPECT_THAT(found({s1, s2, cloth}), ElementsAre(HasSubstr("may be 2 frames")));
  std::filesystem::remove(files.path("cloth/c3.obj"));
  EXPECT_THAT(error({s1, s2, cloth}, together),
              HasSubstr("s2.obj: may be 2 frames of one mesh or 2 bodies: s2.obj is 0.5 times"));
  together.mesh_files = MeshFiles::Separate;
  EXPECT_THAT(found({s1, s2, cloth}, together),
              ElementsAre("s1.obj: 1", "s2.obj: 1", "cloth/c1.obj: 1", "cloth/c2.obj: 1"));
}

TEST_F(FramesOrBodiesTest, ASequenceThatIsForcedStaysWithinItsNumbering) {
  std::vector<std::string> list;
  for (const char* name : {"a1", "a2", "b1", "b2", "fist", "rest"})
    list.push_back(files.write(std::string(name) + ".obj", cube(0, 0, 0)));
  EXPECT_THAT(found(list, sequence),
              ElementsAre("a1.obj to a2.obj: 2", "b1.obj to b2.obj: 2", "fist.obj to rest.obj: 2"));
  list.insert(list.begin() + 4, files.write("one/f1.obj", cube(0, 0, 0)).substr(0, files.path("one").size()));
  EXPECT_THAT(found(list, sequence),
              ElementsAre("a1.obj to a2.obj: 2", "b1.obj to b2.obj: 2", "one: 1", "fist.obj to rest.obj: 2"));
}

TEST_F(FramesOrBodiesTest, ADirectoryWithAnAnimationNamesIt) {
  files.write("scene/walk.glb", "glTF");
  EXPECT_THAT(error({files.path("scene")}), HasSubstr("files; name scene/walk.glb, which is in it"));
  files.write("scene/a.obj", cube(0, 0, 0));
  EXPECT_EQ(error({files.path("scene")}),
            "scene: mixes formats: scene/a.obj and scene/walk.glb; name scene/walk.glb alone, or keep it "
            "elsewhere");
}

}  // namespace
}  // namespace foldproof::testing
