// Look-ahead only removes work: a step that an earlier search covers has the same answer, bit for bit, as
// with a search of its own.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/callers.h"
#include "base/rounds.h"
#include "check/animations.h"
#include "check/look_ahead.h"
#include "check/look_ahead_policy.h"
#include "mesh/grid.h"

namespace foldproof::oracle {
namespace {

using Poses = std::vector<Pose>;

Poses between(const Poses& a, const Poses& b, double t) {
  Poses out = a;
  for (std::size_t object = 0; object < a.size(); ++object) {
    for (std::size_t i = 0; i < a[object].size(); ++i) out[object][i] += t * (b[object][i] - a[object][i]);
  }
  return out;
}

Poses perturbed(Poses pose, double size, Rng& rng) {
  if (size == 0) return pose;
  std::uniform_real_distribution<double> to(-size, size);
  for (Pose& x : pose) {
    for (double& c : x) c += to(rng);
  }
  return pose;
}

double random(Rng& rng, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(rng);
}

// Follows an animation in straight pieces like users of the library: continues, repeats a step, goes back,
// takes larger or smaller steps; exactly, or perturbed by less and by more than the slack.
class Walker {
 public:
  Walker(const Animation& animation, Comparison& both, Rng& rng)
      : animation_(animation), both_(both), rng_(rng) {}

  void follow(const Poses& from, const Poses& to, const StepSettings& settings) {
    const int parts = std::uniform_int_distribution<int>(3, 14)(rng_);
    const bool perturbs = rng_() % 2 == 0;
    const double size = perturbs ? std::exp2(random(rng_, -22, -8)) : 0;
    double t = 0;
    for (int part = 0; part < parts; ++part) {
      const double next = t + random_step(1.0 / parts);
      const Poses x0 = perturbed(between(from, to, t), size, rng_);
      const Poses x1 = perturbed(between(from, to, next), size, rng_);
      ASSERT_NO_FATAL_FAILURE(both_.step(x0, x1, settings));
      if (rng_() % 24 == 0) {
        ASSERT_NO_FATAL_FAILURE(both_.pose(x0));
      }
      if (rng_() % 8 != 0) t = next;  // else repeats the step
    }
  }

  void run(const StepSettings& settings) {
    for (std::size_t k = 0; k + 1 < animation_.poses.size(); k += 1 + rng_() % 4)
      ASSERT_NO_FATAL_FAILURE(follow(animation_.poses[k], animation_.poses[k + 1], settings)) << "pose " << k;
  }

 private:
  double random_step(double step) {
    switch (rng_() % 12) {
      case 0:
        return -step;
      case 1:
        return random(rng_, 0, 3) * step;
      case 2:
        return 0;
      default:
        return step;
    }
  }

