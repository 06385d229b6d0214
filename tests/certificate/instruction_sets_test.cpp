// All instruction sets of this machine, scalar code included, give the same answers.
#include <gtest/gtest.h>

#include "certificate/patches.h"
#include "certificate/separating_plane.h"
#include "oracle/one_target.h"

namespace foldproof::testing {
namespace {

// Answers of chart_holds and plane_separates on many steps; about half are true.
std::vector<bool> answers() {
  std::vector<bool> all;
  Rng rng(41);
  ChartScratch scratch;
  for (int round = 0; round < 12; ++round) {
    for (const PosedPatch& p : chartable_patches(rng)) {
      UvMap uv_map;
      if (parametrize(p.patch, p.x, uv_map) != ChartOutcome::Made) continue;
      const Chart chart(p.patch, uv_map);
      HalfPass control(0.05), plane_control(1);
      for (int k = 0; k < 20; ++k) {
        const Step step = random_step(p, control.size(), rng);
        all.push_back(chart_holds(chart.view(), step.vertices, k % 3 * 1e-3, scratch));
        control.record(all.back());
        const std::size_t middle = 1 + rng() % (p.x.size() - 1);
        const std::span<const Index> ids(chart.vertices);
        const double gap = 0.01 * plane_control.size();
        all.push_back(plane_separates(step.vertices, ids.subspan(0, middle / 2 + 1), step.vertices,
                                      ids.subspan(middle / 2 + 1), gap));
        plane_control.record(all.back());
      }
    }
  }
  return all;
}

TEST(InstructionSets, AllAgree) {
  const std::vector<bool> expected = answers();
  const auto passes = std::count(expected.begin(), expected.end(), true);
  EXPECT_GT(passes, 0.3 * expected.size());
  EXPECT_LT(passes, 0.7 * expected.size());
  expect_all_targets_agree(answers);
}

}  // namespace
}  // namespace foldproof::testing
