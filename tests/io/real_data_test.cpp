// Captured motions, if they are present: all open and have the documented sizes.
#include <gtest/gtest.h>

#include <chrono>

#include "foldproof/io.h"
#include "oracle/data_directory.h"

namespace foldproof {
namespace {

struct Expected {
  std::vector<std::string> files;
  Index vertices, triangles, frames;
};

class RealData : public ::testing::TestWithParam<Expected> {};

TEST_P(RealData, OpensWithTheDocumentedCounts) {
  const auto root = oracle::data_directory();
  if (!root) GTEST_SKIP() << oracle::kNoData;
  const Expected& expected = GetParam();
  std::vector<std::string> arguments;
  for (const std::string& file : expected.files) arguments.push_back(*root / file);
  auto motions = open_motions(arguments);
  ASSERT_TRUE(motions) << motions.error().line();
  ASSERT_EQ(motions->size(), 1u);
  Motion& motion = *motions->front();
  EXPECT_EQ(motion.topology().vertex_count(), expected.vertices);
  EXPECT_EQ(motion.topology().triangles().size(), expected.triangles);
  ASSERT_EQ(motion.frame_count(), expected.frames);
  std::vector<double> positions(std::size_t{3} * expected.vertices);
  for (Index k = 0; k < motion.frame_count(); ++k) {
    const auto read = motion.read_frame(k, positions);
    ASSERT_TRUE(read) << read.error().line();
  }
}

INSTANTIATE_TEST_SUITE_P(
    All, RealData,
    ::testing::Values(
        Expected{{"lion-poses"}, 5000, 9996, 10},
        Expected{{"lion-anim/lion-anim-loop1.obj", "lion-anim/lion-anim-loop1.pc2"}, 19994, 39984, 61},
        Expected{{"hand/hand-poses.obj", "hand/hand-poses.pc2"}, 35148, 70292, 8},
        Expected{{"hand/hand-train.obj", "hand/hand-train.pc2"}, 35148, 70292, 40},
        Expected{{"hand/hand-anim.obj", "hand/hand-anim.pc2"}, 35148, 70292, 73},
        Expected{{"horse-poses"}, 8431, 16843, 11},
        Expected{{"horse-gallop/horse-gallop.obj", "horse-gallop/horse-gallop.pc2"}, 8431, 16843, 25},
        Expected{{"elephant/elephant-poses.obj", "elephant/elephant-poses.pc2"}, 42321, 84638, 11},
        Expected{{"elephant/elephant-gallop.obj", "elephant/elephant-gallop.pc2"}, 42321, 84638, 25},
        Expected{{"samba/samba.obj", "samba/samba.pc2"}, 9971, 19938, 120},
        Expected{{"rumba/rumba.obj", "rumba/rumba.pc2"}, 12811, 25472, 80},
        Expected{{"ccd-ground-truth/cloth-ball/frame_*.ply"}, 46598, 92230, 2},
        Expected{{"ccd-ground-truth/rod-twist/frame_*.ply"}, 39940, 79864, 2},
        Expected{{"ccd-ground-truth/cloth-funnel/frame_*.ply"}, 9450, 18484, 2}));

}  // namespace
}  // namespace foldproof
