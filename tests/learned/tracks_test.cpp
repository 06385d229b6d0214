// Key-point tracks of every kind.
#include <fmt/format.h>

#include "io/support.h"
#include "learned/scene.h"

namespace foldproof::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

const std::vector<Index> kVertices = {7, 2};

class TracksTest : public IoTest {
 protected:
  Result<KeyPointTracks> read(const std::string& text) {
    return read_key_point_tracks(files.write("a.csv", text), kVertices);
  }
  std::string error(const std::string& text) {
    const auto tracks = read(text);
    return tracks ? "no error" : shown(tracks.error());
  }
};

TEST_F(TracksTest, TheLongTableComesInAnyOrder) {
  const auto tracks = read(
      "z,frame,vertex,x,y\n"
      "3,10,2,1,2\n9,10,99,9,9\n6,10,7,4,5\n"
      "0.5,11,7,0,0\n0.25,11,2,0,0\n");
  ASSERT_TRUE(tracks) << tracks.error().line();
  EXPECT_EQ(tracks->frames, 2u);
  EXPECT_EQ(tracks->points, 2u);
  EXPECT_THAT(tracks->positions, ElementsAre(4, 5, 6, 1, 2, 3, 0, 0, 0.5, 0, 0, 0.25));
}

TEST_F(TracksTest, ARowPerFrame) {
  const auto tracks = read("1,2,3,4,5,6\n7,8,9,10,11,12\n");
  ASSERT_TRUE(tracks) << tracks.error().line();
  EXPECT_EQ(tracks->frames, 2u);
  EXPECT_THAT(tracks->positions, ElementsAre(1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12));
}

TEST_F(TracksTest, ErrorsNameWhatIsWrong) {
  EXPECT_THAT(error("0,7,1,2,3\n"), HasSubstr("a.csv: lacks key points, for example in frame 0; "));
  EXPECT_THAT(error("0,7,1,2,3\n0,7,1,2,3\n0,2,1,2,3\n"), HasSubstr("has vertex 7 twice in frame 0; "));
  EXPECT_THAT(error("0,7,1,2,3\n0,2,1,2,3\n1,7,1,2,3\n1,3,1,2,3\n"), HasSubstr("example in frame 1; "));
  const std::string two = "0,7,1,2,3\n0,2,1,2,3\n1,7,1,2,3\n1,2,1,2,3\n";
  const std::string all = "; number frames one after the other, and give all of them";
  EXPECT_EQ(error(two + "4,7,1,2,3\n4,2,1,2,3\n"), "a.csv: lacks frame 2: frame 4 follows frame 1" + all);
  EXPECT_EQ(error(two + "-2,7,1,2,3\n-2,2,1,2,3\n"), "a.csv: lacks frame -1: frame 0 follows frame -2" + all);
  EXPECT_EQ(error(two + "1.5,7,1,2,3\n1.5,2,1,2,3\n"), "a.csv: has frame 1.5 right after frame 1" + all);
  EXPECT_THAT(error("frame,vertex,x,y,w\n0,7,1,2,3\n"), HasSubstr("has no column 'z'; "));
  EXPECT_THAT(error("1,2,3\n"), HasSubstr("has 3 columns, and the model has 2 key points; "));
}

TEST_F(TracksTest, FromAnArrayOfAnNpz) {
  // A motion's array 'vertices' has the right kind, but another name.
  const auto motion = memory_motion("a", *Topology::make(3, kOneTriangle), {kTrianglePositions});
  ASSERT_TRUE(write_npz(files.path("a.npz"), *motion));
  std::string bytes = read_bytes(files.path("a.npz"));
  for (std::size_t at; (at = bytes.find("vertices.npy")) != bytes.npos;)
    bytes.replace(at, 12, "keypoint.npy");
  const auto tracks = read_key_point_tracks(files.write("b.npz", bytes), kVertices);
  ASSERT_FALSE(tracks);
  EXPECT_THAT(shown(tracks.error()), HasSubstr("b.npz: holds no array 'keypoints'; "));
}

TEST_F(TracksTest, FromAMotion) {
  const auto motion = bending_tube(kSmallTube, {0, 1, 2});
  const std::vector<Index> frames = {2, 0};
  const auto tracks = extract_tracks(*motion, kVertices, frames);
  ASSERT_TRUE(tracks);
  EXPECT_EQ(tracks->frames, 2u);
  const auto x = frame(*motion, 2), y = frame(*motion, 0);
  EXPECT_THAT(tracks->positions,
              ElementsAre(x[21], x[22], x[23], x[6], x[7], x[8], y[21], y[22], y[23], y[6], y[7], y[8]));
}

TEST_F(TracksTest, PredictionIsAMotion) {
  const auto poses = bending_tube(kSmallTube, {0, 0.5, 1, 1.5, 2});
  const Model model = trained(*poses);
  const auto predictor = std::make_shared<const Predictor>(model.learned);
  const std::vector<Index> frames = {3, 1};
  auto tracks = extract_tracks(*poses, model.learned->key_points.vertices, frames);
  ASSERT_TRUE(tracks);
  const auto motion = predicted_motion("p", poses->topology(), predictor, *tracks);
  ASSERT_EQ(motion->frame_count(), 2u);
  EXPECT_EQ(frame_of(*motion, 1),
            predictor->from_key_points(predictor->key_point_map().gather(frame_of(*poses, 1))));
  tracks->positions[0] = 1e308;
  tracks->positions[3] = -1e308;
  const auto far = predicted_motion("p", poses->topology(), predictor, *tracks);
  EXPECT_THAT(frame_error(*far, 0), HasSubstr("is too far away to compute with"));
}

}  // namespace
}  // namespace foldproof::testing
