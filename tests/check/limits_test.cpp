// Limits: how many pairs are counted and listed, copies of triangles, unused vertices, and coordinates at the
// ends of double's range.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "base/callers.h"
#include "check/same_collisions.h"
#include "foldproof/check.h"
#include "oracle/brute_force.h"
#include "oracle/meshes.h"

namespace foldproof {
namespace {

using oracle::Scene;
using testing::expect_same;
using testing::expect_same_collisions;

Scene scene_of(const std::vector<const oracle::MeshFamily*>& families, oracle::Rng& rng) {
  Scene scene;
  for (const oracle::MeshFamily* family : families) {
    const oracle::Mesh mesh = family->make(rng);
    scene.topologies.push_back(mesh.topology());
    scene.x0.push_back(oracle::deformed(mesh.positions, 0.1, 0, rng));
    scene.x1.push_back(oracle::deformed(scene.x0.back(), 0.3, 0, rng));
  }
  return scene;
}

StepResult step(const Scene& scene, const StepSettings& settings) {
  StepChecker checker(scene.hierarchies(12));
  StepResult result;
  const auto x0 = scene.spans0(), x1 = scene.spans1();
  EXPECT_TRUE(checker.check(x0, x1, settings, result));
  return result;
}

StaticResult pose(const Scene& scene, const StepSettings& settings) {
  StepChecker checker(scene.hierarchies(12));
  StaticResult result;
  const auto x = scene.spans0();
  EXPECT_TRUE(checker.check_static(x, settings, result));
  return result;
}

template <class Collision>
std::vector<Collision> first(const std::vector<Collision>& all, std::size_t count) {
  return {all.begin(), all.begin() + static_cast<std::ptrdiff_t>(std::min(count, all.size()))};
}

std::vector<oracle::PairKey> keys(const std::vector<TriangleCrossing>& crossings) {
  std::vector<oracle::PairKey> all;
  for (const TriangleCrossing& c : crossings) all.push_back(oracle::key(c));
  return all;
}

TEST(Limits, WhatFailedIsNotClean) {
  oracle::Rng rng(3);
  const Scene scene = scene_of({&oracle::mesh_families()[0]}, rng);
  StepChecker checker(scene.hierarchies(12));
  StepResult step;
  StaticResult pose;
  EXPECT_FALSE(step.clean() || pose.clean());
  StepSettings settings;
  settings.max_listed = 0;
  const auto ask = [&](double coordinate, bool within) {
    settings.within = within;
    auto x = scene.x0;
    x[0][0] = coordinate;
    const std::vector<std::span<const double>> x0(x.begin(), x.end());
    return std::array{checker.check(x0, x0, settings, step).has_value() && step.complete,
                      checker.check_static(x0, settings, pose).has_value() && pose.complete};
  };
  const double nan = std::numeric_limits<double>::quiet_NaN(), place = scene.x0[0][0];
  EXPECT_EQ(ask(place, true), (std::array{true, true}));
  for (const auto& [coordinate, within] : {std::pair(nan, true), std::pair(place, false)}) {
    EXPECT_EQ(ask(coordinate, within), (std::array{false, false}));
    EXPECT_FALSE(step.complete || pose.complete || step.clean() || pose.clean());
  }
}

// Many triangles around a vertex are found like others, although their leaves have no charts in pairs.
TEST(Limits, AVertexMayHaveVeryManyTriangles) {
  const Index count = 4000;
  std::vector<double> x0{0, 0, 0}, x1;
  std::vector<Triangle> triangles;
  for (Index i = 0; i <= count; ++i) {
    const double angle = 6.0 * i / count;
    x0.insert(x0.end(), {std::cos(angle), std::sin(angle), 0.0});
    if (i > 0) triangles.push_back({0, i, i + 1});
  }
  x1 = x0;
  x1[3 * 1] = std::cos(2.0);  // the first vertex of the rim goes through the fan
  x1[3 * 1 + 1] = std::sin(2.0);
  x0[3 * 1 + 2] = 0.2;
  x1[3 * 1 + 2] = -0.2;
  const auto tree = std::make_shared<const Hierarchy>(
      *Hierarchy::build(*Topology::make(count + 2, std::move(triangles)), x0, {.leaf_triangles = 4}));
  StepChecker with({tree}), without({tree});
  StepResult a, b;
  StepSettings plain;
  plain.certificates = false;
  for (int step = 0; step < 4; ++step) {
    ASSERT_TRUE(with.check(x0, x1, {}, a));
    ASSERT_TRUE(without.check(x0, x1, plain, b));
    ASSERT_NO_FATAL_FAILURE(expect_same_collisions(a, b));
  }
  EXPECT_FALSE(b.clean());
}

TEST(Limits, AllAreCountedAndThoseWithTheSmallestIdsAreListed) {
  oracle::Rng rng(77);
  std::uint64_t not_listed = 0;
  for (const oracle::MeshFamily& family : oracle::mesh_families()) {
    SCOPED_TRACE(family.name);
    const Scene scene = scene_of({&family, &oracle::mesh_families()[0]}, rng);
    const StepResult all = step(scene, {});
    const StaticResult all_crossings = pose(scene, {});
    EXPECT_EQ(all.vertex_face_count, all.vertex_face.size());
    EXPECT_EQ(all.edge_edge_count, all.edge_edge.size());
    EXPECT_EQ(all_crossings.crossing_count, all_crossings.crossings.size());
    for (const std::uint64_t limit : {0u, 1u, 7u, 100u}) {
      const auto test = [&] {
        StepSettings settings;
        settings.max_listed = limit;
        const StepResult some = step(scene, settings);
        expect_same(some.vertex_face, first(all.vertex_face, limit));
        expect_same(some.edge_edge, first(all.edge_edge, limit));
        EXPECT_EQ(some.vertex_face_count, all.vertex_face_count);
        EXPECT_EQ(some.edge_edge_count, all.edge_edge_count);
        EXPECT_EQ(some.earliest_toi, all.earliest_toi);
        EXPECT_EQ(some.clean(), all.clean());
        not_listed += all.count() - some.vertex_face.size() - some.edge_edge.size();
        const StaticResult crossings = pose(scene, settings);
        EXPECT_EQ(keys(crossings.crossings), keys(first(all_crossings.crossings, limit)));
        EXPECT_EQ(crossings.crossing_count, all_crossings.crossing_count);

        settings.earliest_only = true;
        const StepResult earliest = step(scene, settings);
        EXPECT_EQ(earliest.earliest_toi, all.earliest_toi);
        EXPECT_EQ(earliest.count(), all.clean() ? 0u : 1u);
        EXPECT_EQ(earliest.vertex_face.size() + earliest.edge_edge.size(), earliest.count());
      };
      for (const int threads : {1, 4}) with_threads(threads, test);
    }
  }
  EXPECT_GT(not_listed, 10000u);
}

// Many more pairs than the limit, so that the list is cut several times.
TEST(Limits, ALongListIsCutSeveralTimes) {
  Scene scene;
  std::vector<Triangle> triangles;
  std::vector<double> x;
  for (Index i = 0; i < 300; ++i) {
    triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    const double s = 1 + 0.001 * ((i * 7919) % 300);
    x.insert(x.end(), {0, 0, 0, s, 0, 0, 0, s, 0});
  }
  scene.topologies.push_back(*Topology::make(900, triangles));
  scene.x0 = scene.x1 = {x};
  const StaticResult all = pose(scene, {});
  EXPECT_EQ(all.crossing_count, 300u * 299 / 2);
  for (const std::uint64_t limit : {10u, 5000u, 40000u}) {
    StepSettings settings;
    settings.max_listed = limit;
    const StaticResult some = pose(scene, settings);
    EXPECT_EQ(some.crossing_count, all.crossing_count);
    EXPECT_EQ(keys(some.crossings), keys(first(all.crossings, limit)));
  }
}

// Meshes with copies of triangles, with their vertices in the same order and in others.
TEST(Copies, AnswersEqualBruteForce) {
  oracle::Rng rng(78);
  std::uint64_t crossings = 0, hits = 0;
  for (const oracle::MeshFamily& family : oracle::mesh_families()) {
    SCOPED_TRACE(family.name);
    Scene scene = scene_of({&family}, rng);
    std::vector<Triangle> triangles(scene.topologies[0].triangles().begin(),
                                    scene.topologies[0].triangles().end());
    const std::size_t once = std::min<std::size_t>(triangles.size(), 80);
    triangles.resize(once);
    for (std::size_t i = 0; i < 2 * once; ++i) {
      const Triangle t = triangles[rng() % once];
      triangles.push_back(rng() % 3 == 0   ? Triangle{t[1], t[2], t[0]}
                          : rng() % 3 == 0 ? Triangle{t[0], t[2], t[1]}
                                           : t);
    }
    const Index vertices = scene.topologies[0].vertex_count();
    scene.topologies[0] = *Topology::make(vertices, triangles);
    // Another object, without copies.
    const oracle::Mesh other = oracle::mesh_families()[0].make(rng);
    scene.topologies.push_back(other.topology());
    scene.x0.push_back(other.positions);
    scene.x1.push_back(oracle::deformed(other.positions, 0.2, 0, rng));
    for (const bool within : {true, false}) {
      StepSettings settings;
      settings.within = within;
      const StepResult found = step(scene, settings);
      StepResult expected = oracle::brute_force_step(scene, settings, found.tolerance);
      const auto by_key = [](const auto& a, const auto& b) { return oracle::key(a) < oracle::key(b); };
      std::sort(expected.vertex_face.begin(), expected.vertex_face.end(), by_key);
      std::sort(expected.edge_edge.begin(), expected.edge_edge.end(), by_key);
      expect_same_collisions(found, expected);
      EXPECT_EQ(found.vertex_face_count, expected.vertex_face_count);
      EXPECT_EQ(found.edge_edge_count, expected.edge_edge_count);
      hits += found.vertex_face_count;

      const StaticResult crossed = pose(scene, settings);
      StaticResult exact = oracle::brute_force_static(scene, settings);
      auto sorted = keys(exact.crossings);
      std::sort(sorted.begin(), sorted.end());
      EXPECT_EQ(keys(crossed.crossings), sorted);
      EXPECT_EQ(crossed.crossing_count, exact.crossing_count);
      crossings += crossed.crossing_count;
      settings.max_listed = 50;
      EXPECT_EQ(keys(pose(scene, settings).crossings), first(sorted, 50));
      expect_same(step(scene, settings).vertex_face, first(expected.vertex_face, 50));
    }
  }
  EXPECT_GT(crossings, 1000u);
  EXPECT_GT(hits, 1000u);
}

// Layers: what crosses in a layered object is what crosses in others, but for faces with the same vertices.
TEST(Copies, LayersOfOneSurfaceDoNotCross) {
  oracle::Rng rng(79);
  std::uint64_t layers = 0, crossings = 0;
  for (const oracle::MeshFamily& family : oracle::mesh_families()) {
    SCOPED_TRACE(family.name);
    Scene scene = scene_of({&family, &family}, rng);
    for (Topology& topology : scene.topologies) {
      std::vector<Triangle> triangles(topology.triangles().begin(), topology.triangles().end());
      triangles.resize(std::min<std::size_t>(triangles.size(), 60));
      for (std::size_t i = 0, once = triangles.size(); i < once; ++i) {
        const Triangle t = triangles[i];
        if (i % 3 != 0) triangles.push_back(i % 3 == 1 ? t : Triangle{t[1], t[0], t[2]});
      }
      topology = *Topology::make(topology.vertex_count(), triangles);
    }
    std::vector<Object> objects = scene.hierarchies(12);
    objects[0].set_layered(true);
    StaticResult found;
    const auto x = scene.spans0();
    ASSERT_TRUE(StepChecker(objects).check_static(x, {}, found));
    std::vector<TriangleCrossing> expected;
    for (const TriangleCrossing& c : pose(scene, {}).crossings) {
      Triangle a = scene.topologies[c.object_a].triangles()[c.triangle_a];
      Triangle b = scene.topologies[c.object_b].triangles()[c.triangle_b];
      std::ranges::sort(a);
      std::ranges::sort(b);
      const bool layered = c.object_a == 0 && c.object_b == 0 && a == b;
      layers += layered;
      if (!layered) expected.push_back(c);
    }
    EXPECT_EQ(keys(found.crossings), keys(expected));
    EXPECT_EQ(found.crossing_count, expected.size());
    crossings += expected.size();
  }
  EXPECT_GT(layers, 100u);
  EXPECT_GT(crossings, 100u);
}

// A fan of a polygon that repeats three vertices: every third triangle has an area.
Scene fan(Index corners) {
  Scene scene;
  std::vector<Triangle> triangles;
  for (Index k = 2; k < corners; ++k) triangles.push_back({0, (k - 1) % 3, k % 3});
  scene.topologies.push_back(*Topology::make(3, triangles));
  scene.x0 = {{0, 0, 0, 1, 0, 0, 0, 1, 0}};
  scene.x1 = {{0, 0, 1, 1, 0, 1, 0, 1, 2}};
  return scene;
}

TEST(Copies, ARepeatedPolygonCostsLittle) {
#ifdef _GLIBCXX_DEBUG  // each binary search reads all of its range
  const Index corners = 7'500;
#else
  const Index corners = 75'000;
#endif
  const Scene scene = fan(corners);
  const std::uint64_t with_area = corners / 3;
  StepSettings settings;
  settings.max_listed = 100'000;
  settings.explain = true;
  const StaticResult crossed = pose(scene, settings);
  EXPECT_EQ(crossed.crossing_count, with_area * (with_area - 1) / 2);
  ASSERT_EQ(crossed.crossings.size(), settings.max_listed);
  for (std::size_t i = 0; i < crossed.crossings.size(); ++i) {
    // Pairs of triangle 0 come first: with every third triangle after it.
    const auto a = static_cast<Index>(i / (with_area - 1)), k = static_cast<Index>(i);
    if (a > 0) break;
    EXPECT_EQ(oracle::key(crossed.crossings[i]), oracle::key(TriangleCrossing{0, 0, 0, 3 * (k + 1)}));
  }
  EXPECT_LT(crossed.work.leaf_pairs, 10u);
  EXPECT_EQ(crossed.explanation.objects[0].reason.size(), corners - 2);
  const StepResult moved = step(scene, settings);
  EXPECT_TRUE(moved.clean());
  EXPECT_LT(moved.work.leaf_pairs, 10u);
}

TEST(Copies, CopiesOfAPointDoNotCross) {
  Scene scene;
  scene.topologies.push_back(*Topology::make(1, std::vector<Triangle>(200'000, Triangle{0, 0, 0})));
  scene.x0 = scene.x1 = {{1, 2, 3}};
  const StaticResult crossed = pose(scene, {});
  EXPECT_TRUE(crossed.clean());
  EXPECT_LT(crossed.work.leaf_pairs, 10u);
}

// Two triangles and an unused vertex.
struct WithUnusedVertex {
  Topology topology = *Topology::make(7, {{0, 1, 2}, {3, 4, 5}});
  std::vector<double> x{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 0, 1, 0, 1, 1, 5, 5, 5};
};

constexpr double kNotFinite[] = {std::numeric_limits<double>::quiet_NaN(),
                                 std::numeric_limits<double>::infinity(),
                                 -std::numeric_limits<double>::infinity()};

TEST(Unused, AVertexThatIsNotFiniteIsAnError) {
  const WithUnusedVertex mesh;
  auto hierarchy = std::make_shared<const Hierarchy>(*Hierarchy::build(mesh.topology, mesh.x));
  StepChecker checker({hierarchy});
  StepResult step;
  StaticResult pose;
  for (const double bad : kNotFinite) {
    for (const int axis : {0, 1, 2}) {
      std::vector<double> invalid = mesh.x;
      invalid[18 + axis] = bad;
      EXPECT_FALSE(Hierarchy::build(mesh.topology, invalid));
      const std::span<const double> good[] = {mesh.x}, with_bad[] = {invalid};
      const auto at_start = checker.check(with_bad, good, {}, step),
                 at_end = checker.check(good, with_bad, {}, step);
      ASSERT_FALSE(at_start);
      EXPECT_EQ(at_start.error().line(),
                "object 0, vertex 6: has a coordinate in x0 that is not finite; repair the positions");
      ASSERT_FALSE(at_end);
      EXPECT_EQ(at_end.error().line(),
                "object 0, vertex 6: has a coordinate in x1 that is not finite; repair the positions");
      EXPECT_FALSE(checker.check_static(with_bad, {}, pose));
      EXPECT_TRUE(checker.check(good, good, {}, step));
    }
  }
}

TEST(Magnitude, ADisplacementThatOverflowsIsRefused) {
  // Vertex 6 is in no triangle.
  const auto topology = *Topology::make(7, {{0, 1, 2}, {3, 4, 5}});
  const std::vector<double> x{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 0, 1, 0, 1, 1, 5, 5, 5};
  StepChecker checker({std::make_shared<const Hierarchy>(*Hierarchy::build(topology, x))});
  for (const std::size_t vertex : {1, 4, 6}) {
    auto from = x, to = x;
    from[3 * vertex + 1] = -1e308;
    to[3 * vertex + 1] = 7e307;
    const std::span<const double> x0[] = {from}, x1[] = {to};
    StepResult result;
    EXPECT_TRUE(checker.check(x0, x1, {}, result));
    to[3 * vertex + 1] = 1e308;
    const auto refused = checker.check(x0, x1, {}, result);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().line(),
              fmt::format("object 0, vertex {}: moves so far from x0 to x1 that the difference overflows; "
                          "scale the positions down",
                          vertex));
  }
}

// Two triangles one above the other; the upper one moves through the lower.
TEST(Magnitude, AnswersHoldAtTheEndsOfTheRange) {
  const auto topology = *Topology::make(6, {{0, 1, 2}, {3, 4, 5}});
  constexpr double max = std::numeric_limits<double>::max();
  for (const double size : {8e307, 1.7e308, max, 0x1p990, 0x1p1000, 1.0, 0x1p-990, 0x1p-1000}) {
    SCOPED_TRACE(size);
    const auto above = [&](double z) {
      return std::vector<double>{-size,     -size,     0, size,     -size,     0, -size,     size,     0,
                                 -size / 2, -size / 2, z, size / 4, -size / 2, z, -size / 2, size / 4, z};
    };
    const auto far = above(0.75 * size), near = above(0.25 * size), below = above(-0.25 * size);
    StepChecker checker({std::make_shared<const Hierarchy>(*Hierarchy::build(topology, far))});
    const std::span<const double> at_far[] = {far}, at_near[] = {near}, at_below[] = {below};
    StepResult result;
    ASSERT_TRUE(checker.check(at_far, at_near, {}, result));
    EXPECT_TRUE(result.clean());
    EXPECT_TRUE(std::isfinite(result.tolerance));
    EXPECT_LT(result.tolerance, 1e-6 * size);
    ASSERT_TRUE(checker.check(at_near, at_below, {}, result));
    EXPECT_EQ(result.vertex_face_count, 3u);
    EXPECT_EQ(result.work.undecided, 0u);
    EXPECT_NEAR(result.earliest_toi, 0.5, 1e-6);
    StaticResult pose;
    ASSERT_TRUE(checker.check_static(at_near, {}, pose));
    EXPECT_TRUE(pose.clean());
  }
}

TEST(Magnitude, SmallAndLargeObjectsTogether) {
  const auto small = *Topology::make(6, {{0, 1, 2}, {3, 4, 5}}), large = *Topology::make(3, {{0, 1, 2}});
  const double s = 0x1p-990, l = 8e307;
  const std::vector<double> tiny{0, 0, 0, s, 0, 0, 0, s, 0, 0, 0, s, s, 0, s, 0, s, s};
  const std::vector<double> far{l / 2, -l, -l, l / 2, l, -l, l / 2, 0, l};
  StepChecker checker({std::make_shared<const Hierarchy>(*Hierarchy::build(small, tiny)),
                       std::make_shared<const Hierarchy>(*Hierarchy::build(large, far))});
  const std::span<const double> x[] = {tiny, far};
  StepSettings between;
  between.within = false;
  StepResult result;
  ASSERT_TRUE(checker.check(x, x, between, result));
  EXPECT_TRUE(result.clean());
  // Exactly, whatever the sizes.
  StaticResult pose;
  ASSERT_TRUE(checker.check_static(x, {}, pose));
  EXPECT_TRUE(pose.clean());
}

TEST(StepChecker, RefusesToTestNothing) {
  StepChecker checker({});
  StepSettings nothing;
  nothing.within = nothing.between = false;
  StepResult step;
  StaticResult pose;
  for (const Result<void>& answer :
       {checker.check({}, {}, nothing, step), checker.check_static({}, nothing, pose)}) {
    ASSERT_FALSE(answer);
    EXPECT_EQ(answer.error().where, "within and between");
  }
}

TEST(StepChecker, NoObjectsHaveNoCollisions) {
  StepChecker checker({});
  StepResult step;
  step.search_steps = 0;  // as from an earlier step
  step.tolerance = 7;
  StaticResult found;
  for (int k = 0; k < 3; ++k) {
    ASSERT_TRUE(checker.check({}, {}, {}, step));
    EXPECT_TRUE(step.clean());
    EXPECT_EQ(step.search_steps, 1);
    EXPECT_LT(step.tolerance, 1e-300);
    ASSERT_TRUE(checker.check_static({}, {}, found));
    EXPECT_TRUE(found.clean());
  }
}

}  // namespace
}  // namespace foldproof
