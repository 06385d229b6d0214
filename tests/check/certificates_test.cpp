// Certificates only remove work: with and without them, every step has the same answer, bit for bit. One
// checker runs all steps of a motion, since it builds charts from step to step.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <numbers>
#include <string>
#include <vector>

#include "base/callers.h"
#include "check/animations.h"
#include "foldproof/check.h"
#include "oracle/brute_force.h"
#include "oracle/data.h"
#include "oracle/meshes.h"

namespace foldproof::oracle {
namespace {

class Animations : public ::testing::TestWithParam<AnimationFamily> {
 protected:
  Rng rng_{81};
  Animation animation_ = GetParam().make(rng_);
};

TEST_P(Animations, CertificatesNeverChangeAnAnswer) {
  std::uint64_t passes = 0, with = 0, without = 0, hits = 0;
  for (const Index leaf : {4, 16}) {
    for (const double thickness : {0.0, 0.004}) {
      Comparison both(hierarchies(animation_, leaf));
      StepSettings settings;
      settings.thickness = thickness;
      for (std::size_t k = 0; k + 1 < animation_.poses.size(); ++k) {
        ASSERT_NO_FATAL_FAILURE(both.step(animation_.poses[k], animation_.poses[k + 1], settings))
            << "step " << k;
        if (k % 3 == 0) {
          ASSERT_NO_FATAL_FAILURE(both.pose(animation_.poses[k])) << "pose " << k;
        }
      }
      passes += both.sums.passes + both.statics.passes;
      with += both.sums.pairs_with;
      without += both.sums.pairs_without;
      hits += both.sums.hits;
    }
  }
  // Otherwise the test would prove nothing.
  EXPECT_GT(passes, 100u);
  EXPECT_LT(with, without);
  EXPECT_GT(hits, 50u);
}

// Certificates must prove a gap that grows with tolerance and thickness; and steps may exclude kinds of
// pairs.
TEST_P(Animations, SettingsChangeFromStepToStep) {
  Comparison both(hierarchies(animation_, 8));
  for (std::size_t k = 0; k + 1 < animation_.poses.size(); ++k) {
    StepSettings settings;
    settings.thickness = std::array{0.0, 0.02, 0.0, 0.001}[k % 4];
    settings.tolerance = std::array{0.0, 0.0, 0.01}[k % 3];
    settings.within = k % 5 != 4 || animation_.topologies.size() == 1;
    settings.between = k % 7 != 3 || !settings.within;
    ASSERT_NO_FATAL_FAILURE(both.step(animation_.poses[k], animation_.poses[k + 1], settings))
        << "step " << k;
    // Backwards: the start is not the pose in which charts were built.
    ASSERT_NO_FATAL_FAILURE(both.step(animation_.poses[k + 1], animation_.poses[k], settings))
        << "step " << k;
  }
  EXPECT_GT(both.sums.passes, 50u);
}

TEST_P(Animations, EarliestOnlyIsTheSameWithCertificates) {
  const auto objects = hierarchies(animation_, 8);
  StepChecker with(objects), without(objects);
  std::size_t hits = 0;
  for (std::size_t k = 0; k + 1 < animation_.poses.size(); ++k) {
    StepSettings settings;
    settings.earliest_only = true;
    StepResult a, b;
    const auto x0 = spans(animation_.poses[k]), x1 = spans(animation_.poses[k + 1]);
    ASSERT_TRUE(with.check(x0, x1, settings, a));
    settings.certificates = false;
    ASSERT_TRUE(without.check(x0, x1, settings, b));
    a.work.undecided = b.work.undecided = 0;  // depends on the order of threads
    ASSERT_NO_FATAL_FAILURE(expect_same(a, b)) << "step " << k;
    hits += b.count();
  }
  EXPECT_GT(hits, 3u);
}

TEST_P(Animations, ThreadsChangeNeitherAnswersNorWork) {
  if (!has_threads()) GTEST_SKIP() << "there is one thread";
  std::vector<std::vector<StepResult>> runs;
  for (const int threads : {1, 2, 2}) {
    StepChecker checker(hierarchies(animation_, 4));
    auto& run = runs.emplace_back(animation_.poses.size() - 1);
    with_threads(threads, [&] {
      for (std::size_t k = 0; k < run.size(); ++k) {
        const auto x0 = spans(animation_.poses[k]), x1 = spans(animation_.poses[k + 1]);
        ASSERT_TRUE(checker.check(x0, x1, {}, run[k]));
      }
    });
  }
  for (const auto& run : runs) {
    for (std::size_t k = 0; k < run.size(); ++k) {
      ASSERT_NO_FATAL_FAILURE(expect_same(run[k], runs[0][k]));
      EXPECT_TRUE(same_counts(run[k].work, runs[0][k].work)) << "step " << k;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Generated, Animations,
                         ::testing::ValuesIn(generated_animations().begin(), generated_animations().end()),
                         [](const auto& instance) { return std::string(instance.param.name); });

// ---- Real motions.

struct RealAnimation {
  const char* name;
  Index first;  ///< Where the short run starts: at collisions, if the motion has any.
};
void PrintTo(const RealAnimation& animation, std::ostream* out) { *out << animation.name; }

const RealAnimation kRealAnimations[] = {
    {"lion_poses", 0},  {"lion_anim", 20},   {"hand_poses", 4},     {"hand_train", 7},       {"hand_anim", 8},
    {"horse_poses", 2}, {"horse_gallop", 3}, {"elephant_poses", 0}, {"elephant_gallop", 10}, {"samba", 40},
    {"rumba", 30},      {"cloth_ball", 0},   {"rod_twist", 0},      {"cloth_funnel", 0},
};

class RealAnimations : public ::testing::TestWithParam<RealAnimation> {
 protected:
  void SetUp() override {
    const auto data = data_directory();
    if (!data) GTEST_SKIP() << kNoData;
    motion_ = open_real_motion(*data, GetParam().name);
    all_ = all_frames();
    first_ = all_ ? 0 : std::min(GetParam().first, motion_->frame_count() - 2);
    last_ = all_ ? motion_->frame_count() - 1 : std::min(first_ + 3, motion_->frame_count() - 1);
  }

  std::vector<Pose> frame(Index k) const {
    std::vector<Pose> pose{Pose(3 * std::size_t{motion_->topology().vertex_count()})};
    EXPECT_TRUE(motion_->read_frame(k, pose[0]));
    return pose;
  }

  Comparison comparison() const {
    auto built = Hierarchy::build(motion_->topology(), frame(0)[0]);
    return Comparison({std::make_shared<const Hierarchy>(std::move(built.value()))});
  }

  void report(const Comparison& both) const {
    const auto print = [&](const char* what, const Sums& s) {
      fmt::print("{:16} {:3} {:12} {:8} collisions, leaf pairs {:9} instead of {:9}\n", GetParam().name,
                 s.steps, what, s.hits, s.pairs_with, s.pairs_without);
    };
    print("steps", both.sums);
    if (both.statics.steps > 0) print("poses", both.statics);
    if (both.sums.steps > 2 && both.sums.covered == 0) {
      EXPECT_GT(both.sums.passes, 0u);
      EXPECT_LT(both.sums.pairs_with, both.sums.pairs_without);
    }
  }

  std::unique_ptr<Motion> motion_;
  bool all_ = false;
  Index first_ = 0, last_ = 0;
};

TEST_P(RealAnimations, FullSteps) {
  Comparison both = comparison();
  for (Index k = first_; k < last_; ++k)
    ASSERT_NO_FATAL_FAILURE(both.step(frame(k), frame(k + 1), {})) << "frame " << k;
  report(both);
}

// Once without look-ahead and explained, so that certificates are used also where they do not pay; once with
// look-ahead.
TEST_P(RealAnimations, TenthsOfSteps) {
  for (const bool ahead : {false, true}) {
    Comparison both = comparison();
    // The short run: some tenths of one step.
    const Index last = all_ ? last_ : first_ + 1;
    const int tenths = all_ ? 10 : 5;
    for (Index k = first_; k < last; ++k) {
      const auto from = frame(k), to = frame(k + 1);
      auto now = from, next = from;
      for (int part = 1; part <= tenths; ++part) {
        for (std::size_t i = 0; i < from[0].size(); ++i)
          next[0][i] = from[0][i] + (to[0][i] - from[0][i]) * part / 10;
        ASSERT_NO_FATAL_FAILURE(both.step(now, next, {.look_ahead = ahead, .explain = !ahead}))
            << "frame " << k << ", tenth " << part;
        std::swap(now, next);
      }
      if (!ahead) {
        ASSERT_NO_FATAL_FAILURE(both.pose(now)) << "frame " << k;
      }
    }
    report(both);
    EXPECT_EQ(both.sums.covered > 0, ahead);
  }
}

INSTANTIATE_TEST_SUITE_P(Motions, RealAnimations, ::testing::ValuesIn(kRealAnimations),
                         [](const auto& instance) { return std::string(instance.param.name); });

}  // namespace
}  // namespace foldproof::oracle
