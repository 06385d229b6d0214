// What Parametrizer builds and what it refuses.
#include <gmock/gmock.h>

#include <cmath>

#include "certificate/coverage.h"
#include "certificate/patches.h"

namespace foldproof::testing {
namespace {

// Every generic point of the square lies in exactly one triangle.
void expect_covered_once(const Coverage& coverage, const std::string& name) {
  EXPECT_TRUE(coverage.all_counterclockwise()) << name;
  EXPECT_TRUE(coverage.covers_once()) << name;
  EXPECT_TRUE(coverage.continuous()) << name;
  Rng rng(7);
  int tested = 0;
  for (int k = 0; k < 2000; ++k) {
    const int extent = 2 * kChartCorners[0][0] - 1;
    const int x = static_cast<int>(uniform(rng, -extent, extent)),
              y = static_cast<int>(uniform(rng, -extent, extent));
    const int count = coverage.count_at(x, y);
    if (count < 0) continue;
    ++tested;
    ASSERT_EQ(count, 1) << name << " at " << x << " " << y << " halves";
  }
  EXPECT_GT(tested, 1900);
}

TEST(Parametrizer, ChartsCoverTheSquareOnce) {
  Rng rng(1);
  for (const PosedPatch& p : chartable_patches(rng)) {
    UvMap uv_map;
    ASSERT_EQ(parametrize(p.patch, p.x, uv_map), ChartOutcome::Made) << p.name;
    EXPECT_TRUE(chart_is_valid(p.patch, uv_map)) << p.name;
    expect_covered_once(Coverage(p.patch, uv_map, 1), p.name);
  }
}

TEST(Parametrizer, DeformedPatchesGetAValidChartOrNone) {
  Rng rng(2);
  HalfPass control(0.05);
  for (int k = 0; k < 60; ++k) {
    for (const PosedPatch& p : chartable_patches(rng)) {
      const auto x = deformed(p.x, control.size(), 0.5, rng);
      UvMap uv_map;
      const bool made = parametrize(p.patch, x, uv_map) == ChartOutcome::Made;
      control.record(made);
      if (!made) continue;
      const Coverage coverage(p.patch, uv_map, k);
      ASSERT_TRUE(coverage.is_valid()) << p.name << " in round " << k;
    }
  }
  EXPECT_GT(control.rate(), 0.3);
  EXPECT_LT(control.rate(), 0.7);
}

// Rotation and scale of a pose do not matter.
TEST(Parametrizer, PosesOfAnyOrientationAndSizeHaveCharts) {
  Rng rng(3);
  for (const PosedPatch& p : chartable_patches(rng)) {
    for (const double scale : {0x1p-20, 0x1p-10, 1.0}) {
      auto x = moved(p.x, uniform(rng, 0, 3), 0.2, rng);
      for (Vec3& v : x) v *= scale;
      UvMap uv_map;
      EXPECT_EQ(parametrize(p.patch, x, uv_map), ChartOutcome::Made) << p.name << " times " << scale;
    }
  }
}

PosedPatch numbered_from_zero(PosedPatch p) {
  p.patch.vertices.clear();
  for (std::size_t v = 0; v < p.x.size(); ++v) p.patch.vertices.push_back(static_cast<Index>(v));
  return p;
}

PosedPatch flat_square(std::string name) {
  return sheet(std::move(name), 3, 3, [](double u, double v) { return Vec3(u, v, 0); });
}

struct Refused {
  PosedPatch patch;
  std::vector<ChartOutcome> reasons;
};

std::vector<Refused> refused_patches() {
  using enum ChartOutcome;
  std::vector<Refused> all;
  PosedPatch degenerate = flat_square("triangle_without_area");
  degenerate.patch.triangles.push_back({0, 1, 2});  // three collinear points
  all.push_back({degenerate, {TooCurved}});
  PosedPatch coincident = flat_square("coincident_vertices");
  coincident.x[5] = coincident.x[6];
  all.push_back({coincident, {TooCurved}});
  PosedPatch fins = flat_square("three_triangles_at_an_edge");
  fins.x.emplace_back(0.5, 0.5, 1);
  fins = numbered_from_zero(fins);
  fins.patch.triangles.push_back({5, 6, 16});
  all.push_back({fins, {Overlapping, TooCurved}});
  PosedPatch reversed = flat_square("one_triangle_reversed");
  std::swap(reversed.patch.triangles[4][0], reversed.patch.triangles[4][1]);
  all.push_back({reversed, {TooCurved}});
  PosedPatch duplicate = flat_square("duplicate_triangle");
  duplicate.patch.triangles.push_back(duplicate.patch.triangles[4]);
  all.push_back({duplicate, {Overlapping}});
  const PosedPatch pieces = part_of(flat_square("two_pieces"), [](std::size_t t) { return t / 2 % 3 != 1; });
  all.push_back({pieces, {Overlapping}});
  all.push_back({sheet("overlaps_itself", 30, 1,
                       [](double u, double v) {  // a spiral staircase of a turn and a half
                         const double angle = 9 * u, radius = 1 - 0.3 * v;
                         return Vec3(radius * std::cos(angle), radius * std::sin(angle), 0.1 * u);
                       }),
                 {Overlapping}});
  all.push_back({sheet("half_pipe_and_more", 12, 3,
                       [](double u, double v) { return Vec3(std::cos(5 * u), std::sin(5 * u), v); }),
                 {TooCurved}});
  all.push_back(
      {sheet("folded_over", 4, 4, [](double u, double v) { return Vec3(std::abs(u - 0.5), v, 0.1 * u); }),
       {TooCurved}});
  return all;
}

TEST(Parametrizer, PatchesWithoutChartAreRefused) {
  for (const Refused& r : refused_patches()) {
    UvMap uv_map;
    const ChartOutcome outcome = parametrize(r.patch.patch, r.patch.x, uv_map);
    EXPECT_THAT(r.reasons, ::testing::Contains(outcome)) << r.patch.name;
  }
}

TEST(Parametrizer, TooManyVerticesAreRefused) {
  const PosedPatch big = sheet("big", 260, 252, [](double u, double v) { return Vec3(u, v, 0); });
  ASSERT_GT(big.x.size(), 0xFFF0u);
  UvMap uv_map;
  EXPECT_EQ(parametrize(big.patch, big.x, uv_map), ChartOutcome::TooLarge);
}

}  // namespace
}  // namespace foldproof::testing
