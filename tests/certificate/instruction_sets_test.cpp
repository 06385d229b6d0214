// The same answers on every instruction set that this machine has, plain scalar code included.
#include <gtest/gtest.h>
#include <hwy/targets.h>

#include "certificate/patches.h"
#include "certificate/separating_plane.h"

namespace foldproof::testing {
namespace {

// Answers of chart_holds and plane_separates on many steps, half of them true.
std::vector<bool> answers() {
  std::vector<bool> all;
  Rng rng(41);
  ChartScratch scratch;
  for (int round = 0; round < 12; ++round) {
    for (const PosedPatch& p : drawable_patches(rng)) {
      Drawing drawing;
      if (draw(p.patch, p.x, drawing) != ChartOutcome::Made) continue;
      const Chart chart(p.patch, drawing);
      HalfPass control(0.05), plane_control(1);
      for (int k = 0; k < 20; ++k) {
        const Step step = random_step(p, control.size(), rng);
        all.push_back(chart_holds(chart.view(), step.vertices, k % 3 * 1e-3, scratch));
        control.tell(all.back());
        const std::size_t middle = 1 + rng() % (p.x.size() - 1);
        const std::span<const Index> ids(chart.vertices);
        const double gap = 0.01 * plane_control.size();
        all.push_back(plane_separates(step.vertices, ids.subspan(0, middle / 2 + 1), step.vertices,
                                      ids.subspan(middle / 2 + 1), gap));
        plane_control.tell(all.back());
      }
    }
  }
  return all;
}

struct OneTarget {
  explicit OneTarget(std::int64_t target) {
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  }
  ~OneTarget() {
    hwy::SetSupportedTargetsForTest(0);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  }
};

TEST(InstructionSets, AllAgree) {
  const std::vector<bool> expected = answers();
  const auto passes = std::count(expected.begin(), expected.end(), true);
  EXPECT_GT(passes, 0.3 * expected.size());
  EXPECT_LT(passes, 0.7 * expected.size());
  int targets = 0;
  const std::int64_t supported = hwy::SupportedTargets() | HWY_EMU128 | HWY_SCALAR;
  for (std::int64_t target = 1; target <= supported && target > 0; target <<= 1) {
    if ((supported & target) == 0) continue;
    const OneTarget only(target);
    EXPECT_TRUE(answers() == expected) << hwy::TargetName(target);
    ++targets;
  }
  EXPECT_GE(targets, 2);
}

}  // namespace
}  // namespace foldproof::testing
