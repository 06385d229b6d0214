// Look-ahead as a stage: a search extrapolates a motion, and its candidates serve the steps along it.
#include "check/candidate_cache.h"

#include <gtest/gtest.h>

#include "bvh/meshes.h"
#include "check/answer.h"
#include "check/stages.h"
#include "check/step.h"

namespace foldproof::oracle {
namespace {

// The first sheet rests. The second sinks by `speed` per unit of time, from a height of 0.6.
struct SinkingSheets {
  explicit SinkingSheets(double speed_of_sheet = 1) : speed(speed_of_sheet) {}

  Scene during(double begin, double end) const {
    const testing::Mesh sheet = testing::cloth(4);
    const auto at = [&](double time) {
      std::vector<double> x = sheet.positions;
      for (std::size_t i = 0; i < x.size(); i += 3) {
        x[i] = 0.17 + 0.9 * x[i];
        x[i + 1] += 0.03;
        x[i + 2] = 0.6 - speed * time;
      }
      return x;
    };
    Scene scene;
    add_object(scene, sheet.topology, sheet.positions, sheet.positions);
    add_object(scene, sheet.topology, at(begin), at(end));
    return scene;
  }
  double speed;
};

// ---- CandidateCache.

class CandidateCacheTest : public ::testing::Test {
 protected:
  // Fills the cache for the whole motion.
  CandidateCacheTest() : whole(sheets.during(0, 1)), objects(whole.hierarchies(4)), motion(objects) {
    EXPECT_TRUE(motion.update(whole.spans0(), whole.spans1()));
    const float margin = separation_margin(motion.frame(), 0.01);
    tasks.push_back({{&motion.bvhs()[0], &motion.bvhs()[1], margin}, 0, 1});
    for (Index i = 0; i < motion.hierarchy(0).leaf_count(); ++i) {
      for (Index k = 0; k < motion.hierarchy(1).leaf_count(); ++k)
        pairs.push_back({0, {LeafIndex(i), LeafIndex(k)}});
    }
    motion.fill_features(tasks, pairs);
    cache.fill(tasks, pairs, 0.01 * motion.frame().scale);
  }

  // Tests the part of the motion between two times.
  StepResult test(double begin, double end) {
    const Scene scene = sheets.during(begin, end);
    const auto x0 = scene.spans0(), x1 = scene.spans1();
    NarrowStep step({}, 0, motion.bvhs(), tasks, x0, x1);
    StepResult out;
    cache.test(step, {static_cast<float>(begin), static_cast<float>(end)}, scratch, out);
    finish({}, out);
    return out;
  }

  const SinkingSheets sheets;
  const Scene whole;
  const std::vector<Object> objects;
  StepMotion motion;
  std::vector<TraversalTask> tasks;
  std::vector<TaskLeaves> pairs;
  NarrowScratch scratch;
  CandidateCache cache;
};

// As by brute force, which takes no part in the cache.
TEST_F(CandidateCacheTest, FindsWhatTouchesInEachPartOfTheMotion) {
  std::size_t hits = 0;
  for (const auto& [begin, end] : {std::pair(0.0, 1.0), {0.0, 0.25}, {0.25, 0.5}, {0.5, 0.75}, {0.75, 1.0}}) {
    const StepResult found = test(begin, end);
    StepSettings settings;
    settings.within = false;
    const StepResult expected = brute_force_step(sheets.during(begin, end), settings, 0);
    const auto same = [](const auto& a, const auto& b) { return key(a) == key(b) && a.toi == b.toi; };
    EXPECT_TRUE(std::ranges::equal(found.vertex_face, expected.vertex_face, same)) << begin;
    EXPECT_TRUE(std::ranges::equal(found.edge_edge, expected.edge_edge, same)) << begin;
    hits += found.count();
    EXPECT_EQ(found.count() > 0, begin < 0.6 && 0.6 < end) << begin;
  }
  EXPECT_GT(hits, 100u);
}

// The sheets meet at time 0.6. Long before, no pair is tested.
TEST_F(CandidateCacheTest, TestsCandidatesOnlyWhenTheyMayTouch) {
  const auto candidates = [&](double begin, double end) {
    const Work work = test(begin, end).work;
    return work.candidates_vf + work.candidates_ee;
  };
  EXPECT_EQ(candidates(0, 0.25), 0u);
  EXPECT_GT(candidates(0.5, 0.75), 0u);
  EXPECT_EQ(candidates(0.75, 1), 0u);
}

// ---- LookAhead.

class LookAheadStage : public ::testing::Test {
 protected:
  // One step of a checker. Returns whether an earlier search covers it.
  bool step(const Scene& scene, const StepSettings& settings = {}) {
    StepResult out;
    EXPECT_TRUE(check_step({pipeline, &look_ahead}, scene.spans0(), scene.spans1(), settings, out));
    return out.search_steps == 0;
  }
  Scene at(int step) const { return sheets.during(kStep * step, kStep * (step + 1)); }

  // Steps along the motion until a search covers the last one. Returns the next step.
  int until_covered() {
    int next = 0;
    while (next < 20 && !step(at(next))) ++next;
    EXPECT_LT(next, 20) << "it never looks ahead";
    return next + 1;
  }

  static constexpr double kStep = 0.004;
  const SinkingSheets sheets;
  const std::vector<Object> objects = at(0).hierarchies(4);
  Pipeline pipeline{objects};
  LookAhead look_ahead;
};

TEST_F(LookAheadStage, CoversStepsWhileTheMotionContinues) {
  const int next = until_covered();
  EXPECT_TRUE(step(at(next)));
}

TEST_F(LookAheadStage, ForgetsTheSearchWhenItIsInvalidated) {
  const int next = until_covered();
  look_ahead.invalidate();
  EXPECT_FALSE(step(at(next)));
}

TEST_F(LookAheadStage, CoversNoStepThatLeavesTheMotion) {
  const int next = until_covered();
  Scene scene = at(next);
  scene.x1[1][3 * 7 + 2] += 0.01;  // one vertex
  EXPECT_FALSE(step(scene));
}

TEST_F(LookAheadStage, CoversNoStepWithOtherSettings) {
  int next = until_covered();
  for (const StepSettings& settings : {StepSettings{.within = false},
                                       {.between = false},
                                       {.thickness = 1e-9},
                                       {.tolerance = 1e-8},
                                       {.certificates = false},
                                       {.look_ahead = false},
                                       {.explain = true}}) {
    EXPECT_FALSE(step(at(next++), settings));
    while (!step(at(next))) ASSERT_LT(++next, 100);
    ++next;
  }
}

TEST_F(LookAheadStage, CoversNothingWhereItIsOff) {
  StepSettings settings;
  settings.look_ahead = false;
  for (int k = 0; k < 20; ++k) EXPECT_FALSE(step(at(k), settings));
}

// A plan after which no search follows, because the caller's update failed, leaves none behind.
TEST_F(LookAheadStage, CoversNoStepAfterAPlanWithoutASearch) {
  const int next = until_covered();
  Scene away = at(next);
  for (double& x : away.x1[1]) x += 0.3;
  const auto x0 = away.spans0(), x1 = away.spans1();
  EXPECT_FALSE(look_ahead.plan(pipeline.motion, x0, x1, {}).is_cache_hit());
  EXPECT_FALSE(step(at(next)));
}

}  // namespace
}  // namespace foldproof::oracle
