// What a step costs, told by counters that no machine and no instruction set has a say in: node tests,
// certificate tests, pairs of leaves, candidates. A change that needs more than a tenth more of any of them
// on the bench's generated motions fails here. Where the price is worth it, or much less is needed, put the
// counts that the test prints in place of the old ones below, and say why in the commit.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <hwy/targets.h>

#include "foldproof/check.h"
#include "generated.h"
#include "scene.h"

namespace foldproof::bench {
namespace {

struct Counts {
  std::uint64_t node_tests, certificate_tests, leaf_pairs, candidates;
  bool operator==(const Counts&) const = default;
};

std::string as_source(const Counts& c) {
  return fmt::format("{{{}, {}, {}, {}}}", c.node_tests, c.certificate_tests, c.leaf_pairs, c.candidates);
}

// Of a new checker's `steps` tenth steps from the middle of a motion, and the one before, together.
Counts counts_of(Motion& motion, Index steps, bool ahead) {
  StepLoader loader(motion);
  std::vector<double> x(std::size_t{motion.topology().vertex_count()} * 3);
  EXPECT_TRUE(motion.read_frame(0, x));
  auto hierarchy = Hierarchy::build(motion.topology(), x).value();
  StepChecker checker({std::make_shared<const Hierarchy>(std::move(hierarchy))});
  StepResult result;
  Counts counts{};
  for (const StepChoice& step :
       choose_steps(motion.frame_count(), StepSize::Tenth, {.steps = steps, .all = false})) {
    EXPECT_TRUE(loader.load(step));
    const std::span<const double> x0 = loader.x0(), x1 = loader.x1();
    EXPECT_TRUE(checker.check(x0, x1, {.look_ahead = ahead}, result));
    counts.node_tests += result.work.node_tests;
    counts.certificate_tests += result.work.certificate_tests;
    counts.leaf_pairs += result.work.leaf_pairs;
    counts.candidates += result.work.candidates_vf + result.work.candidates_ee;
  }
  return counts;
}

struct Bound {
  const char* name;
  std::unique_ptr<Motion> (*make)();
  Counts ahead, each;  ///< With searches that look ahead; with one for each step.
};

void PrintTo(const Bound& bound, std::ostream* out) { *out << bound.name; }

class Work : public ::testing::TestWithParam<Bound> {};

TEST_P(Work, IsNoMoreThanRecorded) {
  for (const bool ahead : {true, false}) {
    const Counts recorded = ahead ? GetParam().ahead : GetParam().each;
    const Counts counts = counts_of(*GetParam().make(), 20, ahead);
    SCOPED_TRACE(fmt::format("the counts of {}, {}, are {}", GetParam().name, ahead ? "ahead" : "each step",
                             as_source(counts)));
    const auto within = [](std::uint64_t now, std::uint64_t then) {
      return static_cast<double>(now) <= 1.1 * static_cast<double>(then);
    };
    EXPECT_PRED2(within, counts.node_tests, recorded.node_tests);
    EXPECT_PRED2(within, counts.certificate_tests, recorded.certificate_tests);
    EXPECT_PRED2(within, counts.leaf_pairs, recorded.leaf_pairs);
    EXPECT_PRED2(within, counts.candidates, recorded.candidates);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Generated, Work,
    ::testing::Values(
        Bound{"bending_cylinder", bending_cylinder, {117783, 625, 12599, 0}, {247608, 2085, 12714, 0}},
        Bound{"folding_cloth", folding_cloth, {354680, 1168, 57106, 0}, {580749, 2190, 57106, 0}},
        Bound{"pressed_cloths",
              pressed_cloths,
              {983962, 124064, 116075, 255304},
              {2291706, 434317, 178335, 135226}},
        Bound{"ball_heap", ball_heap, {365133, 4542, 55273, 5886}, {1139052, 35650, 87141, 758}}),
    [](const auto& info) { return info.param.name; });

// On every instruction set that this machine has, plain scalar code included.
TEST(Work, DoesNotDependOnTheInstructionSet) {
  const auto motion = bending_cylinder();
  const Counts expected = counts_of(*motion, 6, true);
  EXPECT_GT(expected.certificate_tests, 0u);
  int targets = 0;
  const std::int64_t supported = hwy::SupportedTargets() | HWY_EMU128 | HWY_SCALAR;
  for (std::int64_t target = 1; target <= supported && target > 0; target <<= 1) {
    if ((supported & target) == 0) continue;
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    const Counts counts = counts_of(*motion, 6, true);
    EXPECT_EQ(counts, expected) << hwy::TargetName(target) << ": " << as_source(counts);
    ++targets;
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  EXPECT_GT(targets, 2);
}

}  // namespace
}  // namespace foldproof::bench
