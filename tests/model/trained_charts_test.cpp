// Charts of a model, too, only remove work: every step has the same answer without them, bit for bit.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "check/animations.h"
#include "foldproof/check.h"
#include "foldproof/model.h"
#include "oracle/data.h"
#include "oracle/meshes.h"

namespace foldproof::oracle {
namespace {

class TrainedAnimations : public ::testing::TestWithParam<AnimationFamily> {
 protected:
  Rng rng_{81};
  Animation animation_ = GetParam().make(rng_);
};

// Models of a few poses, of all, and of one only.
TEST_P(TrainedAnimations, HaveTheAnswersOfUntrainedOnes) {
  for (const std::size_t stride : {4, 13, 1000}) {
    std::vector<Object> trained, untrained;
    for (std::size_t object = 0; object < animation_.topologies.size(); ++object) {
      std::vector<Pose> poses;
      for (std::size_t k = 0; k < animation_.poses.size(); k += stride)
        poses.push_back(animation_.poses[k][object]);
      const auto motion = memory_motion("animation", animation_.topologies[object], poses);
      std::vector<TrainPose> chosen;
      for (Index k = 0; k < motion->frame_count(); ++k) chosen.push_back({motion.get(), k});
      const Result<Model> model = train_model(chosen, {});
      ASSERT_TRUE(model) << model.error().line();
      trained.push_back(model->object());
      untrained.push_back(model->hierarchy());
    }
    Comparison both(trained, untrained);
    for (std::size_t k = 0; k + 1 < animation_.poses.size(); ++k) {
      ASSERT_NO_FATAL_FAILURE(both.step(animation_.poses[k], animation_.poses[k + 1], {})) << "step " << k;
      ASSERT_NO_FATAL_FAILURE(both.pose(animation_.poses[k])) << "pose " << k;
    }
    EXPECT_GT(both.sums.passes, 50u);
    EXPECT_LT(both.sums.pairs_with, both.sums.pairs_without);
  }
}

INSTANTIATE_TEST_SUITE_P(Generated, TrainedAnimations,
                         ::testing::ValuesIn(generated_animations().begin(), generated_animations().end()),
                         [](const auto& instance) { return std::string(instance.param.name); });

class TrainedRealAnimations : public ::testing::TestWithParam<const char*> {};

TEST_P(TrainedRealAnimations, HaveTheAnswersOfUntrainedOnes) {
  const auto data = data_directory();
  if (!data) GTEST_SKIP() << kNoData;
  if (!all_frames()) GTEST_SKIP() << "Training takes long. Set FOLDPROOF_ALL_FRAMES=1 to run this test.";
  const auto motion = open_real_motion(*data, GetParam());
  const auto frame = [&](Index k) {
    std::vector<Pose> pose{Pose(3 * std::size_t{motion->topology().vertex_count()})};
    EXPECT_TRUE(motion->read_frame(k, pose[0]));
    return pose;
  };
  // Trained on every tenth frame; all of them become references, or one.
  for (const Index references : {0, 1}) {
    std::vector<TrainPose> chosen;
    for (Index k = 0; k < motion->frame_count(); k += 10) chosen.push_back({motion.get(), k});
    TrainSettings training;
    training.references = references;
    const Result<Model> model = train_model(chosen, training);
    ASSERT_TRUE(model) << model.error().line();
    Comparison both({model->object()}, {model->hierarchy()});
    for (Index k = 0; k + 1 < motion->frame_count(); ++k)
      ASSERT_NO_FATAL_FAILURE(both.step(frame(k), frame(k + 1), {})) << "frame " << k;
    EXPECT_GT(both.sums.passes, 0u);
  }
}

INSTANTIATE_TEST_SUITE_P(Motions, TrainedRealAnimations,
                         ::testing::Values("lion_anim", "hand_anim", "horse_gallop", "elephant_gallop",
                                           "samba", "rumba", "cloth_ball"),
                         [](const auto& instance) { return std::string(instance.param); });

}  // namespace
}  // namespace foldproof::oracle
