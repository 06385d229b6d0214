// Opening motions: directories, globs, the order of frames, mixed formats, welding.
#include "io/formats.h"
#include "io/readers.h"
#include "io/support.h"

namespace foldproof::testing {
namespace {

std::string obj_at(double z) { return "v 0 0 " + std::to_string(z) + "\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"; }

using ::testing::ElementsAre;
using ::testing::IsEmpty;

using OpenTest = IoTest;

TEST_F(OpenTest, EveryArgumentIsAMotionOfItsOwn) {
  const std::string a = files.write("a.obj", obj_at(1)), b = files.write("b.OBJ", obj_at(2));
  const std::vector<std::string> arguments{a, b, a};
  const auto motions = open_motions(arguments);
  ASSERT_TRUE(motions);
  ASSERT_EQ(motions->size(), 3u);
  EXPECT_EQ((*motions)[1]->name(), b);
  EXPECT_EQ(frame(*(*motions)[1], 0)[2], 2);
  EXPECT_EQ(frame(*(*motions)[2], 0)[2], 1);
}

// Each row of the table has exactly the reader of its kind, which is called without a null check.
TEST_F(OpenTest, EveryFormatHasTheReaderOfItsKind) {
  for (const char* extension : {".obj", ".off", ".ply", ".stl", ".vtk", ".vtp", ".vtu", ".msh", ".pc2",
                                ".mdd", ".npz", ".pvd", ".npy", ".gltf", ".GLB"}) {
    const io::FileFormat* format = io::format_of(std::string("run/a") + extension);
    ASSERT_NE(format, nullptr) << extension;
    EXPECT_EQ(format->parse_mesh != nullptr, format->kind == io::FileKind::Mesh) << extension;
    EXPECT_EQ(format->open_cache != nullptr, format->kind == io::FileKind::PointCache) << extension;
    EXPECT_EQ(format->open_animation != nullptr, format->kind == io::FileKind::Animation) << extension;
  }
  for (const char* path : {"a.step", "obj", "a", "", "a.obj.zip"}) {
    EXPECT_EQ(io::format_of(path), nullptr) << path;
    EXPECT_FALSE(io::read_mesh(path)) << path;
  }
}

TEST_F(OpenTest, FramesAreThoseOfTheDirectoryInWhichItWasOpened) {
  for (const double z : {1.0, 2.0}) {
    const std::string shot = z == 1 ? "one/run/" : "two/run/";
    files.write(shot + "f1.obj", obj_at(0));
    files.write(shot + "f2.obj", obj_at(z));
  }
  const auto before = std::filesystem::current_path();
  std::filesystem::current_path(files.path("one"));
  const auto motion = open({"run"});
  std::filesystem::current_path(files.path("two"));
  const bool opened = motion != nullptr;
  const double z = opened ? frame(*motion, 1)[2] : 0;
  std::filesystem::current_path(before);
  ASSERT_TRUE(opened);
  EXPECT_EQ(z, 1);
}

TEST_F(OpenTest, NoticesAFrameThatIsWrittenAgain) {
  files.write("run/f1.obj", obj_at(0));
  const std::string second = files.write("run/f2.obj", obj_at(1));
  const auto motion = open({files.path("run")});
  ASSERT_TRUE(motion);
  EXPECT_EQ(frame_error(*motion, 1), "no error");
  std::filesystem::last_write_time(second,
                                   std::filesystem::file_time_type::clock::now() + std::chrono::hours(1));
  EXPECT_EQ(frame_error(*motion, 1),
            "run/f2.obj (frame 1): has been written to since the motion was opened; open it again");
}

TEST_F(OpenTest, FramesAreInNaturalOrder) {
  const std::vector<std::string> names{"f1.obj",  "f2.obj",   "f09.obj",   "f9.obj",
                                       "f10.obj", "f100.obj", "g.obj",     "g0.obj",
                                       "g00.obj", "g1a3.obj", "g1a20.obj", "g18446744073709551617.obj"};
  // Written in reverse, so that the order of the directory does not help.
  for (std::size_t i = names.size(); i-- > 0;) files.write("run/" + names[i], obj_at(static_cast<double>(i)));
  files.write("run/readme.txt", "not a mesh");
  files.write("run/.hidden.obj", "not a mesh");
  files.write("run/deeper/f1.obj", obj_at(99));
  for (const std::string& argument :
       {files.path("run"), files.path("run/"), files.path("run/*.obj"), files.path("ru?/*.[o]bj")}) {
    SCOPED_TRACE(argument);
    const auto motion = open({argument}, {.mesh_files = MeshFiles::Sequence});
    ASSERT_TRUE(motion);
    EXPECT_EQ(motion->name(), argument);
    ASSERT_EQ(motion->frame_count(), names.size());
    std::vector<std::string> found;
    for (Index k = 0; k < motion->frame_count(); ++k)
      found.push_back(names[static_cast<std::size_t>(frame(*motion, k)[2])]);
    EXPECT_THAT(found, ::testing::ElementsAre("f1.obj", "f2.obj", "f09.obj", "f9.obj", "f10.obj", "f100.obj",
                                              "g.obj", "g0.obj", "g00.obj", "g1a3.obj", "g1a20.obj",
                                              "g18446744073709551617.obj"));
  }
}

TEST_F(OpenTest, NumberedMeshesAreTheFramesOfOneMotion) {
  for (const int k : {1, 2, 10}) files.write("run/f" + std::to_string(k) + ".obj", obj_at(k));
  const auto heights = [](Motion& motion) {
    std::vector<double> z;
    for (Index k = 0; k < motion.frame_count(); ++k) z.push_back(frame(motion, k)[2]);
    return z;
  };
  // As a shell expands f*.obj.
  const std::vector<std::string> expanded{files.path("run/f1.obj"), files.path("run/f10.obj"),
                                          files.path("run/f2.obj"), files.write("other.obj", obj_at(9))};
  const auto motions = open_motions(expanded);
  ASSERT_TRUE(motions);
  ASSERT_EQ(motions->size(), 2u);
  EXPECT_THAT(heights(*(*motions)[0]), ::testing::ElementsAre(1, 2, 10));
  EXPECT_EQ((*motions)[0]->name(), files.path("run/f1.obj") + " to " + files.path("run/f10.obj"));
  EXPECT_EQ((*motions)[1]->name(), files.path("other.obj"));
  EXPECT_EQ(open_motions(expanded, {.mesh_files = MeshFiles::Separate})->size(), 4u);

  const auto pattern = open({files.path("run/f%02d.obj")});
  ASSERT_TRUE(pattern);
  EXPECT_THAT(heights(*pattern), ::testing::ElementsAre(1, 2, 10));
  EXPECT_EQ(open_error({files.path("run/g%d.obj")}),
            "run/g%d.obj: matches no files; %d stands for a number in their names");
  const auto odd = open({files.write("100%d.obj", obj_at(4))});
  ASSERT_TRUE(odd) << "a file of this name exists";
  EXPECT_EQ(frame(*odd, 0)[2], 4);
}

TEST_F(OpenTest, ANameWithGlobCharactersThatExistsIsAFile) {
  const auto motion = open({files.write("a[1].obj", obj_at(4))});
  ASSERT_TRUE(motion);
  EXPECT_EQ(frame(*motion, 0)[2], 4);
}

TEST_F(OpenTest, ReportsWhatIsNotAMotion) {
  files.write("empty/readme.txt", "nothing");
  files.write("mixed/a.obj", obj_at(1));
  files.write("mixed/b.ply", "ply");
  files.write("cached/a.obj", obj_at(1));
  files.write("cached/a.pc2", "POINTCACHE2");
  const std::string no_mesh =
      ": holds no .obj, .off, .ply, .stl, .vtp, .vtu, .vtk or .msh files; name mesh files, or a directory "
      "that "
      "holds them";
  const std::string one = "; name one of them, or keep one format in a directory";
  EXPECT_EQ(open_error({files.path("empty")}), "empty" + no_mesh);
  files.write("only/a.pc2", "POINTCACHE2");
  EXPECT_EQ(open_error({files.path("only/*")}), "only/*" + no_mesh);
  EXPECT_EQ(open_error({files.path("mixed")}), "mixed: mixes formats: mixed/a.obj and mixed/b.ply" + one);
  EXPECT_EQ(open_error({files.path("mixed/?.*")}),
            "mixed/?.*: mixes formats: mixed/a.obj and mixed/b.ply" + one);
  EXPECT_EQ(open_error({files.path("cached")}), "cached: mixes formats: cached/a.obj and cached/a.pc2" + one);
  EXPECT_EQ(open_error({files.path("none/*.obj")}), "none/*.obj: matches no files; check the pattern");
  const std::string check = ": does not exist; check the name";
  EXPECT_EQ(open_error({files.path("none.obj")}), "none.obj" + check);
  EXPECT_EQ(open_error({files.path("none.gltf")}), "none.gltf" + check);
  EXPECT_EQ(open_error({files.path("none.npz")}), "none.npz" + check);
  EXPECT_EQ(open_error({files.write("a.xyz", "0 0 0")}),
            "a.xyz: is not a format that is read here; give .obj, .off, .ply, .stl, .vtp, .vtu, .vtk "
            "or .msh, .npz, .pvd, .gltf or .glb, or a mesh followed by its .pc2 or .mdd");
  for (const char* missing : {"none", "none.xyz", "only/none.fbx", "a.xyz/none.obj"})
    EXPECT_EQ(open_error({files.path(missing)}), missing + check);
  EXPECT_EQ(open_error({files.path("mixde")}), "mixde: does not exist; did you mean 'mixed'?");
  EXPECT_EQ(open_error({files.path("mixed/a.objj")}),
            "mixed/a.objj: does not exist; did you mean 'mixed/a.obj'?");
  EXPECT_EQ(open_error({files.write("a.FBX", "")}),
            "a.FBX: is not a format that is read here; open it in Blender, and export it as .glb or .obj");
  EXPECT_EQ(open_error({}), "arguments: no motion is named; name a mesh file or a directory");
  std::filesystem::create_directory(files.path("dir.obj"));
  EXPECT_EQ(open_error({files.path("dir.obj")}), "dir.obj" + no_mesh);
}

TEST_F(OpenTest, AGlobLeavesNothingOut) {
  files.write("run/f1.obj", obj_at(1));
  files.write("run/f2.obj.tmp", obj_at(2));
  files.write("run/f3.obj", obj_at(3));
  const std::string narrow =
      ", which is not a format that is read here; give a pattern that only the frames match, such as "
      "'run/*.obj'";
  EXPECT_EQ(open_error({files.path("run/*")}), "run/*: matches run/f2.obj.tmp" + narrow);
  EXPECT_EQ(open({files.path("run/*.obj")})->frame_count(), 2u);
  files.write("parts/f1.obj", obj_at(1));
  files.write("parts/deeper/f2.obj", obj_at(2));
  EXPECT_EQ(open_error({files.path("parts/*")}), "parts/*: matches parts/deeper" + narrow);
  EXPECT_EQ(open({files.path("parts/*.obj")})->frame_count(), 1u);
}

TEST_F(OpenTest, ADirectoryThatCannotBeReadIsAnError) {
  files.write("runs/a/f1.obj", obj_at(1));
  files.write("runs/readme.txt", "not a directory");
  std::error_code no_links;
  std::filesystem::create_symlink("nowhere", files.path("runs/gone"), no_links);
  if (no_links) GTEST_SKIP() << "no symbolic links";
  EXPECT_EQ(open({files.path("runs/*/f?.obj")})->frame_count(), 1u);
  std::filesystem::create_symlink("b", files.path("runs/b"));  // a loop, which root cannot read either
  const std::string listed = ": cannot be listed: Too many levels of symbolic links; check the permissions";
  EXPECT_EQ(open_error({files.path("runs/b/f?.obj")}), "runs/b" + listed);
  EXPECT_EQ(open_error({files.path("runs/b/f%d.obj")}), "runs/b/f%d.obj" + listed);
  EXPECT_EQ(open_error({files.path("none/f%d.obj")}),
            "none/f%d.obj: matches no files; %d stands for a number in their names");
}

TEST_F(OpenTest, NumbersThatAreLeftOutAreNoted) {
  using ::testing::ElementsAre;
  using ::testing::IsEmpty;
  const auto notes = [&](const std::vector<std::string>& names, const std::string& argument = "") {
    std::filesystem::remove_all(files.path("run"));
    for (const std::string& name : names) files.write("run/" + name, obj_at(1));
    return open({files.path("run" + argument)}, {.mesh_files = MeshFiles::Poses, .still = true})
        ->info()
        .notes;
  };
  const std::string gap = "frame numbers jump from 2 to 4: the step between them was not in the files";
  for (const char* argument : {"", "/*.obj", "/f%d.obj"}) {
    EXPECT_THAT(notes({"f0001.obj", "f0002.obj", "f0004.obj", "f0005.obj"}, argument), ElementsAre(gap));
    EXPECT_THAT(notes({"f7.obj", "f08.obj", "f9.obj", "f10.obj"}, argument), IsEmpty());
  }
  EXPECT_THAT(notes({"f2_high.obj", "f4_high.obj"}), ElementsAre(gap));
  EXPECT_THAT(
      notes({"f0.obj", "f2.obj", "f3.obj", "f6.obj", "f9.obj"}),
      ElementsAre("frame numbers jump from 0 to 2, and at 2 more places: the steps between them were not in "
                  "the files"));
  EXPECT_THAT(notes({"a.obj", "b.obj", "c.obj"}), IsEmpty()) << "nothing is numbered";
  EXPECT_THAT(notes({"d99999999999999999998.obj", "d99999999999999999999.obj"}), IsEmpty());
  const auto shell = open({files.write("s1.obj", obj_at(1)), files.write("s3.obj", obj_at(1))});
  EXPECT_EQ(shell->info().notes.size(), 1u);
  EXPECT_EQ(open({files.path("s1.obj"), files.path("s3.obj")}, {.weld = Weld::Always})->info().notes.size(),
            1u);
}

TEST_F(OpenTest, NamesThatDoNotContinueTheNumberingAreNoted) {
  using ::testing::ElementsAre;
  const auto notes = [&](const std::vector<std::string>& names, const std::string& argument = "run") {
    std::filesystem::remove_all(files.path("run"));
    for (const std::string& name : names) files.write("run/" + name, obj_at(1));
    return open({files.path(argument)}, {.mesh_files = MeshFiles::Sequence})->info().notes;
  };
  EXPECT_THAT(
      notes({"left_1.obj", "left_2.obj", "right_1.obj", "right_2.obj"}),
      ElementsAre("left_2.obj is followed by right_1.obj, which does not continue its numbering: these "
                  "may be two motions"));
  EXPECT_THAT(
      notes({"f01.obj", "f1.obj", "f2.obj"}),
      ElementsAre("f01.obj is followed by f1.obj, which does not continue its numbering: these may be "
                  "two motions"));
  EXPECT_THAT(
      notes({"1/f1.obj", "1/f2.obj", "2/f1.obj", "f.obj"}, "run/?/*.obj"),
      ElementsAre("1/f2.obj is followed by 2/f1.obj, which does not continue its numbering: these may "
                  "be two motions"));
  EXPECT_THAT(
      notes({"a1_b1.obj", "a1_b3.obj", "a2_b1.obj", "c.obj"}),
      ElementsAre("frame numbers jump from 1 to 3: the step between them was not in the files",
                  "a1_b3.obj is followed by a2_b1.obj, which does not continue its numbering, and at 1 "
                  "more places: these may be several motions"));
}

TEST_F(OpenTest, NegativeAndFractionalNumbersAreNotPutInAWrongOrder) {
  using ::testing::ElementsAre;
  const std::string rename = "; rename the frames by whole numbers from 0 on";
  const auto fill = [&](const std::vector<std::string>& names) {
    std::filesystem::remove_all(files.path("run"));
    for (std::size_t i = 0; i < names.size(); ++i)
      files.write("run/" + names[i], obj_at(static_cast<double>(i)));
  };
  // Each is in the order of the numbers; the third is what is sorted before the fourth.
  const auto refused = [&](const std::vector<std::string>& names, const std::string& a, const std::string& b,
                           const std::string& number) {
    fill(names);
    const std::string error =
        "run/" + a + ": is sorted before " + b + ", but comes after it if its number is " + number + rename;
    EXPECT_EQ(open_error({files.path("run")}), error);
    EXPECT_EQ(open_error({files.path("run/*.obj")}), error);
    std::vector<std::string> named;
    for (const std::string& name : names) named.push_back(files.path("run/" + name));
    EXPECT_EQ(open_error(named), error);
    EXPECT_EQ(open_error(named, {.mesh_files = MeshFiles::Separate}), "no error");
  };
  const auto accepted = [&](const std::vector<std::string>& names) {
    fill(names);
    const auto motion = open({files.path("run")});
    ASSERT_TRUE(motion);
    for (Index k = 0; k < motion->frame_count(); ++k) EXPECT_EQ(frame(*motion, k)[2], k) << names[k];
    EXPECT_THAT(motion->info().notes, ElementsAre());
  };
  refused({"f.-0002.obj", "f.-0001.obj", "f.0000.obj"}, "f.-0001.obj", "f.-0002.obj", "negative");
  refused({"f_-2.obj", "f_-1.obj"}, "f_-1.obj", "f_-2.obj", "negative");
  refused({"-2.obj", "-1.obj", "0.obj"}, "-1.obj", "-2.obj", "negative");
  refused({"f-2.obj", "f-1.obj", "f0.obj", "f1.obj"}, "f-1.obj", "f-2.obj", "negative");
  refused({"f_-1.50.obj", "f_-1.25.obj"}, "f_-1.25.obj", "f_-1.50.obj", "negative");
  refused({"f_1.25.obj", "f_1.5.obj"}, "f_1.5.obj", "f_1.25.obj", "a decimal fraction");
  refused({"f_1.05.obj", "f_1.1.obj"}, "f_1.1.obj", "f_1.05.obj", "a decimal fraction");
  fill({"f_1.obj", "f_1.5.obj", "f_2.obj"});
  EXPECT_EQ(
      open_error({files.path("run")}),
      "run/f_1.5.obj: is sorted before f_1.obj, but comes after it if its number is a decimal fraction" +
          rename);
  accepted({"a-9.obj", "a-10.obj", "a-11.obj"});
  accepted({"shot-01.obj", "shot-02.obj"});
  accepted({"2024-01-09.obj", "2024-01-10.obj"});
  accepted({"v1.2_003.obj", "v1.2_004.obj"});
  accepted({"v1.9.obj", "v1.10.obj"});
  accepted({"v1.99.obj", "v1.100.obj", "v1.101.obj"});
  accepted({"f_0.0001.obj", "f_0.0002.obj"});
  accepted({"f.1.obj", "f.2.obj", "f.3.obj"});
  fill({"f-1.obj", "f0.obj", "f1.obj"});
  EXPECT_EQ(
      open_error({files.path("run/f%d.obj")}),
      "run/f%d.obj: leaves out run/f-1.obj, whose number may be negative; rename the frames by whole numbers "
      "from 0 on, or move that file elsewhere");
}

TEST_F(OpenTest, NamesTheFirstFaceThatChanges) {
  const std::string points = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
  files.write("run/0.obj", points + "f 1 2 3 4\nf 1 2 3\nf 2 3 4\n");
  files.write("run/1.obj", points + "f 1 2 3\nf 1 3 4\nf 1 2 3\nf 2 3 4\n");
  files.write("run/2.obj", points + "f 1 2 3 4\nf 1 2 3\nf 2 4 3\n");
  files.write("run/3.obj", points + "v 0 0 0\nf 1 2 3 4\nf 1 2 3\nf 2 3 4\n");
  files.write("run/4.obj", points + "f 1 2 3 4\nf 1 2 3\n");
  files.write("run/5.obj", points + "f 1 2 3 4\nf 1 2 3\nf 2 3 4\nf 1 2 3\n");
  files.write("run/6.obj", points + "f 1 2 3 9\n");
  files.write("run/7.obj", "v 0 0 nan\n");
  const auto motion = open({files.path("run")});
  ASSERT_TRUE(motion);
  const std::string remedy =
      "; give frames of one mesh, with the same faces in the same order, or separate meshes (--separate)";
  EXPECT_EQ(frame_error(*motion, 0), "no error");
  EXPECT_EQ(frame_error(*motion, 1), "no error") << "the same triangles";
  EXPECT_EQ(frame_error(*motion, 2),
            "run/2.obj (frame 2): face 2 differs from the first frame's: triangle (1 3 2) instead of (1 2 "
            "3), counting "
            "from 0" +
                remedy);
  EXPECT_EQ(frame_error(*motion, 3),
            "run/3.obj (frame 3): has 5 vertices, but the first frame has 4" + remedy);
  EXPECT_EQ(frame_error(*motion, 4),
            "run/4.obj (frame 4): has 3 triangles, but the first frame has 4" + remedy);
  EXPECT_EQ(frame_error(*motion, 5),
            "run/5.obj (frame 5): has 5 triangles, but the first frame has 4" + remedy);
  EXPECT_EQ(frame_error(*motion, 6),
            "run/6.obj:5 (frame 6): face refers to vertex 9, but there are 4; export the mesh again");
  EXPECT_EQ(frame_error(*motion, 7),
            "run/7.obj:1 (frame 7): coordinate z of vertex 1 is not finite; "
            "export the mesh without NaN or infinite coordinates");
  std::filesystem::remove(files.path("run/7.obj"));
  EXPECT_EQ(frame_error(*motion, 7), "run/7.obj (frame 7): does not exist; check the name");
}

TEST_F(OpenTest, MemoryMotionReturnsItsFrames) {
  auto topology = Topology::make(3, {{0, 1, 2}});
  const auto motion =
      memory_motion("mine", *topology, {kTrianglePositions, {9, 8, 7, 6, 5, 4, 3, 2, 1}, {1, 2, 3}});
  EXPECT_EQ(motion->name(), "mine");
  EXPECT_EQ(motion->frame_count(), 3u);
  EXPECT_EQ(frame(*motion, 0), kTrianglePositions);
  EXPECT_EQ(frame(*motion, 1)[0], 9);
  EXPECT_EQ(frame_error(*motion, 2),
            "mine, frame 2: holds 3 numbers instead of 9; give every frame vertex_count x 3 numbers");
}

// --- Vertices in no face

std::string two_loose() { return "v 0 0 0\nv 9 9 9\nv 1 0 0\nv 0 1 0\nv 8 8 8\nf 1 3 4\n"; }

TEST_F(OpenTest, VerticesInNoFaceAreNamed) {
  const auto motion = open({files.write("a.obj", two_loose())});
  ASSERT_TRUE(motion);
  EXPECT_THAT(motion->info().unchecked, ElementsAre("2 vertices in no face were not checked"));
  EXPECT_EQ(motion->topology().point_count(), 0u);
  EXPECT_EQ(frame(*motion, 0).size(), 15u);
  const auto memory = memory_motion("m", *Topology::make(4, {{0, 1, 2}}), {std::vector<double>(12)});
  EXPECT_THAT(memory->info().unchecked, ElementsAre("1 vertex in no face was not checked"));
  const auto none = open({files.write("b.obj", obj_at(0))});
  EXPECT_THAT(none->info().unchecked, IsEmpty());
}

TEST_F(OpenTest, VerticesInNoFaceArePointsIfAskedFor) {
  const std::vector<std::string> arguments{files.write("a.obj", two_loose())};
  const auto motions = open_motions(arguments, {.points = true});
  ASSERT_TRUE(motions);
  const Motion& motion = *motions->front();
  EXPECT_THAT(motion.info().unchecked, IsEmpty());
  EXPECT_THAT(motion.topology().points(), ElementsAre(1, 4));
  EXPECT_EQ(motion.topology().face_count(), 1u);
}

TEST_F(OpenTest, LinesAndPointsThatAddNothingAreLeftOut) {
  ObjectParts parts{{"body", "arm"}, {0, 1}};
  const std::vector<Edge> lines{{1, 0}, {3, 4}, {4, 3}, {3, 4}, {0, 4}};
  const std::vector<Index> points{6, 0, 4, 5, 6};
  const auto topology = io::make_topology(8, {{0, 1, 2}, {2, 1, 3}}, lines, points, parts);
  ASSERT_TRUE(topology);
  EXPECT_THAT(topology->lines(), ElementsAre(Edge{3, 4}, Edge{0, 4}));
  EXPECT_THAT(topology->points(), ElementsAre(6, 5));
  EXPECT_THAT(parts.names, ElementsAre("body", "arm", "lines", "points"));
  EXPECT_THAT(parts.of_triangle, ElementsAre(0, 1, 2, 2, 3, 3));
  EXPECT_THAT(io::loose_vertices(*topology, {}), ElementsAre(7));
  EXPECT_THAT(io::loose_vertices(*topology, std::vector<Index>{0, 1, 2, 3, 4, 5, 6, 0}), IsEmpty());
  EXPECT_EQ(io::unchecked_vertices(*topology, 1), "1 vertex in no face and no line was not checked");
  EXPECT_FALSE(io::make_topology(4, {{0, 1, 2}}, std::vector<Edge>{{0, 7}}, {}, parts));
  EXPECT_FALSE(io::make_topology(4, {{0, 1, 2}}, {}, std::vector<Index>{7}, parts));
}

}  // namespace
}  // namespace foldproof::testing
