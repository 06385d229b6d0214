// chart_holds against exact arithmetic: no two features of the patch come within the gap, and no two
// triangles cross.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "certificate/chart_builder.h"
#include "certificate/contacts.h"
#include "certificate/patches.h"

namespace foldproof::testing {
namespace {

struct CertifiedPose {
  PosedPatch posed;
  Chart chart;
};

std::vector<CertifiedPose> certified_poses(Rng& rng) {
  std::vector<CertifiedPose> all;
  for (PosedPatch& p : chartable_patches(rng)) {
    UvMap uv_map;
    EXPECT_EQ(parametrize(p.patch, p.x, uv_map), ChartOutcome::Made) << p.name;
    Chart chart(p.patch, uv_map);
    all.push_back({std::move(p), std::move(chart)});
  }
  return all;
}

std::vector<Vec3> between(const Step& step, double t) {
  std::vector<Vec3> x;
  for (std::size_t v = 0; v < step.x0.size(); ++v) x.push_back((1 - t) * step.x0[v] + t * step.x1[v]);
  return x;
}

// The smallest distance at sampled times, without any continuous test.
double min_sampled_distance(const Patch& patch, const Step& step) {
  double nearest = 1e300;
  for (const double t : {0.0, 0.37, 0.5, 0.81, 1.0}) {
    const auto x = between(step, t);
    for (const FeaturePair& pair : all_pairs(patch)) {
      const FourPoints p = points_of(pair, x);
      const Closest c = pair.kind == oracle::Kind::VertexFace ? vertex_face_closest(p) : edge_edge_closest(p);
      nearest = std::min(nearest, c.distance);
    }
  }
  return nearest;
}

struct Count {
  int passes = 0, contacts_among_failures = 0, failures = 0;
};

void expect_sound(const PosedPatch& p, bool holds, const Step& step, double gap, Count& count) {
  const std::string contact =
      holds || count.failures % 4 == 0 ? find_contact(p.patch, step.x0, step.x1, gap) : "";
  if (!holds) {
    ++count.failures;
    count.contacts_among_failures += !contact.empty();
    return;
  }
  ++count.passes;
  ASSERT_EQ(contact, "") << p.name << ", gap " << gap;
  ASSERT_GT(min_sampled_distance(p.patch, step), gap) << p.name;
}

TEST(ChartSoundness, NothingComesWithinTheGap) {
  Rng rng(21);
  Count count;
  ChartScratch scratch;
  for (const double share : {0.0, 1e-3, 0.05, 0.3}) {
    for (const CertifiedPose& certified : certified_poses(rng)) {
      // In the chart's pose, features without a common vertex may be as near as the smallest altitude.
      const double gap = share * 0.5 * certified.chart.fit.min_altitude / 36000;
      HalfPass control(0.05);
      for (int k = 0; k < 40; ++k) {
        const Step step = random_step(certified.posed, control.size(), rng);
        const bool holds = chart_holds(certified.chart.view(), step.vertices, gap, scratch);
        control.record(holds);
        ASSERT_NO_FATAL_FAILURE(expect_sound(certified.posed, holds, step, gap, count));
      }
      EXPECT_GT(control.rate(), 0.05) << certified.posed.name << ", share " << share;
    }
  }
  EXPECT_GT(count.passes, 0.3 * (count.passes + count.failures));
  EXPECT_LT(count.passes, 0.7 * (count.passes + count.failures));
  // Otherwise the motions are too tame for the test to mean anything.
  EXPECT_GT(count.contacts_among_failures, 5);
}

// Motions that certainly collide: a triangle is pushed through its neighbors.
TEST(ChartSoundness, CollisionsAreNeverProvenFree) {
  Rng rng(22);
  ChartScratch scratch;
  int collisions = 0;
  for (int round = 0; round < 30; ++round) {
    for (const CertifiedPose& certified : certified_poses(rng)) {
      Step step = random_step(certified.posed, 0.02, rng);
      const auto& t = certified.posed.patch.triangles[rng() % certified.posed.patch.triangles.size()];
      const Vec3 push = 0.3 * random_direction(rng);
      for (const std::uint16_t v : t) step.x1[v] += push;
      fit_into_frame(step.x0, step.x1);
      step = Step(step.x0, step.x1);
      if (find_contact(certified.posed.patch, step.x0, step.x1, 0).empty()) continue;
      ++collisions;
      ASSERT_FALSE(chart_holds(certified.chart.view(), step.vertices, 0, scratch)) << certified.posed.name;
    }
  }
  EXPECT_GT(collisions, 50);
}

// Near the limit and far from it, triangles that pass the cheap test also pass the exact one.
TEST(ChartSoundness, TheCheapTestProvesNoMoreThanTheExactOne) {
  Rng rng(24);
  ChartScratch scratch;
  int passes = 0, failures = 0, by_cheap_test = 0;
  for (const CertifiedPose& certified : certified_poses(rng)) {
    const std::vector<float> all_unproven(certified.chart.triangles.size(),
                                          std::numeric_limits<float>::infinity());
    ChartView exact_only{certified.chart.vertices, certified.chart.points, certified.chart.triangles,
                         all_unproven, certified.chart.fit};
    HalfPass control(0.05);
    for (int k = 0; k < 60; ++k) {
      const Step step = random_step(certified.posed, control.size() * uniform(rng, 0.3, 3), rng);
      const bool exact = chart_holds(exact_only, step.vertices, 0, scratch);
      const bool holds = chart_holds(certified.chart.view(), step.vertices, 0, scratch);
      by_cheap_test += holds && scratch.unproven.empty();
      control.record(exact);
      ASSERT_EQ(holds, exact) << certified.posed.name;
      (exact ? passes : failures) += 1;
    }
  }
  EXPECT_GT(passes, 100);
  EXPECT_GT(failures, 100);
  EXPECT_GT(by_cheap_test, 50);
}

TEST(ChartSoundness, NoTrianglesCrossInAPose) {
  Rng rng(23);
  ChartScratch scratch;
  int passes = 0, tries = 0;
  for (const CertifiedPose& certified : certified_poses(rng)) {
    HalfPass control(0.1);
    for (int k = 0; k < 15; ++k, ++tries) {
      const Step moving = random_step(certified.posed, control.size(), rng);
      const Step still(moving.x0, moving.x0);
      const bool holds = chart_holds(certified.chart.view(), still.vertices, 0, scratch);
      control.record(holds);
      if (!holds) continue;
      ++passes;
      ASSERT_EQ(find_crossing(certified.posed.patch, still.x0), "") << certified.posed.name;
    }
  }
  EXPECT_GT(passes, 0.3 * tries);
  EXPECT_LT(passes, 0.7 * tries);
}

// ---- As in a query: with a hierarchy and a frame around the whole scene, far from its center.

struct Placement {
  const char* name;
  // The scene is 2 units wide. The patch is half a unit times `size`, `offset` from the center.
  double size, offset;
};

class InAScene : public ::testing::TestWithParam<Placement> {};

TEST_P(InAScene, NothingComesWithinTheGap) {
  Rng rng(24);
  const Placement placement = GetParam();
  const Frame frame = frame_around(Vec3::Constant(-1000.3), Vec3::Constant(1000.9));
  int passes = 0, tries = 0;
  for (const PosedPatch& p : chartable_patches(rng)) {
    std::vector<Triangle> triangles;
    for (const auto& t : p.patch.triangles) triangles.push_back({t[0], t[1], t[2]});
    const auto flat = [&](std::span<const Vec3> x) {
      std::vector<double> y;
      for (const Vec3& v : x) {
        const Vec3 q = 1000 * (placement.size * v + placement.offset * Vec3(0.7, -0.9, 0.3));
        y.insert(y.end(), {q.x(), q.y(), q.z()});
      }
      return y;
    };
    const auto topology = Topology::make(static_cast<Index>(p.x.size()), triangles).value();
    const auto hierarchy =
        std::make_shared<const Hierarchy>(Hierarchy::build(topology, flat(p.x), {8}).value());
    KineticBvh bvh(hierarchy);
    const PatchSlots slots(hierarchy);
    ChartBuilder builder(slots);
    BuiltChart built;
    built.slot = slots.of_node(0);
    bvh.refit(frame, flat(p.x), flat(p.x));
    builder.build(bvh.vertices, built);
    if (built.outcome != ChartOutcome::Made) continue;  // too coarse in single precision
    const Chart chart(built.patch, built.uv_map);
    ChartScratch scratch;
    HalfPass control(0.05);
    for (int k = 0; k < 25; ++k, ++tries) {
      const Step step = random_step(p, control.size(), rng);
      const auto x0 = flat(step.x0), x1 = flat(step.x1);
      bvh.refit(frame, x0, x1);
      const double gap = k % 2 ? 1000 * placement.size * log_uniform(rng, 1e-5, 1e-2) : 0;  // in mesh units
      const bool holds = chart_holds(chart.view(), bvh.vertices, gap * frame.scale * (1 + 0x1p-50), scratch);
      control.record(holds);
      if (!holds) continue;
      ++passes;
      // In mesh units and the mesh's numbering, before any rounding.
      const auto vec = [](const std::vector<double>& x) {
        std::vector<Vec3> y;
        for (std::size_t i = 0; i < x.size(); i += 3) y.emplace_back(x[i], x[i + 1], x[i + 2]);
        return y;
      };
      ASSERT_EQ(find_contact(p.patch, vec(x0), vec(x1), gap), "") << p.name << ", gap " << gap;
    }
  }
  EXPECT_GT(tries, 0);
  EXPECT_GT(passes, 0.3 * tries);
  EXPECT_LT(passes, 0.7 * tries);
}

INSTANTIATE_TEST_SUITE_P(Placements, InAScene,
                         ::testing::Values(Placement{"whole", 0.9, 0}, Placement{"small", 1e-2, 0.8},
                                           Placement{"tiny", 1e-3, 0.9}, Placement{"dust", 1e-4, 0.9}),
                         [](const auto& instance) { return std::string(instance.param.name); });

// ---- A thin triangle that turns over. In single precision, products of its long sides lose more than its
// whole width.

// Uv coordinates, and positions in the plane z = 0: x y at the start, x y at the end.
const std::vector<Uv> kThinUvs{
    {307, -201},     {-7189, 4717},    {7189, -4717},   {-3291, -5017}, {3291, 5017},    {-16618, 5485},
    {-17134, -3559}, {-13059, -11649}, {-5485, -16618}, {3559, -17134}, {11649, -13059}, {16618, -5485},
    {17134, 3559},   {13059, 11649},   {5485, 16618},   {-3559, 17134}, {-11649, 13059}};
const std::vector<std::array<std::uint16_t, 3>> kThinTriangles{
    {0, 1, 2},   {2, 1, 3},  {1, 0, 4},   {0, 2, 4},   {1, 16, 5},  {1, 5, 6},   {1, 6, 7},
    {1, 7, 3},   {3, 7, 8},  {3, 8, 9},   {3, 9, 10},  {3, 10, 2},  {2, 10, 11}, {2, 11, 12},
    {2, 12, 13}, {2, 13, 4}, {4, 13, 14}, {4, 14, 15}, {4, 15, 16}, {4, 16, 1}};
const std::vector<std::array<std::uint16_t, 3>> kThinScaffold{
    {14, 13, 17}, {15, 14, 17}, {15, 17, 18}, {16, 15, 18}, {5, 16, 18}, {6, 5, 18},
    {6, 18, 19},  {7, 6, 19},   {8, 7, 19},   {9, 8, 19},   {9, 19, 20}, {10, 9, 20},
    {11, 10, 20}, {12, 11, 20}, {12, 20, 17}, {13, 12, 17}};
constexpr double kThinPositions[][4] = {{0x1.b54f58p-9, -0x1.bcca38p-10, 0x1.7b3448p-9, -0x1.387284p-9},
                                        {-0x1.40487ep-4, 0x1.45a72ap-5, -0x1.154ee6p-4, 0x1.ca8e4ep-5},
                                        {0x1.40487ep-4, -0x1.45a72ep-5, 0x1.154ee6p-4, -0x1.ca8e4ep-5},
                                        {-0x1.a6d8f6p-5, -0x1.749b9ep-4, -0x1.01990ap-4, -0x1.5651b4p-4},
                                        {0x1.a6d902p-5, 0x1.749ba2p-4, 0x1.01990ap-4, 0x1.5651b4p-4},
                                        {-0x1.03a8p-2, 0x1.56d002p-4, -0x1.03a8p-2, 0x1.56dp-4},
                                        {-0x1.0bb8p-2, -0x1.bce006p-5, -0x1.0bb8p-2, -0x1.bcep-5},
                                        {-0x1.9818p-3, -0x1.6c0802p-3, -0x1.9818p-3, -0x1.6c08p-3},
                                        {-0x1.56cffep-4, -0x1.03a8p-2, -0x1.56dp-4, -0x1.03a8p-2},
                                        {0x1.bcdffcp-5, -0x1.0bb8p-2, 0x1.bcep-5, -0x1.0bb8p-2},
                                        {0x1.6c08p-3, -0x1.9818p-3, 0x1.6c08p-3, -0x1.9818p-3},
                                        {0x1.03a8p-2, -0x1.56cffcp-4, 0x1.03a8p-2, -0x1.56dp-4},
                                        {0x1.0bb8p-2, 0x1.bcep-5, 0x1.0bb8p-2, 0x1.bcep-5},
                                        {0x1.9818p-3, 0x1.6c08p-3, 0x1.9818p-3, 0x1.6c08p-3},
                                        {0x1.56d002p-4, 0x1.03a8p-2, 0x1.56dp-4, 0x1.03a8p-2},
                                        {-0x1.bce006p-5, 0x1.0bb8p-2, -0x1.bcep-5, 0x1.0bb8p-2},
                                        {-0x1.6c0802p-3, 0x1.9818p-3, -0x1.6c08p-3, 0x1.9818p-3}};

// The uvs of a patch, shrunk around the center of the square.
UvMap shrunk(UvMap uv_map, double factor) {
  for (Uv& uv : uv_map.uvs) {
    for (auto& c : uv) c = static_cast<std::int16_t>(std::lround(c * factor));
  }
  return uv_map;
}

// Rounding of sides that end in a corner of the square is only covered where the patch is not much smaller.
TEST(ChartSoundness, AChartWhosePatchIsTooSmallProvesNothing) {
  const PosedPatch p = sheet("flat", 4, 4, [](double u, double v) { return Vec3(u - 0.5, v - 0.5, 0); });
  UvMap uv_map;
  ASSERT_EQ(parametrize(p.patch, p.x, uv_map), ChartOutcome::Made);
  const Step still(p.x, p.x);
  ChartScratch scratch;
  for (const auto& [factor, holds] : {std::pair(1.0, true), {0.05, true}, {0.03, false}, {0.01, false}}) {
    const UvMap small = shrunk(uv_map, factor);
    ASSERT_TRUE(chart_is_valid(p.patch, small)) << factor;
    const Chart chart(p.patch, small);
    EXPECT_EQ(chart_holds(chart.view(), still.vertices, 0, scratch), holds) << factor;
  }
}

TEST(ChartSoundness, AThinTriangleThatTurnsOverIsFound) {
  Patch patch;
  UvMap uv_map;
  patch.triangles = kThinTriangles;
  uv_map.uvs = kThinUvs;
  uv_map.heights.assign(kThinUvs.size(), 0);
  uv_map.scaffold = kThinScaffold;
  std::vector<Vec3> x0, x1;
  for (const auto& p : kThinPositions) {
    patch.vertices.push_back(static_cast<Index>(x0.size()));
    x0.emplace_back(p[0], p[1], 0);
    x1.emplace_back(p[2], p[3], 0);
  }
  ASSERT_TRUE(chart_is_valid(patch, uv_map));
  const Step step(x0, x1);
  ASSERT_NE(find_contact(patch, x0, x1, 0), "");
  ChartScratch scratch;
  EXPECT_FALSE(chart_holds(Chart(patch, uv_map).view(), step.vertices, 0, scratch));
}

}  // namespace
}  // namespace foldproof::testing
