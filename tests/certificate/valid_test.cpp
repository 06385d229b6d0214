// chart_is_valid against simple exact geometry, on charts that were corrupted in many ways.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "certificate/coverage.h"
#include "certificate/patches.h"

namespace foldproof::testing {
namespace {

struct TestChart {
  Patch patch;
  UvMap uv_map;
};

std::size_t any(Rng& rng, std::size_t count) { return rng() % count; }

using Corners = std::array<std::uint16_t, 3>;

Corners& any_triangle(TestChart& chart, Rng& rng) {
  const std::size_t patch = chart.patch.triangles.size(), all = patch + chart.uv_map.scaffold.size(),
                    k = any(rng, all);
  return k < patch ? chart.patch.triangles[k] : chart.uv_map.scaffold[k - patch];
}

void reverse_triangle(TestChart& chart, Rng& rng) {
  Corners& t = any_triangle(chart, rng);
  std::swap(t[0], t[1]);
}
void rotate_corners(TestChart& chart, Rng& rng) {
  Corners& t = any_triangle(chart, rng);
  std::rotate(t.begin(), t.begin() + 1, t.end());
}
void remove_scaffold_triangle(TestChart& chart, Rng& rng) {
  chart.uv_map.scaffold.erase(chart.uv_map.scaffold.begin() +
                              static_cast<std::ptrdiff_t>(any(rng, chart.uv_map.scaffold.size())));
}
void duplicate_triangle(TestChart& chart, Rng& rng) {
  chart.uv_map.scaffold.push_back(any_triangle(chart, rng));
}
void replace_corner(TestChart& chart, Rng& rng) {
  any_triangle(chart, rng)[any(rng, 3)] = static_cast<std::uint16_t>(any(rng, chart.uv_map.uvs.size() + 4));
}
void use_missing_vertex(TestChart& chart, Rng& rng) {
  any_triangle(chart, rng)[any(rng, 3)] =
      static_cast<std::uint16_t>(chart.uv_map.uvs.size() + 4 + any(rng, 100));
}
void shift_uv(TestChart& chart, Rng& rng) {
  Uv& p = chart.uv_map.uvs[any(rng, chart.uv_map.uvs.size())];
  const double distance = log_uniform(rng, 1, 20000);
  for (auto& c : p)
    c = static_cast<std::int16_t>(std::clamp(c + uniform(rng, -distance, distance), -32767.0, 32767.0));
}
void swap_uvs(TestChart& chart, Rng& rng) {
  auto& uvs = chart.uv_map.uvs;
  std::swap(uvs[any(rng, uvs.size())], uvs[any(rng, uvs.size())]);
}
// Flips the diagonal of two triangles with a common side. The square stays covered where their union is
// convex.
void flip_diagonal(TestChart& chart, Rng& rng) {
  auto& scaffold = chart.uv_map.scaffold;
  for (int attempt = 0; attempt < 1000; ++attempt) {
    Corners &s = scaffold[any(rng, scaffold.size())], &t = scaffold[any(rng, scaffold.size())];
    for (int k = 0; k < 9; ++k, std::rotate(s.begin(), s.begin() + 1, s.end())) {
      if (k % 3 == 0) std::rotate(t.begin(), t.begin() + 1, t.end());
      if (s[0] != t[1] || s[1] != t[0]) continue;
      const Corners a{s[0], t[2], s[2]}, b{t[2], s[1], s[2]};
      s = a;
      t = b;
      return;
    }
  }
}
// Splits a triangle in three at a new vertex. The numbers of the square's corners follow those of the
// vertices.
void split_triangle(TestChart& chart, Rng& rng) {
  const auto added = static_cast<std::uint16_t>(chart.uv_map.uvs.size());
  for (auto* group : {&chart.patch.triangles, &chart.uv_map.scaffold}) {
    for (Corners& c : *group) {
      for (std::uint16_t& v : c) v = static_cast<std::uint16_t>(v + (v >= added));
    }
  }
  Corners& t = any_triangle(chart, rng);
  const Corners old = t;
  t = {old[0], old[1], added};
  chart.uv_map.scaffold.push_back({old[1], old[2], added});
  chart.uv_map.scaffold.push_back({old[2], old[0], added});
  Uv centroid{};
  for (int c = 0; c < 2; ++c) {
    int sum = 0;
    for (const std::uint16_t v : old)
      sum += v < added ? chart.uv_map.uvs[v][c] : kChartCorners[v - added - 1][c];
    centroid[c] = static_cast<std::int16_t>(sum / 3);
  }
  chart.patch.vertices.push_back(added);
  chart.uv_map.uvs.push_back(centroid);
}

struct Corruption {
  const char* name;
  void (*apply)(TestChart&, Rng&);
};
constexpr Corruption kCorruptions[] = {{"reverse_triangle", reverse_triangle},
                                       {"rotate_corners", rotate_corners},
                                       {"remove_scaffold_triangle", remove_scaffold_triangle},
                                       {"duplicate_triangle", duplicate_triangle},
                                       {"replace_corner", replace_corner},
                                       {"use_missing_vertex", use_missing_vertex},
                                       {"shift_uv", shift_uv},
                                       {"swap_uvs", swap_uvs},
                                       {"flip_diagonal", flip_diagonal}};

std::vector<TestChart> valid_charts(Rng& rng) {
  std::vector<TestChart> all;
  for (const PosedPatch& p : chartable_patches(rng)) {
    TestChart chart{p.patch, {}};
    if (parametrize(p.patch, p.x, chart.uv_map) == ChartOutcome::Made) all.push_back(std::move(chart));
  }
  return all;
}

TEST(ChartIsValid, AgreesWithSimpleGeometryOnCorruptedCharts) {
  Rng rng(11);
  const std::vector<TestChart> good = valid_charts(rng);
  ASSERT_GE(good.size(), 8u);
  int valid = 0, tries = 0;
  for (int round = 0; round < 400; ++round) {
    TestChart chart = good[any(rng, good.size())];
    std::string what;
    // Several in a row may cancel out. Harmless ones are more frequent, so that many charts stay valid.
    for (std::size_t n = 1 + any(rng, 3); n > 0; --n) {
      const Corruption& corruption = any(rng, 3) == 0 ? kCorruptions[any(rng, std::size(kCorruptions))]
                                                      : kCorruptions[std::array{1, 6, 8}[any(rng, 3)]];
      corruption.apply(chart, rng);
      what += std::string(" ") + corruption.name;
    }
    const Coverage coverage(chart.patch, chart.uv_map, rng());
    const bool expected = coverage.is_valid(), actual = chart_is_valid(chart.patch, chart.uv_map);
    ++tries;
    valid += actual;
    if (actual) {
      ASSERT_TRUE(expected) << "accepted after" << what;
    } else {
      // Vertices on the sides of the square are refused, although the theorem allows them.
      ASSERT_TRUE(!expected || coverage.touches_border()) << "refused after" << what;
    }
  }
  EXPECT_GT(valid, 0.3 * tries);
  EXPECT_LT(valid, 0.7 * tries);
}

TEST(ChartIsValid, EachCorruptionAloneIsFound) {
  Rng rng(12);
  const std::vector<TestChart> good = valid_charts(rng);
  for (const auto apply :
       {reverse_triangle, remove_scaffold_triangle, duplicate_triangle, use_missing_vertex}) {
    for (TestChart chart : good) {
      apply(chart, rng);
      EXPECT_FALSE(chart_is_valid(chart.patch, chart.uv_map));
    }
  }
}

TEST(ChartIsValid, AFinerTriangulationStaysValid) {
  Rng rng(13);
  for (TestChart chart : valid_charts(rng)) {
    int splits = 0;
    for (int k = 0; k < 10; ++k) {
      TestChart before = chart;
      split_triangle(chart, rng);
      const bool valid = chart_is_valid(chart.patch, chart.uv_map);
      EXPECT_EQ(valid, Coverage(chart.patch, chart.uv_map, k).is_valid());
      splits += valid;
      if (!valid) chart = before;  // the new vertex was rounded to the border of a thin triangle
    }
    EXPECT_GT(splits, 5);
  }
}

TEST(ChartIsValid, SizesThatDoNotMatchAreRefused) {
  Rng rng(14);
  TestChart chart = valid_charts(rng)[0];
  chart.uv_map.uvs.pop_back();
  EXPECT_FALSE(chart_is_valid(chart.patch, chart.uv_map));
  chart = valid_charts(rng)[0];
  chart.patch.vertices.push_back(99);
  EXPECT_FALSE(chart_is_valid(chart.patch, chart.uv_map));
  EXPECT_FALSE(chart_is_valid({}, {}));
}

// Two layers of the square, and triangles that wind around a vertex twice: each triangle is valid, the total
// area is not.
TEST(ChartIsValid, CoveringTwiceIsRefused) {
  UvMap twice;
  Patch none;
  twice.scaffold = {{0, 1, 2}, {0, 2, 3}, {0, 1, 3}, {1, 2, 3}};
  EXPECT_FALSE(chart_is_valid(none, twice));
  twice.scaffold = {{0, 1, 2}, {0, 2, 3}};
  EXPECT_TRUE(chart_is_valid(none, twice));
  // Around the vertex 0, two turns.
  Patch wheel;
  UvMap winding;
  wheel.vertices = {0, 1, 2, 3, 4};
  winding.uvs = {{0, 0}, {10000, 10000}, {-10000, 10000}, {-10000, -10000}, {10000, -10000}};
  const auto corner = [](int k) { return static_cast<std::uint16_t>(5 + k % 4); };
  const auto inner = [](int k) { return static_cast<std::uint16_t>(1 + k % 4); };
  for (int k = 0; k < 4; ++k) {
    wheel.triangles.push_back({0, inner(k), inner(k + 1)});
    wheel.triangles.push_back({0, corner(k), corner(k + 1)});
  }
  EXPECT_FALSE(chart_is_valid(wheel, winding));
}

}  // namespace
}  // namespace foldproof::testing
