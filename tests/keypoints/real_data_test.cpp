#include <gtest/gtest.h>

#include "keypoints/choose.h"
#include "keypoints/pose_error.h"
#include "oracle/data.h"

namespace foldproof {
namespace {

// With few rounds: it tests that the parts fit together on a real mesh.
TEST(RealData, KeyPointsReconstructTheHand) {
  const auto data = oracle::data_directory();
  if (!data) GTEST_SKIP() << oracle::kNoData;
  const auto motion = oracle::open_motion({*data / "hand/hand-train.obj", *data / "hand/hand-train.pc2"});
  const Index size = 3 * motion->topology().vertex_count();
  const Index held_out = 20;
  Eigen::MatrixXd poses(size, 24);
  for (Index k = 0; k < 24; ++k) ASSERT_TRUE(motion->read_frame(k, {poses.col(k).data(), size}));

  const auto train = poses.leftCols(held_out);
  const auto subspace = pca(train, {0, 0.999});
  ASSERT_TRUE(subspace);
  EXPECT_LT(subspace->modes(), held_out);
  const auto chosen = choose_key_points({poses.col(0).data(), size}, train, *subspace, {0.02, 0.04, 0, 2});
  ASSERT_TRUE(chosen);
  EXPECT_LE(chosen->vertices.size(), 0.04 * size / 3);
  EXPECT_GE(chosen->vertices.size(), 0.019 * size / 3);
  const KeyPointMap map(*subspace, chosen->vertices);
  EXPECT_FALSE(map.rank_deficient());
  double from_all = 0, from_key_points = 0;
  for (Index k = held_out; k < 24; ++k) {
    const PoseError error = testing::pose_error(*subspace, map, poses.col(k));
    from_all += error.projection.mean;
    from_key_points += error.total.mean;
  }
  EXPECT_LE(from_key_points, 2 * from_all);
}

}  // namespace
}  // namespace foldproof
