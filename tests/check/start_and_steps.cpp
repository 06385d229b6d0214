// One static query for the first frame and one query per step suffice: where no triangles cross at the start
// and no step collides, none cross at any time (docs/soundness.md).
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "foldproof/check.h"
#include "oracle/data.h"
#include "oracle/meshes.h"

namespace foldproof::oracle {
namespace {

using Point = std::array<double, 3>;

/// Results for a step.
struct Outcome {
  bool starts_free = false, step_free = false;
  int crossing_at = -1;  ///< The first eighth of the step at which triangles cross; -1: none do.

  bool is_sound() const { return !(starts_free && step_free && crossing_at >= 0); }
};

std::vector<double> between(std::span<const double> x0, std::span<const double> x1, int eighths) {
  std::vector<double> x(x0.begin(), x0.end());
  for (std::size_t k = 0; k < x.size(); ++k) x[k] += (x1[k] - x0[k]) * eighths / 8;
  return x;
}

bool crosses(StepChecker& checker, std::span<const double> x) {
  StaticResult pose;
  const std::span<const double> spans[] = {x};
  EXPECT_TRUE(checker.check_static(spans, {}, pose));
  return !pose.clean();
}

/// Checks a step whose ends are small integers, so that the eighths between them are exact.
Outcome check(const Topology& topology, std::span<const double> x0, std::span<const double> x1) {
  auto tree = Hierarchy::build(topology, x0);
  EXPECT_TRUE(tree);
  StepChecker checker({std::make_shared<const Hierarchy>(std::move(*tree))});
  Outcome outcome{.starts_free = !crosses(checker, x0)};
  if (!outcome.starts_free) return outcome;
  StepResult step;
  const std::span<const double> from[] = {x0}, to[] = {x1};
  EXPECT_TRUE(checker.check(from, to, {}, step));
  outcome.step_free = step.clean();
  for (int k = 1; k <= 8 && outcome.crossing_at < 0; ++k)
    if (crosses(checker, between(x0, x1, k))) outcome.crossing_at = k;
  return outcome;
}

std::vector<double> on_grid(Index vertices, int cells, Rng& rng) {
  std::vector<double> x(3 * std::size_t{vertices});
  for (double& coordinate : x) coordinate = static_cast<double>(rng() % (cells + 1));
  return x;
}

std::string text_of(std::span<const Triangle> triangles, std::span<const double> x0,
                    std::span<const double> x1) {
  std::string text;
  for (const Triangle& t : triangles) text += fmt::format("({} {} {}) ", t[0], t[1], t[2]);
  for (const auto& x : {x0, x1}) text += fmt::format("\n{}", fmt::join(x, " "));
  return text;
}

// Two triangles with up to three common vertices, on a grid so coarse that vertices coincide, triangles are
// segments and points, and contacts are exact.
TEST(StartAndSteps, TwoTrianglesCrossOnlyAfterAContact) {
  Rng rng(71);
  std::array<int, 4> free{}, crossed{};  // by the number of common vertices
  for (int k = 0; k < 12000; ++k) {
    // A triangle may name a vertex several times.
    std::array<Triangle, 2> pair{};
    const Index shared = k % 3, pool = 6 - shared;
    for (Index i = 0; i < 3; ++i) {
      pair[0][i] = i;
      pair[1][i] = i < shared ? i : i + 3 - shared;
    }
    if (k % 5 == 0) pair[rng() % 2][rng() % 3] = static_cast<Index>(rng() % pool);
    std::set<Index> common;
    for (const Index v : pair[0])
      if (std::count(pair[1].begin(), pair[1].end(), v)) common.insert(v);
    const int cells = 1 + k % 4;
    const auto x0 = on_grid(pool, cells, rng), x1 = on_grid(pool, cells, rng);
    const auto topology = Topology::make(pool, {pair[0], pair[1]});
    ASSERT_TRUE(topology) << topology.error().line();
    const Outcome outcome = check(*topology, x0, x1);
    ASSERT_TRUE(outcome.is_sound()) << text_of(pair, x0, x1) << "\ncrosses at eighth " << outcome.crossing_at;
    free[common.size()] += outcome.starts_free && outcome.step_free;
    crossed[common.size()] += outcome.starts_free && outcome.crossing_at >= 0;
  }
  for (int shared = 0; shared < 3; ++shared) {
    EXPECT_GT(free[shared], 100) << shared;
    EXPECT_GT(crossed[shared], 100) << shared;
  }
}

// They cross as soon as they have an area, but without a contact between features that share no vertex.
TEST(StartAndSteps, CopiesOfATriangleCrossEvenWithoutAnArea) {
  const std::vector<double> point(9, 1.0), proper = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  for (const Triangle& again : {Triangle{0, 1, 2}, Triangle{2, 0, 1}, Triangle{0, 2, 1}}) {
    const auto twice = Topology::make(3, {{0, 1, 2}, again});
    EXPECT_FALSE(check(*twice, point, proper).starts_free);
    EXPECT_FALSE(check(*twice, proper, point).starts_free);
  }
  // A triangle that names a vertex twice never has an area, so it cannot cross unnoticed.
  const Outcome side = check(*Topology::make(3, {{0, 1, 2}, {0, 1, 1}}), point, proper);
  EXPECT_TRUE(side.starts_free && side.crossing_at < 0);
}

// A closed or open fan: all triangles have one common vertex.
TEST(StartAndSteps, AFanCannotPassThroughItselfUnnoticed) {
  Rng rng(72);
  int free = 0, crossed = 0;
  for (int k = 0; k < 4000; ++k) {
    const Index spokes = 3 + k % 5;
    const bool closed = k % 2 == 0;
    std::vector<Triangle> fan;
    for (Index i = 0; i + (closed ? 0 : 1) < spokes; ++i) fan.push_back({0, 1 + i, 1 + (i + 1) % spokes});
    std::vector<double> x0 = {0, 0, 0};
    for (Index i = 0; i < spokes; ++i) {
      const double angle = 6.2831853 * i / spokes;
      x0.insert(x0.end(), {std::round(32 * std::cos(angle)), std::round(32 * std::sin(angle)), 0});
    }
    // Small motions keep it free, large ones fold it or pull it through itself.
    std::vector<double> x1 = x0;
    const int size = 8 << k % 4;
    for (double& coordinate : x1) coordinate += static_cast<double>(rng() % (2 * size + 1)) - size;
    const Outcome outcome = check(*Topology::make(spokes + 1, std::move(fan)), x0, x1);
    ASSERT_TRUE(outcome.starts_free);
    ASSERT_TRUE(outcome.is_sound()) << k << ": crosses at eighth " << outcome.crossing_at;
    free += outcome.step_free;
    crossed += outcome.crossing_at >= 0;
  }
  EXPECT_GT(free, 300);
  EXPECT_GT(crossed, 300);
}

// Two triangles with a common edge close like a book and open on the other side. Halfway they are folded
// flat: a contact of a vertex with the other triangle.
TEST(StartAndSteps, FoldingFlatIsAContact) {
  const auto book = Topology::make(4, {{0, 1, 2}, {1, 0, 3}});
  const std::vector<double> open = {0, 0, 0, 0, 4, 0, 4, 2, 2, 3, 2, -2};
  std::vector<double> through = open;
  std::swap(through[8], through[11]);
  const Outcome outcome = check(*book, open, through);
  EXPECT_TRUE(outcome.starts_free);
  EXPECT_FALSE(outcome.step_free);
  EXPECT_EQ(outcome.crossing_at, 4);
}

class GeneratedMotions : public ::testing::TestWithParam<MeshFamily> {};

/// The mesh without triangles that cross others in a pose.
Topology without_crossings(const Mesh& mesh, std::span<const double> x) {
  auto tree = Hierarchy::build(mesh.topology(), x);
  EXPECT_TRUE(tree);
  StepChecker checker({std::make_shared<const Hierarchy>(std::move(*tree))});
  StaticResult pose;
  const std::span<const double> spans[] = {x};
  EXPECT_TRUE(checker.check_static(spans, {}, pose));
  std::set<Index> removed;
  for (const TriangleCrossing& c : pose.crossings)
    if (!removed.count(c.triangle_a)) removed.insert(c.triangle_b);
  std::vector<Triangle> kept;
  for (Index t = 0; t < mesh.triangles.size(); ++t)
    if (!removed.count(t)) kept.push_back(mesh.triangles[t]);
  return *Topology::make(mesh.vertex_count, std::move(kept));
}

// From poses without crossings, with steps of all sizes.
TEST_P(GeneratedMotions, AreSound) {
  Rng rng(73);
  const Mesh mesh = GetParam().make(rng);
  int free = 0, crossed = 0;
  for (int k = 0; k < 24; ++k) {
    const double amplitude = 0.3 * std::ldexp(1.0, -2 * (k % 8));
    const double grid = std::ldexp(1.0, k % 3 == 0 ? -20 : -6);
    const auto x0 = deformed(mesh.positions, k % 2 == 0 ? 0 : amplitude, grid, rng);
    const auto x1 = deformed(x0, amplitude, grid, rng);
    const Outcome outcome = check(without_crossings(mesh, x0), x0, x1);
    ASSERT_TRUE(outcome.starts_free);
    ASSERT_TRUE(outcome.is_sound()) << k << ": crosses at eighth " << outcome.crossing_at;
    free += outcome.step_free;
    crossed += outcome.crossing_at >= 0;
  }
  if (std::string_view(GetParam().name) != "damaged") {  // its copies of vertices touch in every step
    EXPECT_GT(free, 0);
  }
  EXPECT_GT(crossed, 0);
}

INSTANTIATE_TEST_SUITE_P(Meshes, GeneratedMotions,
                         ::testing::ValuesIn(mesh_families().begin(), mesh_families().end()),
                         [](const auto& instance) { return std::string(instance.param.name); });

class RealMotions : public ::testing::TestWithParam<const char*> {};

// All steps of a motion.
TEST_P(RealMotions, AreSound) {
  const auto data = data_directory();
  if (!data) GTEST_SKIP() << kNoData;
  const auto motion = open_real_motion(*data, GetParam());
  const Index frames = all_frames() ? motion->frame_count() : std::min<Index>(motion->frame_count(), 25);
  std::vector<double> from(3 * motion->topology().vertex_count()), to = from;
  ASSERT_TRUE(motion->read_frame(0, from));
  auto tree = Hierarchy::build(motion->topology(), from);
  ASSERT_TRUE(tree);
  StepChecker checker({std::make_shared<const Hierarchy>(std::move(*tree))});
  bool crossing = crosses(checker, from);
  int free = 0, crossing_frames = crossing, crossed = 0;
  for (Index k = 1; k < frames; ++k) {
    ASSERT_TRUE(motion->read_frame(k, to));
    StepResult step;
    const std::span<const double> x0[] = {from}, x1[] = {to};
    ASSERT_TRUE(checker.check(x0, x1, {}, step));
    const bool crosses_then = crosses(checker, to);
    EXPECT_FALSE(!crossing && step.clean() && crosses_then) << GetParam() << " frame " << k;
    free += !crossing && step.clean();
    crossed += !crossing && crosses_then;
    crossing_frames += crosses_then;
    crossing = crosses_then;
    std::swap(from, to);
  }
  fmt::print("{:16} {} frames, {} of them cross; {} steps free from a free frame, {} end in a crossing\n",
             GetParam(), frames, crossing_frames, free, crossed);
}

INSTANTIATE_TEST_SUITE_P(Motions, RealMotions,
                         ::testing::Values("hand_anim", "hand_train", "samba", "horse_poses", "horse_gallop",
                                           "rumba"),
                         [](const auto& instance) { return std::string(instance.param); });

}  // namespace
}  // namespace foldproof::oracle
