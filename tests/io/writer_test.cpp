// Files appear complete or not at all, and written data can be read back.
#include <fcntl.h>

#include <random>

#include "io/support.h"

namespace foldproof::testing {
namespace {

class WriterTest : public IoTest {
 protected:
  std::vector<std::string> listing() const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(files.path(""))) {
      names.push_back(entry.path().filename().string());
    }
    std::sort(names.begin(), names.end());
    return names;
  }
};

TEST_F(WriterTest, AFileAppearsOnCommitOnly) {
  const std::string path = files.path("a.txt");
  {
    auto file = FileWriter::open(path);
    ASSERT_TRUE(file) << file.error().line();
    ASSERT_TRUE(file->write(std::string("hello ")));
    ASSERT_TRUE(file->write(std::string(1 << 20, 'x')));
    EXPECT_FALSE(std::filesystem::exists(path));
    EXPECT_EQ(listing().size(), 1u) << "the temporary file is beside the target";
    const std::string replacement = "HELLO";
    ASSERT_TRUE(file->rewrite(0, replacement));
    ASSERT_TRUE(file->write(std::string("!")));
    ASSERT_TRUE(file->commit());
  }
  EXPECT_EQ(read_bytes(path), "HELLO " + std::string(1 << 20, 'x') + "!");
  EXPECT_EQ(listing(), std::vector<std::string>{"a.txt"});
}

TEST_F(WriterTest, AbandonedFilesLeaveNothingAndKeepWhatWasThere) {
  const std::string path = files.write("a.txt", "old");
  {
    auto file = FileWriter::open(path);
    ASSERT_TRUE(file);
    ASSERT_TRUE(file->write(std::string(1 << 20, 'x')));
    FileWriter moved = std::move(*file);
    ASSERT_TRUE(moved.write(std::string("more")));
  }
  EXPECT_EQ(read_bytes(path), "old");
  EXPECT_EQ(listing(), std::vector<std::string>{"a.txt"});
}

TEST_F(WriterTest, TwoWritersOfOneTargetDoNotMix) {
  const std::string path = files.path("a.txt");
  auto one = FileWriter::open(path), two = FileWriter::open(path);
  ASSERT_TRUE(one && two);
  ASSERT_TRUE(one->write(std::string("one")) && two->write(std::string("two")));
  ASSERT_TRUE(one->commit());
  EXPECT_EQ(read_bytes(path), "one");
  ASSERT_TRUE(two->commit());
  EXPECT_EQ(read_bytes(path), "two");
}

TEST_F(WriterTest, FollowsLinksAndWritesIntoPipesAndDevices) {
  files.write("target.txt", "old");
  std::filesystem::create_symlink("target.txt", files.path("link.txt"));
  auto file = FileWriter::open(files.path("link.txt"));
  ASSERT_TRUE(file);
  ASSERT_TRUE(file->write(std::string("new")));
  ASSERT_TRUE(file->commit());
  EXPECT_TRUE(std::filesystem::is_symlink(files.path("link.txt")));
  EXPECT_EQ(read_bytes(files.path("target.txt")), "new");

  std::filesystem::create_symlink("later.txt", files.path("dangling.txt"));
  file = FileWriter::open(files.path("dangling.txt"));
  ASSERT_TRUE(file);
  ASSERT_TRUE(file->write(std::string("new")));
  ASSERT_TRUE(file->commit());
  EXPECT_TRUE(std::filesystem::is_symlink(files.path("dangling.txt")));
  EXPECT_EQ(read_bytes(files.path("later.txt")), "new");

  auto null = FileWriter::open("/dev/null");
  ASSERT_TRUE(null);
  ASSERT_TRUE(null->write(std::string("gone")));
  ASSERT_TRUE(null->commit());
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/null"));
}

TEST_F(WriterTest, WritesOnIntoWhatIsOpenAlready) {
  const int open = ::open(files.write("open.txt", "old ").c_str(), O_WRONLY | O_APPEND);
  ASSERT_GE(open, 0);
  std::filesystem::create_symlink("/dev/fd/" + std::to_string(open), files.path("link.txt"));
  for (const std::string& name : {files.path("link.txt"), "/proc/self/fd/" + std::to_string(open)}) {
    auto file = FileWriter::open(name);
    ASSERT_TRUE(file) << file.error().line();
    ASSERT_TRUE(file->write(std::string("new ")));
    EXPECT_FALSE(file->rewrite(0, std::string("x")));
    auto again = FileWriter::open(name);
    ASSERT_TRUE(again && again->write(std::string("new ")) && again->commit());
  }
  ::close(open);
  EXPECT_EQ(read_bytes(files.path("open.txt")), "old new new new new ");
  EXPECT_FALSE(FileWriter::open("/dev/fd/" + std::to_string(open)));
}

