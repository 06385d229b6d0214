// Shapes drawn from a model.
#include <gmock/gmock.h>

#include "base/parallel.h"
#include "foldproof/check.h"
#include "model/cylinder.h"

namespace foldproof::testing {
namespace {

using ::testing::HasSubstr;

/// Learned from tubes whose ends nearly meet, on either side.
Model model_of_bent_tubes() { return trained(*bending_tube(kSmallTube, {-4.5, -2, 0, 2, 4.5})); }

std::vector<std::vector<double>> frames_of(Motion& motion) {
  std::vector<std::vector<double>> frames;
  for (Index k = 0; k < motion.frame_count(); ++k) {
    const auto done =
        motion.read_frame(k, frames.emplace_back(3 * std::size_t{motion.topology().vertex_count()}));
    EXPECT_TRUE(done);
  }
  return frames;
}

TEST(Sample, NoShapeCrossesItself) {
  const Model model = model_of_bent_tubes();
  const auto samples = sample_shapes(model, {.count = 40, .spread = 1.2});
  ASSERT_TRUE(samples) << samples.error().line();
  EXPECT_EQ(samples->shapes->frame_count(), 40u);
  EXPECT_GT(samples->drawn, 42u) << "none was refused, so that this shows nothing";
  EXPECT_LT(samples->drawn, 200u);
  StepChecker exact({model.hierarchy()});
  for (const auto& x : frames_of(*samples->shapes)) {
    const std::span<const double> positions[] = {x};
    StaticResult found;
    ASSERT_TRUE(exact.check_static(positions, {.certificates = false}, found));
    EXPECT_EQ(found.crossing_count, 0u);
    for (const double c : x) ASSERT_EQ(c, static_cast<float>(c));
  }
}

TEST(Sample, VariesAsTheTrainingPosesDo) {
  const Model model = trained(*bending_tube(kSmallTube, {-1, -0.5, 0, 0.5, 1}));
  const auto samples = sample_shapes(model, {.count = 200, .spread = 0.5});
  ASSERT_TRUE(samples);
  EXPECT_EQ(samples->drawn, 200u) << "a refusal would change the distribution";
  double square = 0;
  for (const auto& x : frames_of(*samples->shapes)) {
    const double p =
        model.learned->pca.project(Eigen::Map<const Eigen::VectorXd>(x.data(), std::ssize(x)))[0];
    square += p * p / 200;
  }
  EXPECT_NEAR(std::sqrt(square) / model.learned->pca.deviations[0], 0.5, 0.1);
}

TEST(Sample, TheSameSeedGivesTheSameShapes) {
  const Model model = model_of_bent_tubes();
  const auto one = frames_of(*sample_shapes(model, {.count = 5})->shapes);
  {
    const ThreadLimit limit(1);
    EXPECT_EQ(one, frames_of(*sample_shapes(model, {.count = 5})->shapes));
  }
  EXPECT_NE(one, frames_of(*sample_shapes(model, {.count = 5, .seed = 2})->shapes));
}

TEST(Sample, SaysWhatIsWrong) {
  const Model model = model_of_bent_tubes();
  const auto error = [](const Model& of, const SampleSettings& settings, const TrainHooks& hooks = {}) {
    const auto samples = sample_shapes(of, settings, hooks);
    return samples ? std::string("no error") : samples.error().line();
  };
  EXPECT_THAT(error(model, {.count = 0}), HasSubstr("count: is 0"));
  EXPECT_THAT(error(model, {.spread = 0}), HasSubstr("spread"));
  const Model closed = trained(*bending_tube(kSmallTube, {7, 7.2, 7.4}));
  EXPECT_THAT(error(closed, {.spread = 0.1}), HasSubstr("crosses itself in all but 0 of 1001 shapes"));
  const std::atomic<bool> cancel = true;
  EXPECT_THAT(error(model, {}, {.cancel = &cancel}), HasSubstr("interrupted"));
  TrainSettings settings;
  settings.learn = false;
  EXPECT_THAT(error(trained(*bending_tube(kSmallTube, {0, 1, 2}), settings), {}),
              HasSubstr("has learned no shapes"));
}

}  // namespace
}  // namespace foldproof::testing
