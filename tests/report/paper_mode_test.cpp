// A check of a whole motion counts what the mode paper misses.
#include <gtest/gtest.h>

#include "foldproof/model.h"
#include "model/cylinder.h"
#include "report/report.h"

namespace foldproof::testing {
namespace {

TEST(PaperMode, IsComparedWithTheProvenAnswer) {
  constexpr TubeShape kShape{24, 40};
  const auto poses = bending_tube(kShape, {0, 1, 2, 3, 4, 5, 6, 7}, "poses");
  std::vector<std::unique_ptr<Motion>> motions;
  motions.push_back(bending_tube(kShape, {4, 5, 6, 7, 8}));
  CheckSettings settings;
  settings.paper_miss_rate = 1;
  const auto rejected = run_check(motions, settings, {});
  ASSERT_FALSE(rejected);
  EXPECT_NE(rejected.error().line().find("--model"), std::string::npos);
  settings.models = {std::make_shared<const Model>(*train_model(all_poses(*poses), {}))};
  const auto predicted = run_check(motions, settings, {});
  ASSERT_TRUE(predicted) << predicted.error().line();
  settings.paper_miss_rate.reset();
  const auto proven = run_check(motions, settings, {});
  ASSERT_TRUE(proven);
  EXPECT_EQ(proven->missed, 0u);
  EXPECT_GT(proven->collisions.sum(), 0u);
  EXPECT_EQ(predicted->collisions.sum() + predicted->missed, proven->collisions.sum());
  EXPECT_GT(predicted->proven_milliseconds, 0);
}

}  // namespace
}  // namespace foldproof::testing