  const Animation& animation_;
  Comparison& both_;
  Rng& rng_;
};

class LookAheadAnimations : public ::testing::TestWithParam<AnimationFamily> {};

TEST_P(LookAheadAnimations, NeverChangesAnAnswer) {
  std::uint64_t covered = 0, hits = 0;
  for (int seed = 1; seed <= testing::rounds(9); ++seed) {
    Rng rng(seed);
    const Animation animation = GetParam().make(rng);
    StepSettings settings;
    settings.thickness = std::array{0.0, 0.004, 0.0}[seed % 3];
    Comparison both(hierarchies(animation, seed % 2 == 0 ? 16 : 5));
    ASSERT_NO_FATAL_FAILURE(Walker(animation, both, rng).run(settings)) << "seed " << seed;
    covered += both.sums.covered;
    hits += both.sums.hits;
  }
  if (testing::kShare > 1) return;
  // Otherwise the test would prove nothing.
  EXPECT_GT(covered, 50u);
  EXPECT_GT(hits, 50u);
}

TEST_P(LookAheadAnimations, SettingsMayChangeBetweenSteps) {
  Rng rng(7);
  const Animation animation = GetParam().make(rng);
  Comparison both(hierarchies(animation, 8));
  for (int k = 0; k < 60; ++k) {
    StepSettings settings;
    settings.thickness = std::array{0.0, 0.0, 0.003}[k / 7 % 3];
    settings.tolerance = k / 11 % 3 == 2 ? 0.001 : 0;
    settings.within = k / 13 % 4 != 3 || animation.topologies.size() == 1;
    settings.between = k / 17 % 4 != 3 || !settings.within;
    settings.look_ahead = k / 19 % 3 != 2;
    const auto at = [&](int step) { return between(animation.poses[3], animation.poses[4], 0.02 * step); };
    ASSERT_NO_FATAL_FAILURE(both.step(at(k), at(k + 1), settings)) << "step " << k;
  }
  EXPECT_GT(both.sums.covered, 5u);
}

TEST_P(LookAheadAnimations, ThreadsChangeNeitherAnswersNorWork) {
  if (!has_threads()) GTEST_SKIP() << "there is one thread";
  std::vector<std::vector<StepResult>> runs;
  for (const int threads : {1, 2, 2}) {
    Rng rng(5);
    const Animation animation = GetParam().make(rng);
    StepChecker checker(hierarchies(animation, 4));
    auto& run = runs.emplace_back(30);
    with_threads(threads, [&] {
      for (int k = 0; k < 30; ++k) {
        const auto at = [&](int step) { return between(animation.poses[3], animation.poses[4], 0.1 * step); };
        const Poses from = at(k), to = at(k + 1);
        ASSERT_TRUE(checker.check(spans(from), spans(to), {}, run[k]));
      }
    });
  }
  for (const auto& run : runs) {
    for (std::size_t k = 0; k < run.size(); ++k) {
      ASSERT_NO_FATAL_FAILURE(expect_same(run[k], runs[0][k]));
      EXPECT_TRUE(same_counts(run[k].work, runs[0][k].work)) << "step " << k;
      EXPECT_EQ(run[k].search_steps, runs[0][k].search_steps) << "step " << k;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Generated, LookAheadAnimations,
                         ::testing::ValuesIn(generated_animations().begin(), generated_animations().end()),
                         [](const auto& instance) { return std::string(instance.param.name); });

// ---- Two sheets whose gap is smaller than the slack.

constexpr Index kCells = 12;
constexpr double kEdge = 1.0 / kCells;

Topology two_sheets() { return testing::Grid{kCells, kCells}.topology(2); }

// The lower sheet at height 0, the upper one at `gap`; both at `x`.
Pose sheets_at(double x, double gap) {
  Pose pose;
  for (int s = 0; s < 2; ++s) {
    for (Index j = 0; j <= kCells; ++j) {
      for (Index i = 0; i <= kCells; ++i)
        pose.insert(pose.end(), {x + i * kEdge + 0.3 * s * kEdge, j * kEdge + 0.2 * s * kEdge, s * gap});
    }
  }
  return pose;
}

// Moves both sheets towards each other, or a single vertex of the lower one.
void deviate(Pose& pose, double by, bool both) {
  const std::size_t sheet = pose.size() / 2;
  if (!both) {
    pose[3 * 30 + 2] += by;
    return;
  }
  for (std::size_t i = 2; i < pose.size(); i += 3) pose[i] += i < sheet ? by : -by;
}

// A straight motion until a search covers several steps, then a last step in which vertices deviate, within
// the slack or beyond. No contact is missed.
TEST(LookAhead, FindsContactsOfVerticesThatDeviate) {
  int covered_hits[2] = {0, 0};
  for (double size = 0x1p-16 * kEdge; size < 0.02 * kEdge; size *= 1 + 0.25 * testing::kShare) {
    for (const double share : {0.3, 0.9, 1.1, 1.9, 2.1}) {  // deviation, as a share of the gap
      for (const bool both : {true, false}) {
        const double gap = (both ? 2 : 1) * size / share;
        auto hierarchy = Hierarchy::build(two_sheets(), sheets_at(0, gap));
        const auto shared = std::make_shared<const Hierarchy>(std::move(hierarchy.value()));
        StepChecker with({shared}), without({shared});
        for (int k = 0; k < 8; ++k) {
          Pose from = sheets_at(0.01 * k, gap), to = sheets_at(0.01 * (k + 1), gap);
          if (k == 7) deviate(to, size, both);
          const std::span<const double> x0 = from, x1 = to;
          StepResult a, b;
          ASSERT_TRUE(with.check(x0, x1, {}, a));
          StepSettings plain;
          plain.certificates = false;
          ASSERT_TRUE(without.check(x0, x1, plain, b));
          ASSERT_NO_FATAL_FAILURE(expect_same(a, b)) << "size " << size << ", share " << share;
          EXPECT_EQ(b.clean(), k < 7 || share < 1);
          covered_hits[both] += k == 7 && a.search_steps == 0 && !a.clean();
        }
      }
    }
  }
  EXPECT_GT(covered_hits[0], 5);
  EXPECT_GT(covered_hits[1], 5);
}

// One vertex starts, or ends, on the other side of the other sheet; all others continue in straight lines.
TEST(LookAhead, FindsASingleVertexThatDeviates) {
  const double gap = 0.4 * kEdge;
  auto hierarchy = Hierarchy::build(two_sheets(), sheets_at(0, gap));
  const auto shared = std::make_shared<const Hierarchy>(std::move(hierarchy.value()));
  for (Index vertex = 0; vertex < (kCells + 1) * (kCells + 1); vertex += 7) {
    for (const bool begins : {true, false}) {
      StepChecker checker({shared});
      StepResult result;
      for (int k = 0; k < 6; ++k) {
        Pose from = sheets_at(0.003 * k, gap), to = sheets_at(0.003 * (k + 1), gap);
        if (k == 5) (begins ? from : to)[3 * vertex + 2] = 2 * gap;
        const std::span<const double> x0 = from, x1 = to;
        ASSERT_TRUE(checker.check(x0, x1, {}, result));
      }
      EXPECT_FALSE(result.clean()) << "vertex " << vertex;
    }
  }
}

TEST(LookAhead, SearchesAStraightMotionSeldom) {
  auto hierarchy = Hierarchy::build(two_sheets(), sheets_at(0, 0.4 * kEdge));
  StepChecker checker({std::make_shared<const Hierarchy>(std::move(hierarchy.value()))});
  int searches = 0;
  for (int k = 0; k < 100; ++k) {
    const Pose from = sheets_at(0.003 * k, 0.4 * kEdge), to = sheets_at(0.003 * (k + 1), 0.4 * kEdge);
    const std::span<const double> x0 = from, x1 = to;
    StepResult result;
    ASSERT_TRUE(checker.check(x0, x1, {}, result));
    searches += result.search_steps != 0;
    EXPECT_EQ(result.work.refits, result.search_steps != 0 ? 1u : 0u);
    if (result.search_steps == 0) {
      EXPECT_EQ(result.work.node_tests, 0u);
    }
  }
  EXPECT_LE(searches, 8);
}

TEST(LookAhead, RejectsNonFiniteNumbersOnCacheHits) {
  auto hierarchy = Hierarchy::build(two_sheets(), sheets_at(0, 0.4 * kEdge));
  StepChecker checker({std::make_shared<const Hierarchy>(std::move(hierarchy.value()))});
  StepResult result;
  for (int k = 0; k < 12; ++k) {
    Pose from = sheets_at(0.003 * k, 0.4 * kEdge), to = sheets_at(0.003 * (k + 1), 0.4 * kEdge);
    const bool bad = k >= 6 && k % 2 == 0;
    if (bad) {
      (k % 4 == 0 ? from : to)[3 * 17 + 1] =
          k < 9 ? std::numeric_limits<double>::quiet_NaN() : std::numeric_limits<double>::infinity();
    }
    const std::span<const double> x0 = from, x1 = to;
    const auto done = checker.check(x0, x1, {}, result);
    EXPECT_EQ(done.has_value(), !bad) << "step " << k;
    if (!done) {
      EXPECT_EQ(done.error().where, "object 0, vertex 17");
    }
  }
}

// A vertex that no triangle uses is checked as well. Only that one call fails.
TEST(LookAhead, RejectsNonFiniteUnusedVerticesOnCacheHits) {
  const Topology sheets = two_sheets();
  const std::vector<Triangle> triangles(sheets.triangles().begin(), sheets.triangles().end());
  const auto at = [](double x) {
    Pose pose = sheets_at(x, 0.4 * kEdge);
    pose.insert(pose.end(), {1, 2, 3});
    return pose;
  };
  auto hierarchy = Hierarchy::build(*Topology::make(sheets.vertex_count() + 1, triangles), at(0));
  StepChecker checker({std::make_shared<const Hierarchy>(std::move(hierarchy.value()))});
  StepResult result;
  int covered = 0;
  for (int k = 0; k < 40; ++k) {
    const Pose from = at(0.003 * k), to = at(0.003 * (k + 1));
    const std::span<const double> x0 = from, x1 = to;
    ASSERT_TRUE(checker.check(x0, x1, {}, result));
    if (result.search_steps != 0) continue;
    ++covered;
    for (const bool end : {false, true}) {
      Pose changed = end ? to : from;
      changed.back() =
          k % 2 ? std::numeric_limits<double>::quiet_NaN() : std::numeric_limits<double>::infinity();
      const std::span<const double> bad = changed;
      EXPECT_FALSE(checker.check(end ? x0 : bad, end ? bad : x1, {}, result)) << "step " << k;
    }
  }
  EXPECT_GT(covered, 10);
}

// After some steps the upper sheet moves down through the lower one. The first of these steps is not valid.
TEST(LookAhead, AFailedStepInvalidatesTheSearch) {
  const double gap = 0.4 * kEdge, down = 0.11 * kEdge;
  auto hierarchy = Hierarchy::build(two_sheets(), sheets_at(0, gap));
  StepChecker checker({std::make_shared<const Hierarchy>(std::move(hierarchy.value()))});
  StepResult result;
  std::size_t hits = 0;
  for (int k = 0; k < 14; ++k) {
    const auto height = [&](int step) { return gap - down * std::max(0, step - 6); };
    const Pose from = sheets_at(0.003 * k, height(k));
    Pose to = sheets_at(0.003 * (k + 1), height(k + 1));
    if (k == 6) to[3 * 29] = std::numeric_limits<double>::quiet_NaN();
    const std::span<const double> x0 = from, x1 = to;
    EXPECT_EQ(checker.check(x0, x1, {}, result).has_value(), k != 6);
    if (k != 6) hits += result.vertex_face.size();
  }
  EXPECT_GT(hits, 100u);
}

// Without rounding, in coordinates that single precision represents: in motion and at rest.
TEST(LookAhead, ARepeatedStepHasTheSameAnswer) {
  const auto rounded = [](Pose pose) {
    for (double& x : pose) x = std::round(x * 256) / 256;
    return pose;
  };
  for (const double end : {-0.25, 0.0}) {
    const Pose from = rounded(sheets_at(0, 0)), to = rounded(sheets_at(0, end));
    auto hierarchy = Hierarchy::build(two_sheets(), from);
    StepChecker checker({std::make_shared<const Hierarchy>(std::move(hierarchy.value()))});
    const std::span<const double> x0 = from, x1 = to;
    StepResult result;
    std::size_t first = 0;
    for (int k = 0; k < 6; ++k) {
      ASSERT_TRUE(checker.check(x0, x1, {}, result));
      const std::size_t hits = result.vertex_face.size() + result.edge_edge.size();
      if (k == 0) first = hits;
      // A repeated step is not extrapolated.
      if (end != 0) {
        EXPECT_EQ(result.search_steps, 1u);
      }
      EXPECT_EQ(hits, first) << "the " << k << ". time";
    }
    EXPECT_GT(first, 100u);
  }
}

TEST(LookAhead, AcceptsTheLargestDoubles) {
  for (const double far : {1e150, 1e300, 8e307}) {
    auto hierarchy = Hierarchy::build(two_sheets(), sheets_at(0, 0.4 * kEdge));
    StepChecker checker({std::make_shared<const Hierarchy>(std::move(hierarchy.value()))});
    for (int k = 0; k < 6; ++k) {
      Pose from = sheets_at(0, 0.4 * kEdge), to = from;
      for (double& x : from) x *= far * (0.1 + 0.1 * k);
      for (double& x : to) x *= far * (0.2 + 0.1 * k);
      const std::span<const double> x0 = from, x1 = to;
      StepResult result;
      EXPECT_TRUE(checker.check(x0, x1, {}, result)) << far << ", step " << k;
    }
  }
}

// A finite start may be infinite in the frame. A step that has no time on the motion then is no cache hit: it
// is refused as by a new checker.
TEST(LookAhead, AStartThatOverflowsIsNoCacheHit) {
  const double size = 0x1p1000;
  StepSettings settings;
  settings.tolerance = 0x1p983;
  for (const double far : {-0x1p1010, 0x1p1010}) {
    const auto at = [&](int step) {
      Pose pose = sheets_at(0, 0.4 * kEdge);
      for (std::size_t i = 0; i < pose.size(); ++i)
        pose[i] = size * (pose[i] + (i % 3 == 2 ? 0.003 * step : 0)) + (i % 3 == 0 ? far : 0);
      return pose;
    };
    const auto hierarchy = std::make_shared<const Hierarchy>(Hierarchy::build(two_sheets(), at(0)).value());
    StepChecker kept({hierarchy});
    int ahead = 0;
    for (int step = 0; step < 20; ++step) {
      Pose from = at(step);
      const Pose to = at(step + 1);
      const std::span<const double> x0 = from, x1 = to;
      StepChecker fresh({hierarchy});
      StepResult expected, result;
      ASSERT_TRUE(fresh.check(x0, x1, settings, expected));
      ASSERT_TRUE(kept.check(x0, x1, settings, result));
      ASSERT_NO_FATAL_FAILURE(expect_same(result, expected));
      if (result.search_steps <= 2) continue;
      ++ahead;
      // A vertex that looking ahead samples comes from so far that even its distance overflows.
      const Index vertex = hierarchy->vertex_ids()[0];
      from[3 * std::size_t{vertex}] = std::copysign(std::numeric_limits<double>::max(), -far);
      for (StepChecker* checker : {&fresh, &kept}) {
        const auto refused = checker->check(x0, x1, settings, result);
        ASSERT_FALSE(refused);
        EXPECT_EQ(refused.error().where, fmt::format("object 0, vertex {}", vertex));
      }
    }
    EXPECT_GT(ahead, 0);
  }
}

// F1: the first step lies on the extrapolated motion, although that has many steps and its end is rounded,
// also far from the origin.
TEST(LookAhead, TheFirstStepLiesOnTheMotion) {
  Rng rng(5);
  auto hierarchy = Hierarchy::build(two_sheets(), sheets_at(0, kEdge));
  const Object sheets(std::move(hierarchy.value()));
  StepMotion motion(std::span(&sheets, 1));
  int extrapolated = 0, single = 0;
  for (int round = 0; round < 400; ++round) {
    const Index steps = 2 + rng() % 31;
    const double offset = std::ldexp(random(rng, 0.5, 1), rng() % 56),
                 displacement = random(rng, 0, 0.25 / steps);
    Pose x0 = perturbed({sheets_at(0, kEdge)}, 0.1 * kEdge, rng)[0], x1 = x0;
    for (double& x : x0) x += offset;
    for (std::size_t i = 0; i < x1.size(); ++i) x1[i] = x0[i] + displacement;
    ASSERT_TRUE(motion.update(spans({x0}), spans({x1}), steps));
    (motion.steps() > 1 ? extrapolated : single) += 1;
    const KineticBvh& bvh = motion.bvhs()[0];
    const auto ids = bvh.hierarchy->vertex_ids();
    const double time = static_cast<float>(1.0 / motion.steps());
    for (std::size_t k = 0; k < ids.size(); ++k) {
      for (int axis = 0; axis < 3; ++axis) {
        const double from = bvh.vertices[k].x[axis], to = bvh.vertices[k].x[4 + axis];
        const double end = (position(x1, ids[k])[axis] - motion.frame().center[axis]) * motion.frame().scale;
        ASSERT_NEAR(from + time * (to - from), end, 0x1p-21) << offset << ", " << steps << " steps";
      }
    }
  }
  EXPECT_GT(extrapolated, 100);
  EXPECT_GT(single, 100);
}

// ---- LookAheadPolicy.

TEST(LookAheadPolicy, LearnsHowLongAMotionIsStraight) {
  LookAheadPolicy policy;
  Index planned = 1;
  int searches = 0;
  double since = 0;  // steps since the last search
  for (int step = 0; step < 400; ++step) {
    const bool turns = step % 10 == 0;
    ++since;
    if (!turns && since <= planned) {
      policy.note_hit(0, since);
      continue;
    }
    planned = policy.choose_steps(turns ? 0.5 : 0, since);
    policy.note_cost(planned == 1 ? 100 : 200);
    since = 1;
    if (step >= 200) ++searches;
  }
  EXPECT_LE(searches, 22);
}

TEST(LookAheadPolicy, DoesNotLookAheadWhereEveryStepTurns) {
  LookAheadPolicy policy;
  for (int step = 0; step < 100; ++step) {
    EXPECT_EQ(policy.choose_steps(0.3, 2), 1u) << "step " << step;
    policy.note_cost(100);
  }
}

TEST(LookAheadPolicy, LooksLessFarTheMoreAMotionCurves) {
  const auto farthest = [](double curvature) {
    LookAheadPolicy policy;
    Index planned = 1, max_planned = 1;
    double since = 0;
    for (int step = 0; step < 100; ++step) {
      ++since;
      const double deviation = curvature * since * since / 2;
      if (since <= planned && deviation <= kSlack) {
        policy.note_hit(deviation, since);
        continue;
      }
      planned = policy.choose_steps(deviation, since);
      policy.note_cost(planned == 1 ? 100 : 200);
      since = 1;
      if (step > 20) max_planned = std::max(max_planned, planned);
    }
    return max_planned;
  };
  EXPECT_EQ(farthest(0), 32u);
  EXPECT_LT(farthest(1e-5), farthest(1e-6));
  EXPECT_GT(farthest(1e-5), 4u);
  EXPECT_EQ(farthest(1e-3), 1u);
  EXPECT_EQ(farthest(0.1), 1u);
}

TEST(LookAheadPolicy, DoesNotLookAheadWhereItCostsMore) {
  LookAheadPolicy policy;
  Index planned = 1;
  int tries = 0;
  double since = 0;
  for (int step = 0; step < 200; ++step) {
    ++since;
    if (since <= planned) {
      policy.note_hit(0, since);
      continue;
    }
    planned = policy.choose_steps(0, since);
    policy.note_cost(planned == 1 ? 100 : 100.0 * 2 * planned);
    tries += planned > 1;
    since = 1;
  }
  EXPECT_LE(tries, 8);
}

}  // namespace
}  // namespace foldproof::oracle
