// Learning from poses of known shapes.
#include <gmock/gmock.h>

#include "learned/learn.h"
#include "learned/scene.h"
#include "oracle/data.h"

namespace foldproof::testing {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TrainSettings all_energy() {
  TrainSettings settings;
  settings.learning.size.energy = 1;
  settings.learning.key_points = {.first_share = 0.05, .max_share = 0.1};
  return settings;
}

const std::vector<std::array<double, 2>> kAngles = {{0, 0},    {0.5, 0},     {1, 0.5},  {1.5, -0.5},
                                                    {-1, 0.5}, {-1.5, -0.5}, {-0.5, 0}, {0.8, 0.2}};

TEST(Learn, ReconstructsTrainingPoses) {
  const auto motion = bending_twice(kSmallTubeToLearn, kAngles);
  const Model model = trained(*motion, all_energy());
  ASSERT_TRUE(model.learned) << model.not_learned;
  const Learned& learned = *model.learned;
  EXPECT_LE(learned.pca.modes(), 7u);
  EXPECT_EQ(learned.coordinates.cols(), 8);
  EXPECT_LE(learned.key_points.vertices.size(), 30u);
  const Predictor predictor(model.learned);
  for (Index k = 0; k < 8; ++k) {
    const Eigen::VectorXd x = frame_of(*motion, k);
    const PoseError error = predictor.error(x);
    EXPECT_LT(error.total.worst, 1e-3 * learned.size) << k;
    EXPECT_LT(error.projection.worst, 1e-5 * learned.size) << k;
    EXPECT_LT((learned.pca.reconstruct(learned.coordinates.col(k)) - x).norm(), 1e-5 * x.norm());
    EXPECT_GT(learned.poses[k].leave_one_out.projection.mean, learned.poses[k].trained.projection.mean);
  }
  ASSERT_EQ(learned.poses.size(), 8u);
}

TEST(Learn, KernelPcaReconstructsTrainingPoses) {
  TrainSettings settings = all_energy();
  settings.learning.subspace = SubspaceKind::KernelPca;
  const auto motion = bending_twice(kSmallTubeToLearn, kAngles);
  const Model model = trained(*motion, settings);
  ASSERT_TRUE(model.learned) << model.not_learned;
  ASSERT_TRUE(model.learned->kernel);
  const Predictor predictor(model.learned);
  for (Index k = 0; k < 8; ++k) {
    EXPECT_LT(predictor.error(frame_of(*motion, k)).total.mean, 0.02 * model.learned->size) << k;
  }
}

TEST(Learn, PredictedMarginsDoNotDependOnPositionAndOrientation) {
  const auto motion = bending_twice(kSmallTubeToLearn, kAngles);
  const Model model = trained(*motion, all_energy());
  ASSERT_TRUE(model.learned && model.learned->certificates);
  const CertificateMap& map = *model.learned->certificates;
  EXPECT_EQ(map.nodes, predictable_nodes(*model.charts));
  EXPECT_THAT(map.nodes, Contains(model.hierarchy()->nodes().size() - 1));
  const KeyPointMap keys(model.learned->pca, model.learned->key_points.vertices);
  const Eigen::VectorXd k = keys.gather(frame_of(*motion, 2));
  Eigen::VectorXd moved = k;
  for (Eigen::Index i = 0; i < k.size(); i += 3) moved.segment<3>(i) << 5 - k[i + 1], k[i] + 7, k[i + 2] - 2;
  EXPECT_LT((map.margins(k) - map.margins(moved)).cwiseAbs().maxCoeff(), 1e-6);
  EXPECT_GT((map.align(k) - map.align(keys.gather(frame_of(*motion, 5)))).norm(), 1);  // shapes still differ
}

// A chart holds where its margin is positive, so margins agree with what training counts as proven.
TEST(Learn, MarginsArePositiveWhereLeavesAreProven) {
  const auto motion = bending_tube(kTube, {0, 1, 2, 6.2});
  const Model model = trained(*motion, {.references = 1, .learn = false});
  MarginMeter meter(model.charts);
  const auto nodes = predictable_nodes(*model.charts);
  ASSERT_GT(nodes.size(), 100u);
  const Eigen::VectorXd straight = frame_of(*motion, 0), curled = frame_of(*motion, 3);
  const auto margins_in = [&](const Eigen::VectorXd& x) {
    return meter.measure(nodes, std::span(x.data(), static_cast<std::size_t>(x.size())));
  };
  const Eigen::VectorXd in_straight = margins_in(straight), in_curled = margins_in(curled);
  EXPECT_GT(in_straight.minCoeff(), 0);
  EXPECT_LE(in_straight.maxCoeff(), 1);
  EXPECT_LT(in_curled.minCoeff(), 0);
  EXPECT_GT(in_straight.sum(), in_curled.sum());
}

TEST(Learn, PredictsCertificatesBetterThanTheMajority) {
  std::vector<double> angles;
  for (int k = 0; k < 24; ++k) angles.push_back(7.0 * ((k * 7) % 24) / 24);
  const Model model = trained(*bending_tube(kTube, angles), {.references = 1});
  ASSERT_TRUE(model.learned && model.learned->certificates);
  const CertificateMap& map = *model.learned->certificates;
  EXPECT_GT(map.balanced_accuracy, 0.9);
  EXPECT_GT(map.balanced_accuracy, map.majority_accuracy + 0.1);
}

TEST(Learn, RegionsMakeUpTheMeshAndTheWorstIsWherePosesDiffer) {
  // Only the far end of the tube moves as in no other pose.
  auto frames = std::vector<std::vector<double>>{};
  for (int k = 0; k < 6; ++k) frames.push_back(bent_twice(kSmallTubeToLearn, 0.1 * k, 0));
  const std::size_t last_ring = frames[3].size() - 3 * kSmallTubeToLearn.around;
  for (std::size_t i = last_ring; i < frames[3].size(); i += 3) frames[3][i + 2] += 0.5;
  const auto motion = memory_motion("tube", tube(kSmallTubeToLearn.around, kSmallTubeToLearn.along), frames);
  const Model model = trained(*motion, all_energy());
  ASSERT_TRUE(model.learned);
  const Learned& learned = *model.learned;
  Index leaves = 0;
  for (const LearnedRegion& r : learned.regions) {
    const auto& node = model.hierarchy()->nodes()[r.node];
    leaves += node.leaf_end - node.leaf_begin;
  }
  EXPECT_EQ(leaves, model.hierarchy()->leaf_count());
  const auto bad = badly_represented_regions(learned);
  ASSERT_FALSE(bad.empty());
  EXPECT_GE(3 * learned.regions[bad[0]].worst_vertex, last_ring);
  EXPECT_EQ(learned.regions[bad[0]].worst_pose, 3u);
  EXPECT_NEAR(learned.regions[bad[0]].worst, 0.5, 0.1);
  const auto poses = badly_represented_poses(learned);
  ASSERT_FALSE(poses.empty());
  EXPECT_EQ(poses[0], 3u);
}

// Of an even number of errors the median is between the two middle ones: 3 here, and 7 is more than twice it.
TEST(Learn, BadlyRepresentedIsMoreThanTwiceTheMedian) {
  const auto bad = [](std::vector<double> errors) {
    Learned learned;
    for (const double error : errors) learned.poses.emplace_back().leave_one_out.projection.mean = error;
    return badly_represented_poses(learned);
  };
  EXPECT_THAT(bad({1, 7, 5, 1}), ElementsAre(1u));
  EXPECT_THAT(bad({1, 6, 5, 1}), IsEmpty());
  EXPECT_THAT(bad({9, 2, 8, 3, 4}), ElementsAre(0u));
  EXPECT_THAT(bad({}), IsEmpty());
}

TEST(Learn, SaysWhyNothingWasLearned) {
  const auto model_of = [](const std::vector<double>& angles, bool learn = true) {
    return trained(*bending_tube(kSmallTube, angles), {.learn = learn});
  };
  EXPECT_EQ(model_of({0, 1}).learned, nullptr);
  EXPECT_EQ(model_of({0, 1}).not_learned, "too few poses");
  EXPECT_EQ(model_of({0, 1, 2}, false).not_learned, "not requested");
  EXPECT_THAT(model_of({1, 1, 1}).not_learned, HasSubstr("are all the same"));
  EXPECT_EQ(model_of({0, 1, 2}).not_learned, "");
}

TEST(Learn, ManyPosesAreSubsampled) {
  std::vector<double> angles;
  for (int k = 0; k < 20; ++k) angles.push_back(0.1 * k);
  TrainSettings settings;
  settings.learning.max_poses = 7;
  const Model model = trained(*bending_tube(kSmallTube, angles), settings);
  ASSERT_EQ(model.learned->poses.size(), 7u);
  EXPECT_EQ(model.learned->poses[3].pose, 8u);
}

TEST(LearnReal, TheHandIsReconstructedFromKeyPoints) {
  const auto data = oracle::data_directory();
  if (!data) GTEST_SKIP() << oracle::kNoData;
  const auto open = [&](const std::string& name) {
    return oracle::open_motion({*data / "hand" / (name + ".obj"), *data / "hand" / (name + ".pc2")});
  };
  const auto train = open("hand-train"), run = open("hand-anim");
  std::vector<TrainPose> poses;
  for (Index k = 0; k < 10; ++k) poses.push_back({train.get(), 4 * k});
  const auto model = train_model(poses, {.references = 1, .max_triangles = 64});
  ASSERT_TRUE(model) << model.error().line();
  const Predictor predictor(model->learned);
  EXPECT_LE(model->learned->key_points.vertices.size(), 35148 * 0.04);
  for (const Index frame : {0, 36, 72}) {
    const PoseError error = predictor.error(frame_of(*run, frame));
    EXPECT_LT(error.total.mean, 2 * error.projection.mean) << frame;
    EXPECT_GT(error.projection.mean, 0) << frame;
  }
}

}  // namespace
}  // namespace foldproof::testing
