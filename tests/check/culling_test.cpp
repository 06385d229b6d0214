// Culling removes pairs of leaves that certificates prove separated, and none that comes within the gap.
#include "check/culling.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "bvh/meshes.h"
#include "check/stages.h"

namespace foldproof::oracle {
namespace {

// Calls culling as the broad phase does, on all pairs of leaves whose boxes are near each other.
class Stage {
 public:
  explicit Stage(std::vector<Object> all, Filter filter = {})
      : objects(std::move(all)), culling(objects), motion_(objects), filter_(filter) {}
  Stage(const Scene& scene, Index leaf_triangles, Filter filter = {})
      : Stage(scene.hierarchies(leaf_triangles), filter) {}

  struct Found {
    std::set<Leaves> near, remaining;
    struct SelfPairs {
      std::vector<std::uint8_t> proven;  // per node
      std::vector<LeafIndex> unproven_leaves;
    };
    std::vector<SelfPairs> self_pairs;  // per object
    Work work;
  };
  Found cull(const Scene& scene, const StepSettings& settings, double distance) {
    Found found;
    found.near = near_leaves(scene, objects, settings, distance);
    const auto x0 = scene.spans0(), x1 = scene.spans1();
    EXPECT_TRUE(motion_.update(x0, x1));
    EXPECT_TRUE(culling.begin_step(motion_, settings, distance));
    const float margin = separation_margin(motion_.frame(), distance);
    culling.prove_nodes(motion_, filter_, found.work);
    std::size_t remaining = 0;
    for (Index a = 0; a < objects.size(); ++a) {
      const auto proven = culling.proven(a);
      auto& self = found.self_pairs.emplace_back();
      self.proven.assign(proven.begin(), proven.end());
      for (Index k = 0; k < motion_.subtrees(a).roots.size(); ++k) {
        for (const LeafIndex leaf : culling.unproven_leaves(a, k)) self.unproven_leaves.push_back(leaf);
      }
      for (Index b = a; b < objects.size(); ++b) {
        const TraversalTask task{{&motion_.bvhs()[a], &motion_.bvhs()[b], margin}, a, b};
        Tile& tile = tiles_.try_emplace({a, b}, Tile::Key{a, b, {}, {}}).first->second;
        tile.begin_step();
        culling.cull_leaves(task, pairs_of(found.near, a, b), true, tile);
        culling.request_charts(tile);
        if (a == b) {
          for (const LeafIndex leaf : self.unproven_leaves) tile.remaining.push_back({leaf, leaf});
        }
        for (const LeafPair leaves : tile.remaining)
          EXPECT_TRUE(found.remaining.insert(leaves_of(task, leaves)).second) << "twice";
        remaining += tile.remaining.size();
      }
    }
    culling.end_step(motion_, 0, remaining, found.work);
    return found;
  }

  std::vector<Object> objects;
  Culling culling;

 private:
  // Those of two objects, but no leaf with itself.
  std::vector<NearLeafPair> pairs_of(const std::set<Leaves>& near, Index object_a, Index object_b) const {
    std::vector<NearLeafPair> pairs;
    for (const auto& [a, b] : near) {
      if (a[0] != object_a || b[0] != object_b || a == b) continue;
      const Index slot = object_a == object_b ? culling.slots(object_a).of_leaves(a[1], b[1]) : kNoIndex;
      pairs.push_back({{LeafIndex(a[1]), LeafIndex(b[1])}, SlotIndex(slot)});
    }
    return pairs;
  }