TEST_F(WriterTest, NamesTheTargetThatCannotBeWritten) {
  const auto error = [&](const std::string& name) {
    const auto file = FileWriter::open(files.path(name));
    return file ? "no error" : shown(file.error());
  };
  const std::string remedy = "; check the directory, its permissions and the free space";
  EXPECT_EQ(error("none/a.txt"), "none/a.txt: cannot be written: No such file or directory" + remedy);
  std::filesystem::create_directory(files.path("directory"));
  EXPECT_EQ(error("directory"), "directory: cannot be written: Is a directory" + remedy);
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "This system has no /dev/full.";
  auto full = FileWriter::open("/dev/full");
  ASSERT_TRUE(full);
  ASSERT_TRUE(full->write(std::string("x")));
  const auto committed = full->commit();
  ASSERT_FALSE(committed);
  EXPECT_EQ(committed.error().line(), "/dev/full: cannot be written: No space left on device" + remedy);
}

TEST_F(WriterTest, PlyKeepsPositionsTrianglesAndMarks) {
  const auto topology = Topology::make(3, {{0, 1, 2}, {2, 1, 1}});
  const std::vector<double> positions{0.1, -0.0, 1e300, 1, 2, 3, 4, 5, 6};
  const std::vector<std::uint8_t> marks{0, 255};
  for (const bool marked : {false, true}) {
    const auto given = marked ? std::span<const std::uint8_t>(marks) : std::span<const std::uint8_t>();
    ASSERT_TRUE(write_ply(files.path("a.ply"), *topology, positions, given));
    const auto motion = open({files.path("a.ply")});
    ASSERT_TRUE(motion);
    EXPECT_EQ(motion->topology(), *topology);
    EXPECT_EQ(frame(*motion, 0), positions);
    const std::string bytes = read_bytes(files.path("a.ply"));
    EXPECT_EQ(bytes.find("property uchar mark\n") != bytes.npos, marked);
    EXPECT_EQ(bytes.back() == '\xff', marked);
  }
  const std::vector<std::uint8_t> three(3);
  const auto wrong = write_ply(files.path("b.ply"), *topology, positions, three);
  ASSERT_FALSE(wrong);
  EXPECT_EQ(shown(wrong.error()),
            "b.ply: a mesh of 3 vertices and 2 triangles is to be written from 3 values of 'mark'; "
            "pass three numbers a vertex and one value a triangle");
  EXPECT_FALSE(std::filesystem::exists(files.path("b.ply")));
}

TEST_F(WriterTest, LinesAreWrittenWhereTheFormatHasThem) {
  const auto topology = *Topology::make(6, {{0, 1, 2}}, std::vector<Edge>{{4, 3}}, std::vector<Index>{5});
  const std::vector<double> positions(18, 0.5);
  const std::vector<std::uint8_t> marks{7, 8, 9};
  ASSERT_TRUE(write_obj(files.path("a.obj"), topology, positions));
  EXPECT_TRUE(read_bytes(files.path("a.obj")).ends_with("f 1 2 3\nl 5 4\np 6\n"));
  ASSERT_TRUE(write_ply(files.path("a.ply"), topology, positions, marks));
  const std::string ply = read_bytes(files.path("a.ply"));
  EXPECT_NE(
      ply.find("element face 1\nproperty list uchar int vertex_indices\nproperty uchar mark\n"
               "element edge 1\nproperty int vertex1\nproperty int vertex2\nproperty uchar mark\nend_header"),
      ply.npos);
  const char edge[] = {'\x07', 4, 0, 0, 0, 3, 0, 0, 0, 8};  // the face's mark, then the edge
  EXPECT_TRUE(ply.ends_with(std::string(edge, sizeof edge)));
  const auto motion = memory_motion("m", topology, {positions});
  const auto npz = write_npz(files.path("a.npz"), *motion);
  ASSERT_FALSE(npz);
  EXPECT_EQ(shown(npz.error()),
            "a.npz: is NPZ, which holds faces alone, and there are lines or points; name it .obj");
}

TEST_F(WriterTest, AFilePerFrameWhereTheNameHasANumber) {
  const auto topology = *Topology::make(3, {{0, 1, 2}});
  std::vector<std::vector<double>> frames{{0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 0, 0.1, 1, 0, 0, 0, 1, 0}};
  for (const char* extension : {".obj", ".ply"}) {
    const std::string name = files.path(std::string("shape_%03d") + extension);
    ASSERT_TRUE(write_motion(name, *memory_motion("two", topology, frames)));
    const auto read = open_motions(std::vector{name});
    ASSERT_TRUE(read);
    ASSERT_EQ(read->front()->frame_count(), 2u);
    std::vector<double> x(9);
    ASSERT_TRUE(read->front()->read_frame(1, x));
    EXPECT_EQ(x, frames[1]);
    EXPECT_TRUE(std::filesystem::exists(files.path(std::string("shape_001") + extension)));
  }
}

