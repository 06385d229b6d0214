// Predicted certificates: their answer is a part of the proven one, their misses grow with the miss rate, and
// they are counted.
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
  StepResult answer(StepChecker& checker, double from, double to, StepSettings settings) const {
    const auto x0 = bent(kShape.around, kShape.along, from), x1 = bent(kShape.around, kShape.along, to);
    StepResult result;
    EXPECT_TRUE(checker.check(x0, x1, settings, result));
    return result;
  }
  StepResult predicted(StepChecker& checker, double from, double to, double miss_rate) const {
    const auto x0 = bent(kShape.around, kShape.along, from), x1 = bent(kShape.around, kShape.along, to);
    std::vector<std::vector<std::uint8_t>> free;
    EXPECT_TRUE(predict_free_nodes(std::span(&model_, 1), x0, x1, miss_rate, free));
    return answer(checker, from, to, {.declared_free = &free});
  }

  std::shared_ptr<const Model> model_;
};

TEST_F(PaperMode, FindsAPartOfTheProvenAnswerWithLessWork) {
  StepChecker both = checker();
  std::uint64_t found = 0, proven_pairs = 0, leaf_pairs = 0, plain_pairs = 0;
  for (double angle = 0.5; angle < 7.5; angle += 0.5) {
    const StepResult guessed = predicted(both, angle, angle + 0.4, 1);
    const StepResult proven = answer(both, angle, angle + 0.4, {});
    const StepResult plain = answer(both, angle, angle + 0.4, {.certificates = false});
    const auto less = [](const auto& a, const auto& b) { return oracle::key(a) < oracle::key(b); };
    EXPECT_TRUE(std::includes(proven.vertex_face.begin(), proven.vertex_face.end(),
                              guessed.vertex_face.begin(), guessed.vertex_face.end(), less));
    EXPECT_TRUE(std::includes(proven.edge_edge.begin(), proven.edge_edge.end(), guessed.edge_edge.begin(),
                              guessed.edge_edge.end(), less));
    EXPECT_EQ(guessed.work.certificate_tests, 0u);
    found += guessed.vertex_face.size() + guessed.edge_edge.size();
    proven_pairs += proven.vertex_face.size() + proven.edge_edge.size();
    leaf_pairs += guessed.work.leaf_pairs;
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
      pairs += predicted(paper_checker, angle, angle + 0.4, miss_rate).work.leaf_pairs;
    EXPECT_GE(pairs, last) << miss_rate;
    last = pairs;
  }
}

TEST_F(PaperMode, DoesNotChangeLaterProvenAnswers) {
  StepChecker mixed = checker(), pure = checker();
  for (double angle = 5; angle < 7; angle += 0.5) {
    predicted(mixed, angle, angle + 0.4, 1);
    const StepResult a = answer(mixed, angle, angle + 0.4, {}), b = answer(pure, angle, angle + 0.4, {});
    EXPECT_EQ(a.vertex_face.size(), b.vertex_face.size());
    EXPECT_EQ(a.edge_edge.size(), b.edge_edge.size());
  }
}

TEST_F(PaperMode, NeedsLearnedCertificates) {
  Model nothing = *model_;
  nothing.learned = nullptr;
  const auto shared = std::make_shared<const Model>(nothing);
  const auto x = bent(kShape.around, kShape.along, 1);
  std::vector<std::vector<std::uint8_t>> free;
  const auto done = predict_free_nodes(std::span(&shared, 1), x, x, 0.01, free);
  ASSERT_FALSE(done);
  EXPECT_NE(done.error().line().find("at least 3 poses"), std::string::npos) << done.error().line();
  const std::vector<double> short_pose(3);
  EXPECT_FALSE(predict_free_nodes(std::span(&model_, 1), short_pose, short_pose, 0.01, free));
  EXPECT_FALSE(predict_free_nodes(std::span(&model_, 1), Positions(), x, 0.01, free)) << "no object";
}

}  // namespace
}  // namespace foldproof::testing
