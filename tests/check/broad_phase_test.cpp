// The broad phase finds every pair of leaves whose moving boxes come near each other, and none twice.
#include "check/broad_phase.h"

#include <gtest/gtest.h>

#include <string>

#include "base/callers.h"
#include "bvh/meshes.h"
#include "check/stages.h"

namespace foldproof::oracle {
namespace {

// The broad phase with the stages that it calls.
struct Stage {
  Stage(const Scene& scene, Index leaf_triangles, Filter pair_filter = {})
      : objects(scene.hierarchies(leaf_triangles)), filter(pair_filter), motion(objects), culling(objects) {}

  void find(const Scene& scene, const StepSettings& settings, double distance) {
    const auto x0 = scene.spans0(), x1 = scene.spans1();
    ASSERT_TRUE(motion.update(x0, x1));
    ASSERT_TRUE(culling.begin_step(motion, settings, distance));
    broad_phase.find(motion, culling, filter, settings, distance, work);
  }

  // As they come.
  std::vector<Leaves> found() const {
    std::vector<Leaves> all;
    for (const TaskLeaves& pair : broad_phase.leaf_pairs())
      all.push_back(leaves_of(broad_phase.tasks()[pair.task], pair.leaves));
    return all;
  }
  std::vector<Leaves> sorted() const {
    std::vector<Leaves> all = found();
    std::ranges::sort(all);
    return all;
  }

  std::vector<Object> objects;
  Filter filter;
  StepMotion motion;
  Culling culling;
  BroadPhase broad_phase;
  Work work;
};

std::vector<Leaves> list(const std::set<Leaves>& all) { return {all.begin(), all.end()}; }

// In scenes that leave no doubt about any pair, whatever is rounded.
std::set<Leaves> clearly_near(const Scene& scene, std::span<const Object> objects,
                              const StepSettings& settings, double distance) {
  std::set<Leaves> near = near_leaves(scene, objects, settings, distance);
  EXPECT_EQ(near, near_leaves(scene, objects, settings, distance + 1e-4)) << "change the scene";
  return near;
}

StepSettings without_certificates() {
  StepSettings settings;
  settings.certificates = false;
  return settings;
}

struct NamedScene {
  std::string name;
  Scene scene;
};

std::vector<double> shifted(std::vector<double> x, double dx, double dy, double dz) {
  const double by[] = {dx, dy, dz};
  for (std::size_t i = 0; i < x.size(); ++i) x[i] += by[i % 3];
  return x;
}

const Topology& triangle() {
  static const Topology topology = Topology::make(3, {{0, 1, 2}}).value();
  return topology;
}
const std::vector<double> kTriangle{0, 0, 0, 1, 0, 0, 0, 1, 0};

// The second goes through the first.
Scene two_triangles(double from, double to) {
  Scene scene;
  add_object(scene, triangle(), kTriangle, kTriangle);
  add_object(scene, triangle(), shifted(kTriangle, 0.2, 0.2, from), shifted(kTriangle, 0.2, 0.2, to));
  return scene;
}

// The second sinks through the first.
Scene two_sheets() {
  const testing::Mesh sheet = testing::cloth(4);
  Scene scene;
  add_object(scene, sheet.topology, sheet.positions, sheet.positions);
  add_object(scene, sheet.topology, shifted(sheet.positions, 0.3, 0.3, 0.4),
             shifted(sheet.positions, 0.4, 0.3, -0.6));
  return scene;
}

// One half is folded over the other.
Scene folded_strip() {
  constexpr Index kCells = 16;
  Scene scene;
  add_flat_strip(scene, kCells, [](double u) {
    return std::array{16 * std::min(u, 1 - u), std::max(0.0, u - 0.5)};
  });
  return scene;
}

TEST(BroadPhase, FindsEachPairOfNearLeavesOnce) {
  for (const auto& [name, scene] : {NamedScene{"a triangle downward", two_triangles(0.5, -0.5)},
                                    {"a triangle upward", two_triangles(-0.5, 0.5)},
                                    {"two sheets", two_sheets()},
                                    {"a folded strip", folded_strip()}}) {
    for (const Index leaf_triangles : {1u, 5u}) {
      for (const double distance : {0.0, 0.11}) {
        Stage stage(scene, leaf_triangles);
        const StepSettings settings = without_certificates();
        ASSERT_NO_FATAL_FAILURE(stage.find(scene, settings, distance));
        const auto expected = list(clearly_near(scene, stage.objects, settings, distance));
        EXPECT_EQ(stage.sorted(), expected) << name << ", " << leaf_triangles << ", " << distance;
        EXPECT_EQ(stage.work.leaf_pairs, expected.size());
      }
    }
  }
}

// Known by hand: each triangle with itself, and the two with each other.
TEST(BroadPhase, FindsTwoTrianglesThatPassThroughEachOther) {
  const Scene scene = two_triangles(0.5, -0.5);
  Stage stage(scene, 1);
  ASSERT_NO_FATAL_FAILURE(stage.find(scene, without_certificates(), 0));
  EXPECT_EQ(stage.sorted(),
            (std::vector{leaves_of(0, 0, 0, 0), leaves_of(0, 0, 1, 0), leaves_of(1, 0, 1, 0)}));
}

// What they sweep overlaps, but one stays ahead of the other.
TEST(BroadPhase, LeavesOutTrianglesThatMoveTogether) {
  Scene scene;
  add_object(scene, triangle(), kTriangle, shifted(kTriangle, 5, 0, 0));
  add_object(scene, triangle(), shifted(kTriangle, 1.5, 0, 0), shifted(kTriangle, 6.5, 0, 0));
  Stage stage(scene, 1);
  ASSERT_NO_FATAL_FAILURE(stage.find(scene, without_certificates(), 0.25));
  EXPECT_EQ(stage.sorted(), (std::vector{leaves_of(0, 0, 0, 0), leaves_of(1, 0, 1, 0)}));
  ASSERT_NO_FATAL_FAILURE(stage.find(scene, without_certificates(), 0.75));
  EXPECT_EQ(stage.sorted().size(), 3u);
}

TEST(BroadPhase, KeepsToWithinAndBetween) {
  const Scene scene = two_sheets();
  for (const bool within : {false, true}) {
    Stage stage(scene, 4);
    StepSettings settings = without_certificates();
    settings.within = within;
    settings.between = !within;
    ASSERT_NO_FATAL_FAILURE(stage.find(scene, settings, 0));
    EXPECT_EQ(stage.sorted(), list(clearly_near(scene, stage.objects, settings, 0)));
    EXPECT_FALSE(stage.found().empty());
  }
}

// Ignores object 0 with itself, the left half of object 1 with itself, and two leaves the sum of whose
// numbers is odd.
struct SomeLeaves final : PairFilter {
  std::vector<std::shared_ptr<const Hierarchy>> hierarchies;

