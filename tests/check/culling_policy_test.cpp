// Steps use certificates where that saves work, and hardly ever where it does not.
#include "check/culling_policy.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "check/motion.h"
#include "foldproof/check.h"
#include "mesh/grid.h"

namespace foldproof {
namespace {

// Pairs of leaves per step, with and without certificates.
struct Motion {
  std::uint64_t with, without, leaves;
};

// How many of the steps use certificates.
int used_steps(CullingPolicy& policy, int steps, const Motion& motion, bool trained = false) {
  int used = 0;
  for (int step = 0; step < steps; ++step) {
    const bool uses = policy.begin_step(trained);
    used += uses;
    CullingPolicy::Counts counts;
    counts.leaves = motion.leaves;
    counts.leaf_pairs = uses ? motion.with : motion.without;
    policy.end_step(counts);
  }
  return used;
}

constexpr Motion kFree{100, 1000, 250}, kDense{950, 1000, 250}, kCalm{20, 200, 50};

TEST(CullingPolicy, AFirstStepDoesNotUseThem) {
  CullingPolicy policy;
  EXPECT_FALSE(policy.begin_step(false));
  policy.end_step({});
  EXPECT_TRUE(policy.begin_step(false));
}

TEST(CullingPolicy, TrainedChartsAreUsedAtOnce) {
  CullingPolicy policy;
  EXPECT_TRUE(policy.begin_step(true));
}

TEST(CullingPolicy, UsesThemWhileTheySave) {
  CullingPolicy policy;
  EXPECT_EQ(used_steps(policy, 1000, kFree), 999);
}

TEST(CullingPolicy, BacksOffWhileTheySaveNothing) {
  CullingPolicy policy;
  const int at_first = used_steps(policy, 20, kDense);
  EXPECT_GE(at_first, 1) << "they must be tried first";
  EXPECT_LE(at_first, 8);
  EXPECT_LE(used_steps(policy, 1000, kDense), 40);
}

TEST(CullingPolicy, DoesNotStartInDenseContact) {
  const auto uses_in_second_step = [](std::uint64_t leaf_pairs, double swept_extent_ratio) {
    CullingPolicy policy;
    policy.begin_step(false);
    CullingPolicy::Counts counts;
    counts.leaves = 100;
    counts.leaf_pairs = leaf_pairs;
    counts.swept_extent_ratio = swept_extent_ratio;
    policy.end_step(counts);
    return policy.begin_step(false);
  };
  EXPECT_TRUE(uses_in_second_step(400, 1.1));
  EXPECT_FALSE(uses_in_second_step(1400, 1.1));
  EXPECT_TRUE(uses_in_second_step(1400, 3)) << "after large displacements boxes overlap without contact";
}

// More than ten pairs per leaf, but there are charts already, which prove nearly all of them.
TEST(CullingPolicy, TrainedChartsThatSaveAreUsedInDenseContact) {
  CullingPolicy policy;
  EXPECT_GE(used_steps(policy, 1000, {100, 2000, 100}, true), 998);
}

// Trained charts are judged like those that are built during the run.
TEST(CullingPolicy, BacksOffFromTrainedChartsThatSaveNothing) {
  CullingPolicy policy;
  EXPECT_LE(used_steps(policy, 1000, kDense, true), 60);
}

TEST(CullingPolicy, BackOffEndsWithTheContact) {
  CullingPolicy policy;
  used_steps(policy, 1000, kDense);
  EXPECT_GE(used_steps(policy, 10, kCalm), 7);
}

TEST(CullingPolicy, KnowsWhetherTheNextStepUsesThem) {
  CullingPolicy policy;
  bool predicted = false;
  for (int step = 0; step < 300; ++step) {
    const bool uses = policy.begin_step(false);
    EXPECT_TRUE(step == 0 || uses == predicted) << "step " << step;
    predicted = policy.uses_next();
    policy.end_step({.leaf_pairs = uses ? kDense.with : kDense.without, .leaves = kDense.leaves});
    if (!predicted || policy.uses_next()) continue;
    predicted = false;  // the end of this step started a back-off
  }
}

// A cost without certificates goes out of date, so a step without them measures it from time to time.
TEST(CullingPolicy, NoticesWhenTheyStopSaving) {
  CullingPolicy policy;
  used_steps(policy, 1000, kFree);
  EXPECT_LE(used_steps(policy, 1000, kDense), 60);
}

// ---- In a checker.

constexpr Index kCells = 12;

// Of sheets above each other.
std::vector<double> positions(Index sheets, double up) {
  std::vector<double> x;
  for (Index s = 0; s < sheets; ++s) {
    for (Index j = 0; j <= kCells; ++j) {
      for (Index i = 0; i <= kCells; ++i)
        x.insert(x.end(), {i + 0.3 * (s % 2), 1.0 * j, 0.01 * std::sin(i) + 0.1 * s + up});
    }
  }
  return x;
}

struct TwoSteps {
  double pairs_per_leaf;                      // without certificates
  std::uint64_t first_tested, second_tested;  // certificates in each step
};

TwoSteps two_steps(Index sheets, const std::vector<double>& x1) {
  const auto x0 = positions(sheets, 0);
  const auto tree = std::make_shared<const Hierarchy>(
      Hierarchy::build(testing::Grid{kCells, kCells}.topology(sheets), x0).value());
  StepChecker checker({tree});
  const std::span<const double> from[] = {x0}, to[] = {x1};
  StepSettings settings;
  settings.look_ahead = false;
  settings.max_listed = 0;
  StepResult first, second;
  EXPECT_TRUE(checker.check(from, to, settings, first));
  EXPECT_TRUE(checker.check(from, to, settings, second));
  return {static_cast<double>(first.work.leaf_pairs) / tree->leaf_count(), first.work.certificate_tests,
          second.work.certificate_tests};
}

// All sheets are turned over as a stack, so that boxes of leaves above each other overlap.
std::vector<double> turned_over(Index sheets) {
  auto x = positions(sheets, 0);
  for (std::size_t i = 2; i < x.size(); i += 3) x[i] = 0.1 * sheets - x[i];
  return x;
}

// A surface by itself is not dense contact, whatever its size.
TEST(CullingPolicy, StartsInTheSecondStepOfASurface) {
  const TwoSteps steps = two_steps(1, turned_over(1));
  EXPECT_LT(steps.pairs_per_leaf, 8);
  EXPECT_EQ(steps.first_tested, 0u);
  EXPECT_GT(steps.second_tested, 0u);
}

TEST(CullingPolicy, DoesNotStartWhereSheetsPassThroughEachOther) {
  const TwoSteps steps = two_steps(24, turned_over(24));
  EXPECT_GT(steps.pairs_per_leaf, 12);
  EXPECT_EQ(steps.first_tested, 0u);
  EXPECT_EQ(steps.second_tested, 0u);
}

// Not so far that the step is cut in time.
TEST(CullingPolicy, StartsWhereASheetMovesFar) {
  auto x1 = positions(1, 0);
  for (std::size_t i = 0; i < x1.size(); i += 3) {
    const double u = x1[i], v = x1[i + 1];
    x1[i] += 8 * std::sin(0.7 * v);
    x1[i + 1] += 8 * std::sin(0.7 * u);
  }
  const TwoSteps steps = two_steps(1, x1);
  EXPECT_GT(steps.pairs_per_leaf, 10);
  EXPECT_GT(steps.second_tested, 0u);
}

// As StepSettings::explain documents; tests rely on it. A first step has no charts yet, but requests them.
TEST(CullingPolicy, ExplainedStepsAlwaysUseThem) {
  const auto x0 = positions(24, 0), x1 = turned_over(24);
  StepChecker checker({Hierarchy::build(testing::Grid{kCells, kCells}.topology(24), x0).value()});
  StepSettings settings;
  settings.explain = true;
  settings.max_listed = 0;
  StepResult result;
  for (int step = 0; step < 3; ++step) {
    ASSERT_TRUE(checker.check(x0, x1, settings, result));
    EXPECT_EQ(result.work.certificate_tests > 0, step > 0) << "step " << step;
    EXPECT_EQ(result.search_steps, 1u);
  }
}

// One leaf, 2 wide and 4 deep, moves by 3 along its width: its swept sides are 5 and 4 instead of 2 and 4.
TEST(StepMotion, SweptExtentRatioIsThatOfTheLeavesSides) {
  const std::vector<double> x0{0, 0, 0, 2, 0, 0, 0, 4, 0}, x1{3, 0, 0, 5, 0, 0, 3, 4, 0};
  const Object triangle(Hierarchy::build(Topology::make(3, {{0, 1, 2}}).value(), x0).value());
  StepMotion motion(std::span(&triangle, 1));
  ASSERT_TRUE(motion.update(x0, x1));
  EXPECT_NEAR(motion.swept_extent_ratio(), 9.0 / 6, 1e-4);
  ASSERT_TRUE(motion.update(x0, x0));
  EXPECT_EQ(motion.swept_extent_ratio(), 1);
  const std::vector<double> point(9, 1);
  ASSERT_TRUE(motion.update(point, point));
  EXPECT_EQ(motion.swept_extent_ratio(), 1) << "nothing to compare with";
}

}  // namespace
}  // namespace foldproof
