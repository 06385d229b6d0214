// Which steps of a motion the bench measures, and where the vertices are in them.
#include "scene.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace foldproof::bench {
namespace {

Index measured_of(const std::vector<StepChoice>& steps) {
  return static_cast<Index>(
      std::count_if(steps.begin(), steps.end(), [](const StepChoice& step) { return step.measured; }));
}

// The place of a step in the motion, in parts.
Index place_of(const StepChoice& step) {
  return step.frame * static_cast<Index>(step.parts) + static_cast<Index>(step.part);
}

TEST(ChooseSteps, WarmsUpRightBeforeTheMiddle) {
  const auto steps = choose_steps(48, StepSize::Tenth, {.steps = 40, .all = false, .warm_up = 40});
  ASSERT_EQ(steps.size(), 80u);
  for (Index k = 0; k < steps.size(); ++k) {
    EXPECT_EQ(steps[k].measured, k >= 40);
    EXPECT_EQ(place_of(steps[k]), 175 + k);
  }
  // Warming up moves nothing that is measured.
  const auto plain = choose_steps(48, StepSize::Tenth, {.steps = 40, .all = false, .warm_up = 1});
  ASSERT_EQ(plain.size(), 41u);
  EXPECT_EQ(place_of(plain[1]), place_of(steps[40]));
}

TEST(ChooseSteps, WarmsUpAsFarAsTheMotionGoes) {
  const auto steps = choose_steps(48, StepSize::Full, {.steps = 40, .all = false, .warm_up = 40});
  EXPECT_EQ(measured_of(steps), 40u);
  ASSERT_EQ(steps.size(), 44u);
  EXPECT_EQ(place_of(steps[0]), 0u);
}

TEST(ChooseSteps, TakesPartsOfWholeSteps) {
  for (const StepSize size : {StepSize::Hundredth, StepSize::SmoothHundredth}) {
    const auto steps = choose_steps(48, size, {.steps = 40, .all = false, .warm_up = 40});
    EXPECT_EQ(measured_of(steps), 100u);
    EXPECT_EQ(std::count_if(steps.begin(), steps.end(),
                            [](const StepChoice& step) { return step.measured && step.part == 0; }),
              1)
        << "the motion turns once";
  }
}

TEST(ChooseSteps, RepeatsTheFirstStepWhereNoneIsBefore) {
  const auto steps = choose_steps(2, StepSize::Tenth, {.steps = 40, .all = false, .warm_up = 40});
  ASSERT_EQ(steps.size(), 11u);
  EXPECT_EQ(measured_of(steps), 10u);
  EXPECT_EQ(place_of(steps[0]), 0u);
  EXPECT_FALSE(steps[0].measured);
  EXPECT_EQ(place_of(steps[1]), 0u);
  EXPECT_EQ(measured_of(choose_steps(2, StepSize::Hundredth, {.steps = 40, .all = false, .warm_up = 40})),
            40u)
      << "a single step has no turns";
  EXPECT_EQ(choose_steps(2, StepSize::Full, {.steps = 40, .all = false, .warm_up = 40}).size(), 2u);
}

// A triangle whose first coordinate is given per frame.
std::unique_ptr<Motion> motion_through(const std::vector<double>& places) {
  auto topology = Topology::make(3, {{0, 1, 2}}).value();
  std::vector<std::vector<double>> frames;
  for (const double place : places) frames.push_back({place, 0, 0, 0, 1, 0, 0, 0, 1});
  return memory_motion("curve", topology, std::move(frames));
}

TEST(StepLoader, GoesSmoothlyThroughTheFrames) {
  const std::vector<double> places = {0, 1, 3, 2};
  const auto motion = motion_through(places);
  StepLoader loader(*motion);
  double last = places.front(), last_way = 0;
  for (const StepChoice& step :
       choose_steps(4, StepSize::SmoothHundredth, {.steps = 300, .all = true, .warm_up = 1})) {
    ASSERT_TRUE(loader.load(step));
    if (!step.measured) continue;
    EXPECT_EQ(loader.x0()[0], last) << "steps follow each other without a gap";
    if (step.part == 0) {
      EXPECT_EQ(loader.x0()[0], places[step.frame]);
    }
    const double way = loader.x1()[0] - loader.x0()[0];
    // Bends are spread: no step turns by more than a few hundredths of the way between two frames.
    if (place_of(step) > 0) {
      EXPECT_NEAR(way, last_way, 2e-3);
    }
    last = loader.x1()[0];
    last_way = way;
  }
  EXPECT_EQ(last, places.back());
}

TEST(StepLoader, CurvesAreStraightWhereTheMotionIs) {
  const auto motion = motion_through({0, 1, 2, 3});
  StepLoader loader(*motion);
  for (int part = 0; part < 10; ++part) {
    ASSERT_TRUE(loader.load({1, part, 10, true}));
    EXPECT_NEAR(loader.x0()[0], 1 + part / 10.0, 1e-15);
    EXPECT_NEAR(loader.x1()[0], 1 + (part + 1) / 10.0, 1e-15);
  }
}

}  // namespace
}  // namespace foldproof::bench
