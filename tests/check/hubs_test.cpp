// Around a vertex with many triangles planes separate nodes (docs/soundness.md, B3h): answers stay those of
// brute force, and the work grows with the mesh, not with its square.
#include "check/hubs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <set>

#include "check/same_collisions.h"
#include "foldproof/check.h"
#include "oracle/brute_force.h"
#include "oracle/meshes.h"

namespace foldproof {
namespace {

using oracle::Rng;
using oracle::uniform;
using testing::expect_same_collisions;

constexpr double kTurn = 2 * std::numbers::pi;

/// Triangles, and where their vertices are at the start.
struct Shape {
  std::vector<Triangle> triangles;
  std::vector<double> x;
  void add(double a, double b, double c) { x.insert(x.end(), {a, b, c}); }
  void add_on_circle(double turns, double height) {
    add(std::cos(kTurn * turns), std::sin(kTurn * turns), height);
  }
  Index vertex_count() const { return static_cast<Index>(x.size() / 3); }
};

/// `share` of a whole fan.
Shape fan(Index size, double height, double share = 1) {
  Shape shape;
  shape.add(0, 0, 0);
  const Index rim = share < 1 ? size + 1 : size;
  for (Index i = 0; i < rim; ++i) shape.add_on_circle(share * i / size, height);
  for (Index i = 0; i < size; ++i) shape.triangles.push_back({0, 1 + i, 1 + (i + 1) % rim});
  return shape;
}

Shape polygon(Index size) {
  Shape shape;
  for (Index i = 0; i < size; ++i) {
    shape.add_on_circle(static_cast<double>(i) / size, 0);
    double* p = &shape.x[3 * std::size_t{i}];
    p[2] = 0.3 * p[0] + 0.11 * p[1];
  }
  for (Index i = 2; i < size; ++i) shape.triangles.push_back({0, i - 1, i});
  return shape;
}

Shape book(Index size, Rng& rng, bool shuffled) {
  Shape shape;
  shape.add(0, 0, -1);
  shape.add(0, 0, 1);
  std::vector<Index> order(size);
  std::iota(order.begin(), order.end(), Index{0});
  if (shuffled) std::shuffle(order.begin(), order.end(), rng);
  for (Index i = 0; i < size; ++i) shape.add_on_circle(0.9 * i / size, 0);
  for (const Index page : order) shape.triangles.push_back({0, 1, 2 + page});
  return shape;
}

/// Triangles around a vertex in all directions, some of which cross; and some that have the same vertices.
Shape burr(Index size, Rng& rng) {
  Shape shape;
  shape.add(0, 0, 0);
  for (Index i = 0; i < size; ++i) {
    const auto coordinate = [&] { return uniform(rng, -1, 1); };
    const Vec3 out = Vec3(coordinate(), coordinate(), coordinate()).normalized();
    for (int end = 0; end < 2; ++end) {
      const Vec3 p = out + 0.05 * Vec3(coordinate(), coordinate(), coordinate());
      shape.add(p.x(), p.y(), p.z());
    }
    shape.triangles.push_back({0, 1 + 2 * i, 2 + 2 * i});
    if (i % 10 == 0) shape.triangles.push_back({2 + 2 * i, 1 + 2 * i, 0});
  }
  return shape;
}

/// Two fans back to back: each leaf of the middle has both hubs.
Shape spindle(Index size) {
  Shape shape = fan(size, 0.5);
  shape.add(0, 0, 1);
  for (Index i = 0; i < size; ++i) shape.triangles.push_back({size + 1, 1 + i, 1 + (i + 1) % size});
  return shape;
}

oracle::Scene scene_of(const Shape& shape, double motion, double grid, Rng& rng) {
  oracle::Scene scene;
  scene.topologies.push_back(*Topology::make(shape.vertex_count(), shape.triangles));
  scene.x0.push_back(oracle::deformed(shape.x, 0.02, grid, rng));
  scene.x1.push_back(oracle::deformed(scene.x0.back(), motion, grid, rng));
  return scene;
}

std::vector<Shape> shapes(Rng& rng) {
  return {fan(130, 0.5),        fan(130, 0, 0.9), polygon(130), book(130, rng, false),
          book(130, rng, true), burr(130, rng),   spindle(130)};
}

TEST(Hubs, NodesKnowTheirHubsAndVertices) {
  Rng rng(31);
  for (const Shape& shape : shapes(rng)) {
    const Hierarchy tree = *Hierarchy::build(*Topology::make(shape.vertex_count(), shape.triangles), shape.x);
    const Hubs hubs(tree);
    std::vector<Index> triangles(tree.vertex_ids().size());
    for (const Triangle& t : tree.triangles())
      for (const Index v : t) ++triangles[v];
    std::vector<std::set<Index>> vertices, common;
    for (const Hierarchy::Node& node : tree.nodes()) {
      auto& all = vertices.emplace_back();
      auto& of_all = common.emplace_back();
      for (Index v = 0; v < triangles.size(); ++v)
        if (triangles[v] >= Hubs::kMinTriangles) of_all.insert(v);
      for (Index leaf = node.leaf_begin; leaf < node.leaf_end; ++leaf) {
        std::set<Index> of_leaf;
        for (Index t = tree.leaves()[leaf].triangles; t < tree.leaves()[leaf + 1].triangles; ++t)
          of_leaf.insert(tree.triangles()[t].begin(), tree.triangles()[t].end());
        std::erase_if(of_all, [&](Index v) { return !of_leaf.contains(v); });
        all.merge(of_leaf);
      }
    }
    std::size_t with_hub = 0;
    for (NodeIndex a; a < common.size(); a = NodeIndex(a + 1)) {
      EXPECT_EQ(hubs.is_around_hub(a), !common[a].empty()) << "node " << a;
      if (common[a].empty()) continue;
      ++with_hub;
      std::vector<Index> listed{kNoIndex};
      hubs.list_vertices(a, listed);
      EXPECT_TRUE(std::ranges::equal(listed, vertices[a])) << "node " << a;
    }
    EXPECT_GT(with_hub, 10u);
  }
}

TEST(Hubs, AnswersEqualBruteForce) {
  struct Movement {
    double motion, grid, thickness;
  };
  Rng rng(32);
  std::uint64_t crossings = 0, collisions = 0;
  const std::vector<Shape> all = shapes(rng);
  const auto takes_pose = [&](const Shape& shape) { return &shape == &all[4] || &shape == &all[5]; };
  for (const Shape& shape : all) {
    for (const auto& [motion, grid, thickness] :
         {Movement{0.01, 0, 0.01}, Movement{0.2, 0, 0}, Movement{0.2, 1.0 / 8, 0}}) {
      const oracle::Scene scene = scene_of(shape, motion, grid, rng);
      const auto x0 = scene.spans0(), x1 = scene.spans1();
      StepChecker checker(scene.hierarchies(4));
      StepSettings settings;
      settings.thickness = thickness;
      StepResult step;
      ASSERT_TRUE(checker.check(x0, x1, settings, step));
      const StepResult expected = oracle::brute_force_step(scene, settings, step.tolerance);
      ASSERT_NO_FATAL_FAILURE(expect_same_collisions(step, expected));
      collisions += step.edge_edge_count + step.vertex_face_count;
      // Exact arithmetic on all pairs takes a second per pose: of one with a hub and of one with two.
      if (grid == 0 || !takes_pose(shape)) continue;
      StaticResult pose;
      ASSERT_TRUE(checker.check_static(x0, {}, pose));
      EXPECT_TRUE(oracle::same_crossings(pose, oracle::brute_force_static(scene, {})));
      crossings += pose.crossing_count;
    }
  }
  EXPECT_GT(crossings, 150u);
  EXPECT_GT(collisions, 1000u);
}

TEST(Hubs, AnExplanationCountsAllPairsAroundThem) {
  const Shape shape = fan(5000, 0.5);
  const auto hierarchy = std::make_shared<const Hierarchy>(
      *Hierarchy::build(*Topology::make(shape.vertex_count(), shape.triangles), shape.x));
  StepChecker checker({hierarchy});
  StepSettings settings;
  settings.explain = true;
  StaticResult pose;
  ASSERT_TRUE(checker.check_static(shape.x, settings, pose));
  const ReasonCounts& pairs = pose.explanation.leaf_pairs;
  const std::uint64_t leaves = hierarchy->leaf_count();
  EXPECT_EQ(std::accumulate(pairs.begin(), pairs.end(), std::uint64_t{0}), leaves * (leaves + 1) / 2);
  EXPECT_GT(pairs[static_cast<std::size_t>(Reason::Certified)], leaves * leaves / 4);
}

// A step in which every fourth page sweeps through all others leaves nothing that later steps pay for.
TEST(Hubs, AStepInWhichPlanesFailCostsTheNextOnesNothing) {
  Rng rng(34);
  const Shape shape = book(1000, rng, false);
  const auto hierarchy = std::make_shared<const Hierarchy>(
      *Hierarchy::build(*Topology::make(shape.vertex_count(), shape.triangles), shape.x));
  std::vector<double> folded = shape.x;
  for (std::size_t v = 2; v < folded.size() / 3; v += 4) {
    for (const std::size_t k : {3 * v, 3 * v + 1}) folded[k] = -folded[k];
  }
  StepSettings settings;
  settings.look_ahead = false;
  StepChecker calm({hierarchy}), checker({hierarchy});
  StepResult usual, bad, later;
  for (int step = 0; step < 4; ++step) {
    ASSERT_TRUE(calm.check(shape.x, shape.x, settings, usual));
    StepResult& result = step == 2 ? bad : later;
    ASSERT_TRUE(checker.check(shape.x, step == 2 ? folded : shape.x, settings, result));
  }
  EXPECT_GT(bad.work.leaf_pairs, 10 * usual.work.leaf_pairs);
  EXPECT_EQ(later.work.leaf_pairs, usual.work.leaf_pairs);
}

Work work_of(const Shape& shape, bool moves) {
  std::vector<double> x1 = shape.x;
  for (double& coordinate : x1) coordinate *= 1.1;
  StepChecker checker({std::make_shared<const Hierarchy>(
      *Hierarchy::build(*Topology::make(shape.vertex_count(), shape.triangles), shape.x))});
  StaticResult pose;
  StepResult step;
  const bool done =
      (moves ? checker.check(shape.x, x1, {}, step) : checker.check_static(shape.x, {}, pose)).has_value();
  EXPECT_TRUE(done && (moves ? step.clean() : pose.clean()));
  return moves ? step.work : pose.work;
}

TEST(Hubs, TheWorkGrowsWithTheMesh) {
  Rng rng(33);
  const auto make = [&](Index size) {
    return std::vector<Shape>{fan(size, 0.5), fan(size, 0, 0.9),      fan(size, 0),         polygon(size),
                              spindle(size),  book(size, rng, false), book(size, rng, true)};
  };
  constexpr Index kSize = 1500;
  const std::vector<Shape> small = make(kSize), large = make(2 * kSize);
  for (std::size_t i = 0; i < small.size(); ++i) {
    for (const bool moves : {false, true}) {
      const Work a = work_of(small[i], moves), b = work_of(large[i], moves);
      const auto pairs = [](const Work& work) {
        return static_cast<double>(work.node_tests + work.certificate_tests + work.leaf_pairs);
      };
      EXPECT_LT(pairs(b), 2.5 * pairs(a)) << "shape " << i << (moves ? ", moving" : "");
      EXPECT_LT(b.candidates_vf + b.candidates_ee, 16 * large[i].triangles.size()) << "shape " << i;
    }
  }
}

}  // namespace
}  // namespace foldproof