  bool nodes(Index object_a, Index node_a, Index object_b, Index node_b) const override {
    const auto nodes_a = hierarchies[object_a]->nodes(), nodes_b = hierarchies[object_b]->nodes();
    const Hierarchy::Node &a = nodes_a[node_a], &b = nodes_b[node_b];
    if (object_a == 0 && object_b == 0) return false;
    if (object_a == 1 && object_b == 1 && std::max(a.leaf_end, b.leaf_end) <= nodes_a[1].leaf_end)
      return false;
    return !a.is_leaf() || !b.is_leaf() || (a.leaf_begin + b.leaf_begin) % 2 == 0;
  }
  bool leaves(const Leaves& leaves) const {
    const auto& [a, b] = leaves;
    const auto node_of = [&](const std::array<Index, 2>& leaf) {
      Index node = 0;
      for (const Hierarchy::Node& n : hierarchies[leaf[0]]->nodes()) {
        if (n.is_leaf() && n.leaf_begin == leaf[1]) return node;
        ++node;
      }
      return kNoIndex;
    };
    return nodes(a[0], node_of(a), b[0], node_of(b));
  }
  bool vertex_face(Index, Index, Index, Index) const override { return true; }
  bool edge_edge(Index, const Edge&, Index, const Edge&) const override { return true; }
  bool crossing(Index, Index, Index, Index) const override { return true; }
};

TEST(BroadPhase, LeavesOutWhatTheFilterIgnores) {
  const Scene scene = two_sheets();
  SomeLeaves some;
  Stage stage(scene, 2, Filter{&some, {}, true});
  for (const Object& object : stage.objects) some.hierarchies.push_back(object.hierarchy());
  const StepSettings settings = without_certificates();
  ASSERT_NO_FATAL_FAILURE(stage.find(scene, settings, 0));
  std::set<Leaves> expected = clearly_near(scene, stage.objects, settings, 0);
  const std::size_t all = expected.size();
  std::erase_if(expected, [&](const Leaves& leaves) { return !some.leaves(leaves); });
  EXPECT_EQ(stage.sorted(), list(expected));
  EXPECT_GT(expected.size(), 20u);
  EXPECT_LT(expected.size(), all);
}

// The order depends on the input only.
TEST(BroadPhase, FindsPairsInTheSameOrderWithAnyNumberOfThreads) {
  if (!has_threads()) GTEST_SKIP() << "there is one thread";
  const Scene scene = two_sheets();
  std::vector<std::vector<Leaves>> found;
  for (const int threads : {1, 4, 4}) {
    with_threads(threads, [&] {
      Stage stage(scene, 1);
      for (int step = 0; step < 3; ++step) ASSERT_NO_FATAL_FAILURE(stage.find(scene, {}, 0));
      found.push_back(stage.found());
    });
  }
  ASSERT_EQ(found.size(), 3u);
  EXPECT_GT(found[0].size(), 50u);
  EXPECT_EQ(found[1], found[0]);
  EXPECT_EQ(found[2], found[0]);
}

// ---- From step to step. Segments along the axes, with integer coordinates, are their own boxes: two of them
// come near each other only if they touch, which no certificate can hide. So the result is known although
// certificates are on, without which the broad phase keeps no front.

Scene segments(Index objects, Index per_object, Rng& rng) {
  Scene scene;
  for (Index object = 0; object < objects; ++object) {
    std::vector<Edge> lines;
    std::vector<double> x;
    for (Index i = 0; i < per_object; ++i) {
      lines.push_back({2 * i, 2 * i + 1});
      const std::size_t along = rng() % 3;
      for (std::size_t axis = 0; axis < 3; ++axis) x.push_back(double(rng() % 6));
      for (std::size_t axis = 0; axis < 3; ++axis) x.push_back(x[x.size() - 3] + (axis == along ? 2 : 0));
    }
    add_object(scene, Topology::make(2 * per_object, {}, lines, {}).value(), x, x);
  }
  return scene;
}

// Each third segment jumps by one along an axis.
void move(Scene& scene, Rng& rng) {
  for (auto& x : scene.x0) {
    for (std::size_t i = 0; i < x.size(); i += 6) {
      if (rng() % 3 != 0) continue;
      const std::size_t axis = rng() % 3;
      const double by = x[i + axis] >= 5 ? -1 : x[i + axis] <= 0 || rng() % 2 == 0 ? 1 : -1;
      x[i + axis] += by;
      x[i + 3 + axis] += by;
    }
  }
  scene.x1 = scene.x0;
}

// A front is made anew after 16 steps. Now and then one object is away, for fewer and for more steps, and
// pairs within objects or between them are not asked for.
TEST(BroadPhase, LosesNoPairFromStepToStep) {
  for (const auto& [objects, per_object] : {std::pair<Index, Index>{2, 90}, {2, 30}, {18, 4}}) {
    Rng rng(objects);
    Scene scene = segments(objects, per_object, rng);
    Stage kept(scene, 1);
    ASSERT_EQ(kept.objects[0].hierarchy()->leaf_count(), per_object);
    ASSERT_EQ(kept.motion.subtrees(0).roots.size() > 1, per_object > 16);
    Work fresh_work;
    std::size_t touching = 0;
    for (int step = 0; step < 50; ++step, move(scene, rng)) {
      const bool away = (step >= 9 && step < 12) || (step >= 16 && step < 36);
      StepSettings settings;
      settings.within = step % 7 != 3;
      settings.between = step % 7 != 5;
      Scene now = scene;
      for (std::size_t i = 0; away && i < now.x0[0].size(); i += 3) now.x0[0][i] += 64;
      now.x1 = now.x0;
      ASSERT_NO_FATAL_FAILURE(kept.find(now, settings, 0.25));
      const auto expected = list(clearly_near(now, kept.objects, settings, 0.25));
      ASSERT_EQ(kept.sorted(), expected) << "step " << step << " of " << objects << " objects";
      for (const auto& [a, b] : expected) touching += a != b;
      Stage fresh(now, 1);
      ASSERT_NO_FATAL_FAILURE(fresh.find(now, settings, 0.25));
      fresh_work += fresh.work;
    }
    EXPECT_GT(touching, 500u);
    EXPECT_NE(kept.work.node_tests, fresh_work.node_tests) << "it resumes from no front";
  }
}

TEST(BroadPhase, CountsNearLeavesWhateverIsCulled) {
  const testing::Mesh sheet = testing::cloth(6);
  Scene scene;
  add_object(scene, sheet.topology, sheet.positions, sheet.positions);
  add_object(scene, sheet.topology, shifted(sheet.positions, 0.3, 0.3, 0.01),
             shifted(sheet.positions, 0.3, 0.3, 0.01));
  Stage stage(scene, 4);
  StepSettings settings;
  settings.explain = true;  // uses certificates also where they do not pay
  const std::size_t near = clearly_near(scene, stage.objects, settings, 0.05).size();
  for (int step = 0; step < 4; ++step) {
    ASSERT_NO_FATAL_FAILURE(stage.find(scene, settings, 0.05));
    EXPECT_EQ(stage.broad_phase.count_near_leaves(stage.motion, stage.culling, stage.filter, settings, 0.05),
              near);
  }
  EXPECT_LT(stage.found().size(), near) << "nothing was culled";
}

}  // namespace
}  // namespace foldproof::oracle
