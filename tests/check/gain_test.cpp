// When steps ask for certificates: where that saves work, and hardly ever where it does not.
#include "check/gain.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "check/motion.h"
#include "foldproof/check.h"

namespace foldproof {
namespace {

// Pairs of leaves that are left when certificates are asked for, and when they are not.
struct Motion {
  std::uint64_t with, without, leaves;
};

// How many of the steps ask.
int asked_in(CullingGain& gain, int steps, const Motion& motion, bool trained = false) {
  int asked = 0;
  for (int step = 0; step < steps; ++step) {
    const bool asks = gain.begin(trained);
    asked += asks;
    CullingGain::Counts counts;
    counts.leaves = motion.leaves;
    counts.leaf_pairs = asks ? motion.with : motion.without;
    gain.took(counts);
  }
  return asked;
}

constexpr Motion kFree{100, 1000, 250}, kDense{950, 1000, 250}, kCalm{20, 200, 50};

TEST(CullingGain, WhoAsksOncePaysForNoLearning) {
  CullingGain gain;
  EXPECT_FALSE(gain.begin(false));
  gain.took({});
  EXPECT_TRUE(gain.begin(false));
}

TEST(CullingGain, TrainedChartsAreAskedAtOnce) {
  CullingGain gain;
  EXPECT_TRUE(gain.begin(true));
}

TEST(CullingGain, CertificatesThatSaveAreAlwaysAskedFor) {
  CullingGain gain;
  EXPECT_EQ(asked_in(gain, 1000, kFree), 999);
}

TEST(CullingGain, CertificatesThatSaveNothingRest) {
  CullingGain gain;
  const int at_first = asked_in(gain, 20, kDense);
  EXPECT_GE(at_first, 1) << "they must be tried";
  EXPECT_LE(at_first, 8);
  EXPECT_LE(asked_in(gain, 1000, kDense), 40);
}

TEST(CullingGain, WhereContactIsDenseFromTheStartNothingIsLearned) {
  const auto second_asks = [](std::uint64_t leaf_pairs, double sweep_growth) {
    CullingGain gain;
    gain.begin(false);
    CullingGain::Counts counts;
    counts.leaves = 100;
    counts.leaf_pairs = leaf_pairs;
    counts.sweep_growth = sweep_growth;
    gain.took(counts);
    return gain.begin(false);
  };
  EXPECT_TRUE(second_asks(400, 1.1));
  EXPECT_FALSE(second_asks(1400, 1.1));
  EXPECT_TRUE(second_asks(1400, 3)) << "boxes of what moves far meet without contact";
}

// Ten times as many pairs as leaves, but the charts are there and save nearly all of it.
TEST(CullingGain, TrainedChartsThatSaveAreUsedInDenseContact) {
  CullingGain gain;
  EXPECT_GE(asked_in(gain, 1000, {100, 2000, 100}, true), 998);
}

// What charts are there from a training is judged like what is drawn on the way.
TEST(CullingGain, TrainedChartsThatSaveNothingRest) {
  CullingGain gain;
  EXPECT_LE(asked_in(gain, 1000, kDense, true), 60);
}

TEST(CullingGain, RestsEndWhenContactEnds) {
  CullingGain gain;
  asked_in(gain, 1000, kDense);
  EXPECT_GE(asked_in(gain, 10, kCalm), 7);
}

TEST(CullingGain, TheLastStepOfARestSaysThatTheNextAsks) {
  CullingGain gain;
  bool foretold = false;
  for (int step = 0; step < 300; ++step) {
    const bool asks = gain.begin(false);
    EXPECT_TRUE(step == 0 || asks == foretold) << "step " << step;
    foretold = gain.used_next();
    gain.took({.leaf_pairs = asks ? kDense.with : kDense.without, .leaves = kDense.leaves});
    if (!foretold || gain.used_next()) continue;
    foretold = false;  // the step that ended the trial began a rest
  }
}

// A step without certificates from long ago is no measure: from time to time one shows how it is now.
TEST(CullingGain, WhatStopsSavingIsFoundOut) {
  CullingGain gain;
  asked_in(gain, 1000, kFree);
  EXPECT_LE(asked_in(gain, 1000, kDense), 60);
}

// ---- In a checker.

constexpr Index kCells = 12;

// Sheets above each other.
Topology stacked_sheets(Index sheets) {
  std::vector<Triangle> triangles;
  const Index row = kCells + 1;
  for (Index s = 0; s < sheets; ++s) {
    for (Index j = 0; j < kCells; ++j) {
      for (Index i = 0; i < kCells; ++i) {
        const Index a = s * row * row + j * row + i;
        triangles.push_back({a, a + 1, a + row + 1});
        triangles.push_back({a, a + row + 1, a + row});
      }
    }
  }
  return Topology::make(sheets * row * row, std::move(triangles)).value();
}

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
  std::uint64_t first_tested, second_tested;  // certificates
};

TwoSteps two_steps(Index sheets, const std::vector<double>& x1) {
  const auto x0 = positions(sheets, 0);
  const auto tree = std::make_shared<const Hierarchy>(Hierarchy::build(stacked_sheets(sheets), x0).value());
  StepChecker checker({tree});
  const std::span<const double> from[] = {x0}, to[] = {x1};
  StepSettings settings;
  settings.ahead = false;
  settings.max_listed = 0;
  StepResult first, second;
  EXPECT_TRUE(checker.check(from, to, settings, first));
  EXPECT_TRUE(checker.check(from, to, settings, second));
  return {static_cast<double>(first.work.leaf_pairs) / tree->leaf_count(), first.work.certificate_tests,
          second.work.certificate_tests};
}

// All sheets turn over, so that boxes of leaves above each other meet.
std::vector<double> turned_over(Index sheets) {
  auto x = positions(sheets, 0);
  for (std::size_t i = 2; i < x.size(); i += 3) x[i] = 0.1 * sheets - x[i];
  return x;
}

// What "dense" means: a surface by itself is far from it, whatever its size.
TEST(CullingGain, ASurfaceByItselfIsLearnedFromTheSecondStepOn) {
  const TwoSteps steps = two_steps(1, turned_over(1));
  EXPECT_LT(steps.pairs_per_leaf, 8);
  EXPECT_EQ(steps.first_tested, 0u);
  EXPECT_GT(steps.second_tested, 0u);
}

TEST(CullingGain, SheetsThatPassThroughEachOtherAreNotLearned) {
  const TwoSteps steps = two_steps(24, turned_over(24));
  EXPECT_GT(steps.pairs_per_leaf, 12);
  EXPECT_EQ(steps.first_tested, 0u);
  EXPECT_EQ(steps.second_tested, 0u);
}

TEST(CullingGain, ASheetThatFliesFarIsLearned) {
  auto x1 = positions(1, 0);
  for (std::size_t i = 0; i < x1.size(); ++i) {
    if (i % 3 < 2) x1[i] = 100 - x1[i];  // every two leaves change sides
  }
  const TwoSteps steps = two_steps(1, x1);
  EXPECT_GT(steps.pairs_per_leaf, 10);
  EXPECT_GT(steps.second_tested, 0u);
}

// What StepSettings::explain promises; tests lean on it to use certificates where they do not pay. A first
// step has none yet, but makes them.
TEST(CullingGain, AStepThatIsExplainedAlwaysUsesCertificates) {
  const auto x0 = positions(24, 0), x1 = turned_over(24);
  StepChecker checker({Hierarchy::build(stacked_sheets(24), x0).value()});
  StepSettings settings;
  settings.explain = true;
  settings.max_listed = 0;
  StepResult result;
  for (int step = 0; step < 3; ++step) {
    ASSERT_TRUE(checker.check(x0, x1, settings, result));
    EXPECT_EQ(result.work.certificate_tests > 0, step > 0) << "step " << step;
    EXPECT_EQ(result.searched, 1u);
  }
}

// One leaf, 2 wide and 4 deep, goes 3 along its width: 5 and 4 instead of 2 and 4.
TEST(StepMotion, SweepGrowthIsThatOfTheSidesOfLeaves) {
  const std::vector<double> x0{0, 0, 0, 2, 0, 0, 0, 4, 0}, x1{3, 0, 0, 5, 0, 0, 3, 4, 0};
  const Object triangle(Hierarchy::build(Topology::make(3, {{0, 1, 2}}).value(), x0).value());
  StepMotion motion(std::span(&triangle, 1));
  ASSERT_TRUE(motion.update(x0, x1));
  EXPECT_NEAR(motion.sweep_growth(), 9.0 / 6, 1e-4);
  ASSERT_TRUE(motion.update(x0, x0));
  EXPECT_EQ(motion.sweep_growth(), 1);
  const std::vector<double> point(9, 1);
  ASSERT_TRUE(motion.update(point, point));
  EXPECT_EQ(motion.sweep_growth(), 1) << "nothing to compare with";
}

}  // namespace
}  // namespace foldproof