  StepMotion motion_;
  Filter filter_;
  std::map<std::pair<Index, Index>, Tile> tiles_;
};

// Uses certificates also where they do not pay, and from the first step on.
StepSettings always() {
  StepSettings settings;
  settings.explain = true;
  return settings;
}

bool is_subset(const std::set<Leaves>& part, const std::set<Leaves>& whole) {
  return std::ranges::includes(whole, part);
}

// ---- Never too much.

constexpr Index kCells = 24;

// A strip that is rolled up by an angle: from about 2 pi on it meets itself.
std::vector<double> rolled_strip(double angle) {
  return strip(kCells, [&](double u) {
    const double radius = (1 + 0.06 * std::sin(3 * angle * u)) / angle;
    return std::array{radius * std::sin(angle * u), radius * std::cos(angle * u)};
  });
}

// A sheet across the strip, which goes up and down.
std::vector<double> sheet_at(double height) {
  std::vector<double> x = testing::cloth(3).positions;
  for (std::size_t i = 0; i < x.size(); i += 3) {
    x[i] -= 0.5;
    x[i + 2] = height + 0.1 * x[i] + 0.03 * x[i + 1];
  }
  return x;
}

Scene rolling(int step) {
  const auto angle = [](int k) { return 1 + 7 * std::pow(std::sin(0.08 * k), 2); };
  const auto height = [](int k) { return 0.7 * std::cos(0.11 * k); };
  Scene scene;
  add_object(scene, strip_topology(kCells), rolled_strip(angle(step)), rolled_strip(angle(step + 1)));
  add_object(scene, testing::cloth(3).topology, sheet_at(height(step)), sheet_at(height(step + 1)));
  return scene;
}

TEST(Culling, RemovesNoPairThatComesWithinTheGap) {
  constexpr double kTolerance = 1e-5;
  for (const double thickness : {0.0, 0.03}) {
    StepSettings settings = always();
    settings.thickness = thickness;
    Stage stage(rolling(0), 2);
    std::size_t touching = 0, removed = 0;
    for (int step = 0; step < 60; ++step) {
      const Scene scene = rolling(step);
      const Stage::Found found = stage.cull(scene, settings, thickness + kTolerance);
      const auto together = touching_leaves(scene, stage.objects, settings, kTolerance);
      ASSERT_TRUE(is_subset(together, found.remaining)) << "step " << step << ", thickness " << thickness;
      ASSERT_TRUE(is_subset(found.remaining, found.near)) << "step " << step;
      touching += together.size();
      removed += found.near.size() - found.remaining.size();
    }
    EXPECT_GT(touching, 100u);
    EXPECT_GT(removed, 1000u);
  }
}

// Every leaf is below one proven node, or is passed on.
TEST(Culling, SelfPairsCoverEachLeafOnce) {
  Stage stage(rolling(0), 2);
  std::size_t proven = 0, unproven = 0;
  for (int step = 0; step < 40; ++step) {
    const Stage::Found found = stage.cull(rolling(step), always(), 0);
    for (Index object = 0; object < 2; ++object) {
      const Hierarchy& hierarchy = *stage.objects[object].hierarchy();
      const auto& [is_proven, unproven_leaves] = found.self_pairs[object];
      std::vector<int> covered(hierarchy.leaf_count(), 0);
      for (const Index leaf : unproven_leaves) ++covered[leaf];
      unproven += unproven_leaves.size();
      for (Index node = 0; node < hierarchy.nodes().size();) {
        const Hierarchy::Node& n = hierarchy.nodes()[node];
        if (is_proven[node]) {
          for (Index leaf = n.leaf_begin; leaf < n.leaf_end; ++leaf) ++covered[leaf];
          proven += n.leaf_end - n.leaf_begin;
        }
        node += is_proven[node] ? 2 * (n.leaf_end - n.leaf_begin) - 1 : 1;  // past everything below it
      }
      ASSERT_EQ(covered, std::vector<int>(covered.size(), 1)) << "step " << step;
    }
  }
  EXPECT_GT(proven, 100u);
  EXPECT_GT(unproven, 50u);
}

// ---- What certificates prove.

// A sheet in the plane, each half of which may be turned up about the middle line; at 0.5 both halves lie on
// each other.
std::vector<double> hinged(double half_turns) {
  std::vector<double> x = testing::cloth(6).positions;
  const double angle = half_turns * std::numbers::pi;
  for (std::size_t i = 0; i < x.size(); i += 3) {
    const double across = x[i] - 0.5;
    x[i] = across * std::cos(angle);
    x[i + 2] = std::abs(across) * std::sin(angle);
  }
  return x;
}

Scene hinged_sheet(double from, double to) {
  Scene scene;
  add_object(scene, testing::cloth(6).topology, hinged(from), hinged(to));
  return scene;
}

// A chart of the whole sheet. Its proof is for one step: the sheet is then folded until its halves touch.
TEST(Culling, AChartProvesASheetUntilItIsFolded) {
  Stage stage(hinged_sheet(0, 0), 4);
  Stage::Found found = stage.cull(hinged_sheet(0, 0), always(), 1e-6);
  EXPECT_EQ(found.remaining, found.near) << "no chart has been made";
  for (int step = 0; step < 3; ++step) found = stage.cull(hinged_sheet(0, 0.01), always(), 1e-6);
  EXPECT_EQ(found.remaining, std::set<Leaves>());
  EXPECT_TRUE(found.self_pairs[0].proven[0]);
  EXPECT_GT(found.work.certificate_passes, 0u);
  const Scene fold = hinged_sheet(0.01, 0.5);
  found = stage.cull(fold, always(), 1e-6);
  const auto touching = touching_leaves(fold, stage.objects, always(), 1e-6);
  EXPECT_GT(touching.size(), 5u);
  EXPECT_TRUE(is_subset(touching, found.remaining));
}

// A strip of four cells that is closed to a ring, with an edge above and one below; at height 0 it lies flat
// on itself.
Scene square_ring(double height_from, double height_to) {
  const Topology open = strip_topology(4);
  std::vector<Triangle> triangles(open.triangles().begin(), open.triangles().end());
  for (Triangle& t : triangles) {
    for (Index& v : t) v %= 8;
  }
  const auto at = [](double height) {
    return std::vector<double>{0, 0, height,  0, 1, height,  1,  0, 0, 1,  1, 0,
                               0, 0, -height, 0, 1, -height, -1, 0, 0, -1, 1, 0};
  };
  Scene scene;
  add_object(scene, Topology::make(8, triangles).value(), at(height_from), at(height_to));
  return scene;
}

// A closed surface has no chart as a whole. Of a square ring, whose sides are the leaves, those of two nodes
// have one; the other neighbors, which fold onto each other in the end, have only that of the two.
TEST(Culling, ChartsOfNeighborsProveAClosedSurface) {
  const Scene open = square_ring(1, 1), flat = square_ring(1, 0);
  const std::vector<Index> leaf_sizes{0, 0, 2, 2, 0, 2, 2};
  Stage stage({Hierarchy::from_parts(open.topologies[0], {2, 3, 4, 5, 6, 7, 0, 1}, leaf_sizes).value()});
  Stage::Found found = stage.cull(open, always(), 1e-6);
  EXPECT_EQ(found.remaining, found.near);
  for (int step = 0; step < 20; ++step) found = stage.cull(open, always(), 1e-6);
  EXPECT_FALSE(found.self_pairs[0].proven[0]);
  EXPECT_EQ(found.remaining, std::set<Leaves>());
  found = stage.cull(flat, always(), 1e-6);
  const auto touching = touching_leaves(flat, stage.objects, always(), 1e-6);
  EXPECT_GT(touching.size(), 3u);
  EXPECT_TRUE(is_subset(touching, found.remaining));
}

// Two parallel triangles in planes across all axes, `apart` from each other.
Scene oblique_triangles(double from, double to) {
  const Topology triangle = Topology::make(3, {{0, 1, 2}}).value();
  const auto at = [](double apart) {
    std::vector<double> x{0, 0, 0, 2, 0, 2, 0, 2, 2};
    for (std::size_t i = 0; i < 9; ++i) x[i] += (i % 3 == 2 ? 1 : -1) * apart / std::sqrt(3.0);
    return x;
  };
  Scene scene;
  add_object(scene, triangle, at(0), at(0));
  add_object(scene, triangle, at(from), at(to));
  return scene;
}

// Planes are tried now and then. Where one separates, it is remembered and tested in each step.
TEST(Culling, APlaneSeparatesTwoObjectsUntilTheyMeet) {
  const Leaves both = leaves_of(0, 0, 1, 0);
  // Far away others cross, so that new planes are not worth a test.
  const auto with_others = [](double from, double to) {
    Scene scene = oblique_triangles(from, to);
    for (int k = 0; k < 8; ++k) {
      for (const double z : {0.0, 0.3}) {
        std::vector<double> x{0, 0, 1, 1, 0, z, 0, 1, 1 - z};
        for (std::size_t i = 0; i < 9; i += 3) x[i] += 10.0 + 4 * k;
        add_object(scene, scene.topologies[0], x, x);
      }
    }
    return scene;
  };
  const Scene apart = with_others(0.3, 0.3), through = with_others(0.3, -0.3);
  Stage stage(apart, 1);
  EXPECT_TRUE(stage.cull(apart, always(), 0.1).near.contains(both));
  const auto steps_until_removed = [&] {
    int steps = 1;
    while (steps < 20 && stage.cull(apart, always(), 0.1).remaining.contains(both)) ++steps;
    return steps;
  };
  EXPECT_LT(steps_until_removed(), 10);
  for (int step = 0; step < 16; ++step) {
    const Stage::Found found = stage.cull(apart, always(), 0.1);
    EXPECT_FALSE(found.remaining.contains(both)) << step;
  }
  EXPECT_TRUE(stage.cull(through, always(), 0.1).remaining.contains(both));
  EXPECT_LT(steps_until_removed(), 10) << "it does not try again";
}

// The planes are 0.3 apart.
TEST(Culling, APlaneMustProveTheWholeGap) {
  const Leaves both = leaves_of(0, 0, 1, 0);
  const Scene scene = oblique_triangles(0.3, 0.3);
  for (const double distance : {0.29, 0.301}) {
    Stage stage(scene, 1);
    bool removed = false;
    for (int step = 0; step < 20; ++step)
      removed = removed || !stage.cull(scene, always(), distance).remaining.contains(both);
    EXPECT_EQ(removed, distance < 0.3) << distance;
  }
}

// ---- Without certificates.

TEST(Culling, WithoutCertificatesEverythingRemains) {
  Stage stage(hinged_sheet(0, 0), 4);
  StepSettings settings;
  settings.certificates = false;
  for (int step = 0; step < 5; ++step) {
    const Stage::Found found = stage.cull(hinged_sheet(0, 0), settings, 1e-6);
    EXPECT_EQ(found.remaining, found.near);
    EXPECT_FALSE(stage.culling.keeps_fronts());
  }
}

// A single step should not pay for certificates of later ones.
TEST(Culling, ANewCheckersFirstStepUsesNone) {
  Stage stage(hinged_sheet(0, 0), 4);
  const Stage::Found found = stage.cull(hinged_sheet(0, 0.01), {}, 1e-6);
  EXPECT_EQ(found.work.certificate_tests, 0u);
  EXPECT_EQ(found.remaining, found.near);
}

// In a pose they pay at once.
TEST(Culling, ANewCheckersFirstPoseBuildsItsCharts) {
  Stage stage(hinged_sheet(0, 0), 4);
  const Stage::Found found = stage.cull(hinged_sheet(0, 0), {}, 1e-6);
  EXPECT_GT(found.near.size(), 4u);
  EXPECT_TRUE(found.remaining.empty());
}

TEST(Culling, TestsBoxesWhereTheTraversalDidNot) {
  Scene scene = oblique_triangles(5, 5);
  const std::vector<Object> objects = scene.hierarchies(1);
  StepMotion motion(objects);
  Culling culling(objects);
  const auto x0 = scene.spans0(), x1 = scene.spans1();
  ASSERT_TRUE(motion.update(x0, x1));
  StepSettings settings;
  settings.certificates = false;
  ASSERT_TRUE(culling.begin_step(motion, settings, 0.1));
  const float margin = separation_margin(motion.frame(), 0.1);
  const TraversalTask task{{&motion.bvhs()[0], &motion.bvhs()[1], margin}, 0, 1};
  const NearLeafPair pair{{}, SlotIndex(kNoIndex)};
  Tile tested({0, 1, {}, {}}), trusted({0, 1, {}, {}});
  culling.cull_leaves(task, {&pair, 1}, false, tested);
  EXPECT_TRUE(tested.remaining.empty());
  EXPECT_EQ(tested.node_tests, 1u);
  culling.cull_leaves(task, {&pair, 1}, true, trusted);
  EXPECT_EQ(trusted.remaining.size(), 1u);
  EXPECT_EQ(trusted.node_tests, 0u);
}

// ---- Filters and modes.

// Ignores the pairs of each node in the left half of the hierarchy.
struct LeftHalf final : PairFilter {
  std::shared_ptr<const Hierarchy> hierarchy;
  bool is_left(Index node) const { return node > 0 && node < hierarchy->nodes()[0].right; }
  bool nodes(Index, Index node_a, Index, Index node_b) const override {
    return !is_left(node_a) && !is_left(node_b);
  }
  bool vertex_face(Index, Index, Index, Index) const override { return true; }
  bool edge_edge(Index, const Edge&, Index, const Edge&) const override { return true; }
  bool crossing(Index, Index, Index, Index) const override { return true; }
};

TEST(Culling, IgnoredNodesAreAsGoodAsProven) {
  const Scene scene = hinged_sheet(0, 0);
  LeftHalf ignores_left;
  Stage stage(scene, 4, Filter{&ignores_left, {}, true});
  ignores_left.hierarchy = stage.objects[0].hierarchy();
  const auto nodes = ignores_left.hierarchy->nodes();
  StepSettings settings;
  settings.certificates = false;
  const Stage::Found found = stage.cull(scene, settings, 0);
  EXPECT_FALSE(found.self_pairs[0].proven[0]);
  EXPECT_TRUE(found.self_pairs[0].proven[1]);
  EXPECT_FALSE(found.self_pairs[0].proven[nodes[0].right]);
  std::vector<LeafIndex> leaves = found.self_pairs[0].unproven_leaves, right;
  for (Index leaf = nodes[1].leaf_end; leaf < ignores_left.hierarchy->leaf_count(); ++leaf)
    right.emplace_back(leaf);
  std::ranges::sort(leaves);
  EXPECT_EQ(leaves, right);
}

TEST(Culling, WhatIsDeclaredIsOfEachNode) {
  const Scene scene = hinged_sheet(0, 0);
  const std::vector<Object> objects = scene.hierarchies(4);
  StepMotion motion(objects);
  Culling culling(objects);
  const auto x = scene.spans0();
  ASSERT_TRUE(motion.update(x, x));
  StepSettings settings;
  std::vector<std::vector<std::uint8_t>> free;
  settings.declared_free = &free;
  const auto begun = culling.begin_step(motion, settings, 0);
  ASSERT_FALSE(begun);
  EXPECT_EQ(begun.error().where, "declared_free, object 0");
  free.emplace_back(objects[0].hierarchy()->nodes().size());
  EXPECT_TRUE(culling.begin_step(motion, settings, 0));
}

}  // namespace
}  // namespace foldproof::oracle