TEST_F(WriterTest, AMotionThatFailsHalfWayLeavesNoFiles) {
  const auto topology = Topology::make(3, {{0, 1, 2}});
  const auto motion = memory_motion("mine", *topology, {kTrianglePositions, {1, 2}});
  EXPECT_FALSE(write_npz(files.path("a.npz"), *motion));
  EXPECT_FALSE(write_obj_pc2(files.path("a.obj"), files.path("a.pc2"), *motion));
  auto far = kTrianglePositions;
  far[4] = 1e39;
  const auto huge = memory_motion("huge", *topology, {kTrianglePositions, far});
  const auto written = write_obj_pc2(files.path("a.obj"), files.path("a.pc2"), *huge);
  ASSERT_FALSE(written);
  EXPECT_EQ(shown(written.error()),
            "a.pc2, frame 1, vertex 1: a coordinate is too large for PC2, which holds 32-bit floats; write "
            "NPZ instead");
  EXPECT_TRUE(listing().empty());
}

/// A random motion: degenerate and duplicate triangles, unused vertices, numbers of every size.
struct RandomMotion {
  explicit RandomMotion(unsigned seed) : random(seed) {
    const Index vertices = 1 + random() % 40;
    std::vector<Triangle> triangles(1 + random() % 60);
    for (Triangle& t : triangles) {
      for (Index& v : t) v = static_cast<Index>(random() % vertices);
    }
    topology = *Topology::make(vertices, triangles);
    frames.resize(1 + random() % 4);
    for (auto& frame : frames) {
      for (Index i = 0; i < 3 * vertices; ++i) frame.push_back(number());
    }
  }
  // Single-precision values, which PC2 keeps exactly.
  double number() {
    const auto mantissa = static_cast<float>(static_cast<int>(random() % 20001) - 10000);
    return static_cast<double>(std::ldexp(mantissa / 7, static_cast<int>(random() % 200) - 100));
  }
  std::mt19937 random;
  Topology topology;
  std::vector<std::vector<double>> frames;
};

TEST_F(WriterTest, RandomMotionsReadBackAsTheyWere) {
  for (unsigned seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE(seed);
    const RandomMotion random(seed);
    const auto motion = memory_motion("random", random.topology, random.frames);
    ASSERT_TRUE(write_npz(files.path("a.npz"), *motion));
    ASSERT_TRUE(write_obj_pc2(files.path("a.obj"), files.path("a.pc2"), *motion));
    ASSERT_TRUE(write_ply(files.path("a.ply"), random.topology, random.frames[0], {}));
    const std::vector<std::vector<std::string>> ways{{files.path("a.npz")},
                                                     {files.path("a.obj"), files.path("a.pc2")},
                                                     {files.path("a.ply"), files.path("a.pc2")},
                                                     {files.path("a.obj")},
                                                     {files.path("a.ply")}};
    for (std::size_t way = 0; way < ways.size(); ++way) {
      SCOPED_TRACE(way);
      const auto read = open(ways[way]);
      ASSERT_TRUE(read);
      EXPECT_EQ(read->topology(), random.topology);
      ASSERT_EQ(read->frame_count(), way < 3 ? random.frames.size() : 1);
      for (Index k = 0; k < read->frame_count(); ++k) EXPECT_EQ(frame(*read, k), random.frames[k]);
    }
  }
}

TEST_F(WriterTest, RandomTextMeshesReadBackAsTheyWere) {
  for (unsigned seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE(seed);
    const RandomMotion random(seed);
    const auto& x = random.frames[0];
    const auto mesh_triangles = random.topology.triangles();
    std::ostringstream body, off, ply;
    body.precision(17);
    for (std::size_t i = 0; i < x.size(); i += 3) body << x[i] << ' ' << x[i + 1] << ' ' << x[i + 2] << '\n';
    for (const Triangle& t : mesh_triangles) body << "3 " << t[0] << ' ' << t[1] << ' ' << t[2] << '\n';
    off << "OFF\n" << x.size() / 3 << ' ' << mesh_triangles.size() << " 0\n" << body.str();
    ply << "ply\nformat ascii 1.0\nelement vertex " << x.size() / 3
        << "\nproperty double x\nproperty double y\nproperty double z\nelement face " << mesh_triangles.size()
        << "\nproperty list uchar uint vertex_indices\nend_header\n"
        << body.str();
    for (const auto& motion :
         {open({files.write("a.off", off.str())}), open({files.write("a.ply", ply.str())})}) {
      ASSERT_TRUE(motion);
      EXPECT_EQ(motion->topology(), random.topology);
      EXPECT_EQ(frame(*motion, 0), x);
    }
  }
}

}  // namespace
}  // namespace foldproof::testing
