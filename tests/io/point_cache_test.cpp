#include "io/support.h"

namespace foldproof::testing {
namespace {

const char* const kObj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

std::string pc2(std::int32_t points, std::int32_t frames, const std::vector<float>& values) {
  std::string text = std::string("POINTCACHE2\0", 12) + bytes_of(std::int32_t{1}) + bytes_of(points) +
                     bytes_of(0.0f) + bytes_of(1.0f) + bytes_of(frames);
  for (const float x : values) text += bytes_of(x);
  return text;
}

std::string mdd(std::int32_t points, std::int32_t frames, const std::vector<float>& values) {
  const auto big = std::endian::big;
  std::string text = bytes_of(frames, big) + bytes_of(points, big);
  for (std::int32_t k = 0; k < frames && k < 100; ++k) text += bytes_of(float(k) / 24, big);
  for (const float x : values) text += bytes_of(x, big);
  return text;
}

const std::vector<float> kTwoFrames{1, 2, 3, 4, 5, 6, 7, 8, 9, -1, -2, -3, -4, -5, -6, -7, -8, -9};

class PointCacheTest : public IoTest {
 protected:
  std::string cache_error(const std::string& name, std::string_view text) {
    return open_error({files.write("a.obj", kObj), files.write(name, text)});
  }
};

TEST_F(PointCacheTest, ReadsFramesInAnyOrder) {
  const std::string mesh = files.write("a.obj", kObj);
  for (const std::string& cache :
       {files.write("a.pc2", pc2(3, 2, kTwoFrames)), files.write("a.MDD", mdd(3, 2, kTwoFrames))}) {
    SCOPED_TRACE(cache);
    const auto motion = open({mesh, cache});
    ASSERT_TRUE(motion);
    EXPECT_EQ(motion->name(), mesh);
    EXPECT_EQ(motion->frame_count(), 2u);
    EXPECT_EQ(triangles(*motion), kOneTriangle);
    EXPECT_EQ(frame(*motion, 1), (std::vector<double>{-1, -2, -3, -4, -5, -6, -7, -8, -9}));
    EXPECT_EQ(frame(*motion, 0), (std::vector<double>{1, 2, 3, 4, 5, 6, 7, 8, 9}));
    EXPECT_EQ(frame(*motion, 1)[0], -1);
  }
}

TEST_F(PointCacheTest, RefusesAFrameThatIsNotThereAndABufferOfTheWrongSize) {
  const auto motion = open({files.write("a.obj", kObj), files.write("a.pc2", pc2(3, 2, kTwoFrames))});
  ASSERT_TRUE(motion);
  EXPECT_EQ(frame_error(*motion, 2),
            "a.obj (frame 2): does not exist: there are 2 frames, counting from 0; ask for an earlier frame");
  std::vector<double> small(8);
  const auto read = motion->read_frame(0, small);
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().problem, "a frame is 9 numbers, but the buffer holds 8");
}

TEST_F(PointCacheTest, NamesFrameAndVertexThatIsNotFinite) {
  auto values = kTwoFrames;
  values[13] = std::numeric_limits<float>::quiet_NaN();
  const std::string mesh = files.write("a.obj", kObj);
  for (const std::string& cache :
       {files.write("a.pc2", pc2(3, 2, values)), files.write("a.mdd", mdd(3, 2, values))}) {
    const auto motion = open({mesh, cache});
    ASSERT_TRUE(motion);
    EXPECT_EQ(frame_error(*motion, 0), "no error");
    EXPECT_EQ(frame_error(*motion, 1).substr(1), ".x"[0] + cache.substr(cache.size() - 3) +
                                                     ", frame 1, vertex 1: a coordinate is not finite; "
                                                     "export the mesh without NaN or infinite coordinates");
  }
}

TEST_F(PointCacheTest, NamesWhatIsWrongWithAHeader) {
  const std::string again = "; copy or export the point cache again";
  EXPECT_EQ(cache_error("a.pc2", "POINT"), "a.pc2: is too short for a PC2 header; export the cache again");
  EXPECT_EQ(cache_error("a.pc2", std::string(40, 'x')),
            "a.pc2, byte 0: does not start with POINTCACHE2; export the cache as PC2 again");
  std::string version = pc2(3, 2, kTwoFrames);
  version[12] = 2;
  EXPECT_EQ(cache_error("a.pc2", version),
            "a.pc2, byte 12: PC2 version 2 is not known; export the cache as PC2 version 1");
  EXPECT_EQ(cache_error("a.pc2", pc2(-3, 2, kTwoFrames)),
            "a.pc2, byte 16: the number of points is negative; export the cache again");
  EXPECT_EQ(cache_error("a.pc2", pc2(3, -2, kTwoFrames)),
            "a.pc2, byte 28: the number of frames is negative; export the cache again");
  EXPECT_EQ(cache_error("a.pc2", pc2(3, 0, {})), "a.pc2: holds no frames; export the point cache again");
  EXPECT_EQ(
      cache_error("a.pc2", pc2(4, 2, kTwoFrames)),
      "a.pc2: moves 4 points, but a.obj has 3 vertices; name the mesh that this point cache was made from");
  EXPECT_EQ(cache_error("a.pc2", pc2(3, 3, kTwoFrames)),
            "a.pc2: header announces 3 frames of 36 bytes, but 72 bytes follow it" + again);
  EXPECT_EQ(cache_error("a.pc2", pc2(3, 1, kTwoFrames)),
            "a.pc2: header announces 1 frames of 36 bytes, but 72 bytes follow it" + again);
  EXPECT_EQ(cache_error("a.pc2", pc2(3, 2147483647, kTwoFrames)),
            "a.pc2: header announces 2147483647 frames of 36 bytes, but 72 bytes follow it" + again);
  EXPECT_EQ(cache_error("a.mdd", "1234567"), "a.mdd: is too short for an MDD header; export the cache again");
  EXPECT_EQ(cache_error("a.mdd", mdd(3, -1, {})),
            "a.mdd, byte 0: the number of frames is negative; export the cache again");
  EXPECT_EQ(cache_error("a.mdd", mdd(-3, 2, kTwoFrames)),
            "a.mdd, byte 4: the number of points is negative; export the cache again");
  EXPECT_EQ(cache_error("a.mdd", mdd(3, 0, {})), "a.mdd: holds no frames; export the point cache again");
  EXPECT_EQ(cache_error("a.mdd", mdd(3, 2147483647, kTwoFrames)),
            "a.mdd: header announces 2147483647 frames of 36 bytes, but 0 bytes follow it" + again);
}

TEST_F(PointCacheTest, NamesWhatIsMissing) {
  const std::string mesh = files.write("a.obj", kObj), cache = files.write("a.pc2", pc2(3, 2, kTwoFrames));
  EXPECT_EQ(open_error({cache}),
            "a.pc2: is a point cache without a mesh; name its mesh file right before it");
  EXPECT_EQ(open_error({mesh, cache, cache}),
            "a.pc2: is a point cache without a mesh; name its mesh file right before it");
  EXPECT_EQ(open_error({mesh, files.path("b.pc2")}), "b.pc2: does not exist; check the name");
  EXPECT_EQ(open_error({files.path("b.obj"), cache}), "b.obj: does not exist; check the name");
}

TEST_F(PointCacheTest, NoticesAFileThatShrinksWhileItIsRead) {
  const std::string cache = files.write("a.pc2", pc2(3, 2, kTwoFrames));
  const auto motion = open({files.write("a.obj", kObj), cache});
  ASSERT_TRUE(motion);
  std::filesystem::resize_file(cache, 70);
  EXPECT_EQ(frame_error(*motion, 0), "a.pc2: has been written to since it was opened; open it again");
  EXPECT_EQ(frame_error(*motion, 1),
            "a.pc2, byte 70: the file ends here, but more was expected; copy or export it again");
}

// Its frames would be those of another motion.
TEST_F(PointCacheTest, NoticesAFileThatIsWrittenAgain) {
  const std::string cache = files.write("a.pc2", pc2(3, 2, kTwoFrames));
  const auto motion = open({files.write("a.obj", kObj), cache});
  ASSERT_TRUE(motion);
  EXPECT_EQ(frame_error(*motion, 1), "no error");
  files.write("a.pc2", pc2(3, 2, kTwoFrames));
  std::filesystem::last_write_time(cache,
                                   std::filesystem::file_time_type::clock::now() + std::chrono::hours(1));
  EXPECT_EQ(frame_error(*motion, 1), "a.pc2: has been written to since it was opened; open it again");
}

}  // namespace
}  // namespace foldproof::testing
