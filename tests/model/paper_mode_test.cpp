// Mode::Paper: its answer is a part of the proven one, its misses grow with the miss rate, and they are
// counted.
#include <gtest/gtest.h>

#include <algorithm>

#include "foldproof/check.h"
#include "foldproof/model.h"
#include "model/cylinder.h"
#include "oracle/brute_force.h"

namespace foldproof::testing {
namespace {

constexpr TubeShape kShape{24, 40};

class PaperMode : public ::testing::Test {
 protected:
  PaperMode() {
    auto poses = bending_tube(kShape, {0, 1, 2, 3, 4, 5, 6, 7}, "poses");
    model_ = std::make_shared<const Model>(*train_model(all_poses(*poses), {}));
  }

  StepChecker checker() const { return StepChecker({model_->object()}); }
  StepResult answer(StepChecker& checker, double from, double to, const StepSettings& settings) const {
    const auto x0 = bent(kShape.around, kShape.along, from), x1 = bent(kShape.around, kShape.along, to);
    const std::span<const double> a[] = {x0}, b[] = {x1};
    StepResult result;
    EXPECT_TRUE(checker.check(a, b, settings, result));
    return result;
  }

  std::shared_ptr<const Model> model_;
};

StepSettings paper(double miss_rate) { return {.mode = Mode::Paper, .miss_rate = miss_rate}; }

TEST_F(PaperMode, FindsAPartOfTheProvenAnswerWithLessWork) {
  StepChecker both = checker();
  std::uint64_t found = 0, proven_pairs = 0, leaf_pairs = 0, plain_pairs = 0;
  for (double angle = 0.5; angle < 7.5; angle += 0.5) {
    const StepResult predicted = answer(both, angle, angle + 0.4, paper(1));
    const StepResult proven = answer(both, angle, angle + 0.4, {});
    const StepResult plain = answer(both, angle, angle + 0.4, {.certificates = false});
    const auto less = [](const auto& a, const auto& b) { return oracle::key(a) < oracle::key(b); };
    EXPECT_TRUE(std::includes(proven.vertex_face.begin(), proven.vertex_face.end(),
                              predicted.vertex_face.begin(), predicted.vertex_face.end(), less));
    EXPECT_TRUE(std::includes(proven.edge_edge.begin(), proven.edge_edge.end(), predicted.edge_edge.begin(),
                              predicted.edge_edge.end(), less));
    EXPECT_EQ(predicted.work.certificate_tests, 0u);
    found += predicted.vertex_face.size() + predicted.edge_edge.size();
    proven_pairs += proven.vertex_face.size() + proven.edge_edge.size();
    leaf_pairs += predicted.work.leaf_pairs;
    plain_pairs += plain.work.leaf_pairs;
  }
  EXPECT_GT(proven_pairs, 0u);
  EXPECT_LE(found, proven_pairs);
  EXPECT_LT(2 * leaf_pairs, plain_pairs);
}

// The lower the miss rate, the fewer predictions are accepted.
TEST_F(PaperMode, AcceptsFewerPredictionsAtALowerMissRate) {
  StepChecker paper_checker = checker();
  std::uint64_t last = 0;
  for (const double miss_rate : {1.0, 0.1, 0.01, 0.0}) {
    std::uint64_t pairs = 0;
    for (double angle = 1; angle < 7; ++angle)
      pairs += answer(paper_checker, angle, angle + 0.4, paper(miss_rate)).work.leaf_pairs;
    EXPECT_GE(pairs, last) << miss_rate;
    last = pairs;
  }
}

TEST_F(PaperMode, DoesNotChangeLaterProvenAnswers) {
  StepChecker mixed = checker(), pure = checker();
  for (double angle = 5; angle < 7; angle += 0.5) {
    answer(mixed, angle, angle + 0.4, paper(1));
    const StepResult a = answer(mixed, angle, angle + 0.4, {}), b = answer(pure, angle, angle + 0.4, {});
    EXPECT_EQ(a.vertex_face.size(), b.vertex_face.size());
    EXPECT_EQ(a.edge_edge.size(), b.edge_edge.size());
  }
}

TEST_F(PaperMode, NeedsAPredictor) {
  StepChecker without({model_->charts});
  const auto x = bent(kShape.around, kShape.along, 1);
  const std::span<const double> pose[] = {x};
  StepResult result;
  const auto done = without.check(pose, pose, paper(0.01), result);
  ASSERT_FALSE(done);
  EXPECT_NE(done.error().line().find("at least 3 poses"), std::string::npos) << done.error().line();
}

}  // namespace
}  // namespace foldproof::testing
