#include <gmock/gmock.h>

#include "report/sinking_triangle.h"

namespace foldproof {
namespace {

using namespace foldproof::testing;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// Remembers what it was told.
struct Recorder : ReportWriter {
  struct Seen {
    StepIndex index;
    CollisionCounts collisions;
    double earliest_toi;
    std::vector<std::vector<double>> x0, x1;
  };
  struct Log {
    std::vector<std::vector<TriangleCrossing>> starts;
    std::vector<Seen> steps;
    int finished = 0;
  };
  explicit Recorder(Log& log) : log(log) {}
  Result<void> start(const CheckedStep& s) override {
    EXPECT_TRUE(log.steps.empty());
    EXPECT_EQ(s.step, nullptr);
    EXPECT_EQ(s.explanation, nullptr);
    EXPECT_EQ(s.collisions.sum(), s.pose->crossings.size());
    EXPECT_EQ(s.index.frame, s.index.next_frame);
    log.starts.push_back(s.pose->crossings);
    return {};
  }
  Result<void> step(const CheckedStep& s) override {
    Seen seen{s.index, s.collisions, s.earliest_toi, {}, {}};
    for (std::size_t object = 0; object < s.x0.size(); ++object) {
      seen.x0.emplace_back(s.x0[object].begin(), s.x0[object].end());
      seen.x1.emplace_back(s.x1[object].begin(), s.x1[object].end());
    }
    log.steps.push_back(std::move(seen));
    return {};
  }
  Result<void> finish(const CheckTotals&) override {
    ++log.finished;
    return {};
  }
  Log& log;
};

struct Checked {
  Result<CheckTotals> totals;
  Recorder::Log log;
};

Checked check(Motions motions, const CheckSettings& settings = {}, const CheckHooks& hooks = {}) {
  Checked checked;
  std::vector<std::unique_ptr<ReportWriter>> writers;
  writers.push_back(std::make_unique<Recorder>(checked.log));
  checked.totals = run_check(motions, settings, writers, hooks);
  return checked;
}

CheckSettings with_frames(const std::string& range, CheckSettings settings = {}) {
  settings.frames = *parse_frame_range(range);
  return settings;
}

TEST(RunCheck, FindsEachVertexThatPassesTheFloorAndWhen) {
  const auto [totals, log] = check(list(sinking_triangle(kSinking)));
  ASSERT_TRUE(totals) << totals.error().line();
  ASSERT_EQ(log.steps.size(), 4u);
  EXPECT_EQ(log.finished, 1);
  const std::uint64_t hits[] = {0, 1, 2, 0};
  for (Index k = 0; k < 4; ++k) {
    const auto& step = log.steps[k];
    EXPECT_EQ(step.index.number, k);
    EXPECT_EQ(step.index.frame, k);
    EXPECT_EQ(step.index.next_frame, k + 1);
    EXPECT_EQ(step.collisions.vertex_face, hits[k]) << k;
    EXPECT_EQ(step.collisions.edge_edge, 0u) << k;
    EXPECT_NEAR(step.earliest_toi, hits[k] ? 0.6 : 1, 1e-6);
    EXPECT_EQ(step.x0[0], sinking_frame(kSinking[k]));
    EXPECT_EQ(step.x1[0], sinking_frame(kSinking[k + 1]));
  }
  EXPECT_EQ(totals->steps, 4u);
  EXPECT_EQ(totals->steps_with_collisions, 2u);
  EXPECT_EQ(totals->collisions.sum(), 3u);
  EXPECT_EQ(totals->earliest->frame, 1u);
  EXPECT_NEAR(totals->earliest_toi, 0.6, 1e-6);
  EXPECT_EQ(totals->worst->frame, 2u);
  EXPECT_EQ(totals->worst_collisions.vertex_face, 2u);
  EXPECT_GT(totals->tolerance, 0);
  EXPECT_FALSE(totals->clean());
  EXPECT_FALSE(totals->cancelled);
}

TEST(RunCheck, ACleanMotionIsClean) {
  const auto totals = check(list(sinking_triangle({3, 2, 1}))).totals;
  ASSERT_TRUE(totals);
  EXPECT_TRUE(totals->clean());
  EXPECT_FALSE(totals->earliest);
  EXPECT_FALSE(totals->worst);
}

TEST(RunCheck, ChecksOnlyTheSelectedFrames) {
  auto log = check(list(sinking_triangle(kSinking)), with_frames("2:5")).log;
  ASSERT_EQ(log.steps.size(), 2u);
  EXPECT_EQ(log.steps[0].index.frame, 2u);
  EXPECT_EQ(log.steps[0].index.number, 0u);

  // Every second frame: a step goes from frame 0 to 2 and from 2 to 4.
  log = check(list(sinking_triangle(kSinking)), with_frames("::2")).log;
  ASSERT_EQ(log.steps.size(), 2u);
  EXPECT_EQ(log.steps[0].index.next_frame, 2u);
  EXPECT_NEAR(log.steps[0].earliest_toi, 0.8, 1e-6);
  EXPECT_EQ(log.steps[1].x1[0], sinking_frame(kSinking[4]));
}

TEST(RunCheck, SubstepsDivideAStepWithoutGaps) {
  CheckSettings settings = with_frames("1:3");
  settings.substeps = 7;
  const auto log = check(list(sinking_triangle(kSinking)), settings).log;
  ASSERT_EQ(log.steps.size(), 7u);
  EXPECT_EQ(log.steps.front().x0[0], sinking_frame(kSinking[1]));
  EXPECT_EQ(log.steps.back().x1[0], sinking_frame(kSinking[2]));
  for (Index k = 0; k < 7; ++k) {
    EXPECT_EQ(log.steps[k].index.frame, 1u);
    EXPECT_EQ(log.steps[k].index.substep, k);
    if (k > 0) {
      EXPECT_EQ(log.steps[k].x0, log.steps[k - 1].x1);
    }
    EXPECT_NEAR(log.steps[k].x0[0][11], 0.6 - k / 7.0, 1e-12);
    // The floor keeps its exact position.
    for (int c = 0; c < 9; ++c) EXPECT_EQ(log.steps[k].x0[0][c], sinking_frame(0)[c]);
    EXPECT_EQ(log.steps[k].collisions.vertex_face, k == 4 ? 1u : 0u) << k;  // 0.6 is 4.2 of 7 parts
  }
  EXPECT_NEAR(log.steps[4].earliest_toi, 0.2, 1e-6);
}

TEST(RunCheck, PosesFindCrossingTriangles) {
  CheckSettings settings;
  settings.poses = true;
  const auto [totals, log] = check(list(sinking_triangle(kSinking)), settings);
  ASSERT_TRUE(totals) << totals.error().line();
  ASSERT_EQ(log.steps.size(), 5u);
  std::vector<std::uint64_t> crossings;
  for (const auto& step : log.steps) crossings.push_back(step.collisions.triangle_triangle);
  EXPECT_THAT(crossings, ElementsAre(0, 0, 1, 0, 0));
  EXPECT_EQ(totals->worst->frame, 2u);
  EXPECT_EQ(totals->collisions.triangle_triangle, 1u);
}

TEST(RunCheck, ASinglePoseNeedsNoSecondFrame) {
  CheckSettings settings;
  settings.poses = true;
  const auto totals = check(list(sinking_triangle({-0.4})), settings).totals;
  ASSERT_TRUE(totals);
  EXPECT_EQ(totals->collisions.triangle_triangle, 1u);
}

TEST(RunCheck, WhatCrossesFromTheStartIsNotFree) {
  // The sinking triangle sticks in the floor all the time, and nothing comes into contact.
  const auto stuck = list(sinking_triangle({-0.4, -0.5, -0.45}));
  auto [totals, log] = check(stuck);
  ASSERT_TRUE(totals) << totals.error().line();
  EXPECT_EQ(totals->collisions.sum(), 0u);
  EXPECT_EQ(totals->starts_crossing, 1u);
  EXPECT_FALSE(totals->clean());
  EXPECT_GT(totals->start_milliseconds.total, 0);
  ASSERT_EQ(log.starts.size(), 1u);
  ASSERT_EQ(log.starts[0].size(), 1u);
  EXPECT_EQ(log.starts[0][0].triangle_a, 0u);
  EXPECT_EQ(log.starts[0][0].triangle_b, 1u);

  // That is the first frame that is checked, not the motion's.
  EXPECT_EQ(check(list(sinking_triangle(kSinking))).totals->starts_crossing, 0u);
  EXPECT_EQ(check(list(sinking_triangle(kSinking)), with_frames("2:")).totals->starts_crossing, 1u);

  // Whoever asks for the steps only is told nothing of it, not that there was nothing.
  CheckSettings only;
  only.steps_only = true;
  const auto steps = check(stuck, only);
  EXPECT_TRUE(steps.log.starts.empty());
  EXPECT_EQ(steps.totals->starts_crossing, std::nullopt);
  EXPECT_TRUE(steps.totals->clean());
}

TEST(RunCheck, TheStartAsksWhatTheStepsAsk) {
  CheckSettings within, between;
  within.step.between = false;
  between.step.within = false;
  const auto objects = list(lone_floor(2), lone_triangle({-0.4, -0.4}));
  EXPECT_EQ(check(objects, within).totals->starts_crossing, 0u);
  EXPECT_EQ(check(objects, between).totals->starts_crossing, 1u);
  EXPECT_EQ(check(objects).totals->starts_crossing, 1u);
}

TEST(RunCheck, ASingleFrameIsAMotionThatStandsStill) {
  const auto [totals, log] = check(list(sinking_triangle({-0.4})));
  ASSERT_TRUE(totals) << totals.error().line();
  EXPECT_EQ(totals->starts_crossing, 1u);
  EXPECT_EQ(totals->steps, 1u);
  EXPECT_EQ(totals->steps_expected, 1u);
  EXPECT_EQ(totals->collisions.sum(), 0u);
  EXPECT_EQ(log.finished, 1);
  EXPECT_FALSE(totals->clean());
  EXPECT_TRUE(check(list(sinking_triangle({0.6}))).totals->clean());
  EXPECT_EQ(check(list(sinking_triangle(kSinking)), with_frames("2")).totals->starts_crossing, 1u);

  // What is closer than the thickness counts as it does in a motion.
  CheckSettings thick;
  thick.step.thickness = 0.7;
  thick.substeps = 3;
  const auto close = check(list(sinking_triangle({0.6})), thick);
  ASSERT_TRUE(close.totals);
  EXPECT_EQ(close.totals->steps, 1u);
  EXPECT_EQ(close.totals->steps_expected, 1u);
  EXPECT_EQ(close.totals->collisions.vertex_face, 1u);
  ASSERT_EQ(close.log.steps.size(), 1u);
  EXPECT_EQ(close.log.steps[0].index.next_frame, 0u);
  thick.step.thickness = 0.5;
  EXPECT_TRUE(check(list(sinking_triangle({0.6})), thick).totals->clean());

  CheckSettings only;
  only.steps_only = true;
  const auto refused = check(list(sinking_triangle({0.6})), only).totals;
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().line(), HasSubstr("--steps-only"));
}

TEST(RunCheck, WithinAndBetweenSelectObjectPairs) {
  CheckSettings within, between;
  within.step.between = false;
  between.step.within = false;
  const auto objects = list(lone_floor(5), lone_triangle(kSinking));
  EXPECT_EQ(check(objects, within).totals->collisions.sum(), 0u);
  EXPECT_EQ(check(objects, between).totals->collisions.sum(), 3u);
  EXPECT_EQ(check(objects).totals->collisions.sum(), 3u);
  const auto alone = check(list(sinking_triangle(kSinking)), between).totals;
  ASSERT_FALSE(alone);
  EXPECT_THAT(alone.error().line(), HasSubstr("nothing between"));
}

TEST(RunCheck, RefusesWhatCannotBeChecked) {
  EXPECT_FALSE(check({}).totals);
  const auto counts = check(list(lone_floor(4), lone_triangle(kSinking))).totals;
  ASSERT_FALSE(counts);
  EXPECT_THAT(counts.error().line(), HasSubstr("lone triangle: has 5 frames, but lone floor has 4"));
  for (const char* range : {"3:3", "9:"}) {
    const auto totals = check(list(sinking_triangle(kSinking)), with_frames(range)).totals;
    ASSERT_FALSE(totals) << range;
    EXPECT_THAT(totals.error().line(), HasSubstr("--frames: selects 0 of 5 frames, and one is needed"));
  }
  CheckSettings nothing;
  nothing.step.within = nothing.step.between = false;
  const auto untested = check(list(sinking_triangle(kSinking), sinking_triangle(kSinking)), nothing).totals;
  ASSERT_FALSE(untested);
  EXPECT_THAT(untested.error().line(), HasSubstr("nothing would be tested"));
  CheckSettings no_parts;
  no_parts.substeps = 0;
  const auto parts = check(list(sinking_triangle(kSinking)), no_parts).totals;
  ASSERT_FALSE(parts);
  EXPECT_THAT(parts.error().line(), HasSubstr("substeps: must not be 0"));
  CheckSettings only;
  only.steps_only = true;
  for (const char* range : {"3:3", "3:4", "9:", "2"}) {
    const auto totals = check(list(sinking_triangle(kSinking)), with_frames(range, only)).totals;
    ASSERT_FALSE(totals) << range;
    EXPECT_THAT(totals.error().line(), HasSubstr("two are needed")) << range;
  }
}

/// Fails to read one of its frames.
struct BrokenMotion : Motion {
  explicit BrokenMotion(std::unique_ptr<Motion> inner) : inner(std::move(inner)) {}
  const std::string& name() const override { return inner->name(); }
  const Topology& topology() const override { return inner->topology(); }
  Index frame_count() const override { return inner->frame_count(); }
  Result<void> read_frame(Index k, std::span<double> out) override {
    if (k == 3) return fail(ErrorCode::InvalidFile, "frame 3", "is broken", "repair it");
    return inner->read_frame(k, out);
  }
  std::unique_ptr<Motion> inner;
};

TEST(RunCheck, AFrameThatCannotBeReadEndsTheCheckUnfinished) {
  const auto [totals, log] =
      check(list<std::unique_ptr<Motion>>(std::make_unique<BrokenMotion>(sinking_triangle(kSinking))));
  ASSERT_FALSE(totals);
  EXPECT_EQ(totals.error().where, "frame 3");
  EXPECT_EQ(log.steps.size(), 2u);
  EXPECT_EQ(log.finished, 0);
}

TEST(RunCheck, AWriterThatFailsEndsTheCheck) {
  struct Full : ReportWriter {
    Result<void> step(const CheckedStep& s) override {
      return s.index.number < 2 ? Result<void>{} : fail(ErrorCode::FileAccess, "disk", "is full", "empty it");
    }
    Result<void> finish(const CheckTotals&) override { return {}; }
  };
  std::vector<std::unique_ptr<ReportWriter>> writers;
  writers.push_back(std::make_unique<Full>());
  const auto totals = run_check(list(sinking_triangle(kSinking)), {}, writers);
  ASSERT_FALSE(totals);
  EXPECT_EQ(totals.error().where, "disk");
}

TEST(RunCheck, ReportsProgressAndStopsOnRequest) {
  std::atomic<bool> stop = false;
  std::vector<std::uint64_t> done;
  CheckHooks hooks;
  hooks.cancel = &stop;
  hooks.progress = [&](const CheckTotals& totals, std::uint64_t expected) {
    EXPECT_EQ(expected, 8u);
    done.push_back(totals.steps);
    if (totals.steps == 3) stop = true;
  };
  CheckSettings settings;
  settings.substeps = 2;
  const auto [totals, log] = check(list(sinking_triangle(kSinking)), settings, hooks);
  ASSERT_TRUE(totals);
  EXPECT_TRUE(totals->cancelled);
  EXPECT_THAT(done, ElementsAre(1, 2, 3));
  EXPECT_EQ(log.finished, 0);
  EXPECT_EQ(totals->steps, 3u);
  EXPECT_EQ(totals->steps_expected, 8u);
  EXPECT_EQ(totals->collisions.sum(), 0u);
  EXPECT_FALSE(totals->clean()) << "unchecked steps are not free";

  // Stopped before the first test.
  const auto nothing = check(list(sinking_triangle({-0.4, -0.4})), {}, hooks).totals;
  EXPECT_EQ(nothing->starts_crossing, std::nullopt);
  EXPECT_FALSE(nothing->clean());
}

TEST(RunCheck, OnlyTheEarliestOnRequest) {
  CheckSettings settings = with_frames("2:4");
  settings.step.earliest_only = true;
  EXPECT_EQ(check(list(sinking_triangle(kSinking)), settings).totals->collisions.sum(), 1u);
}

TEST(RunCheck, ThicknessCountsWhatComesClose) {
  CheckSettings settings = with_frames("0:2");  // the tip comes down to 0.6
  EXPECT_TRUE(check(list(sinking_triangle(kSinking)), settings).totals->clean());
  settings.step.thickness = 0.7;
  const auto totals = check(list(sinking_triangle(kSinking)), settings).totals;
  EXPECT_EQ(totals->collisions.vertex_face, 1u);
  EXPECT_NEAR(totals->earliest_toi, 0.9, 1e-6);
}

}  // namespace
}  // namespace foldproof
