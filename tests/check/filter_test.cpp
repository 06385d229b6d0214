// Filters of labels: the answer is that of all pairs without those that are ignored by the definition.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <set>
#include <thread>

#include "base/callers.h"
#include "base/parallel.h"
#include "bvh/meshes.h"
#include "check/animations.h"
#include "check/same_collisions.h"
#include "mesh/grid.h"

namespace foldproof::oracle {
namespace {

using foldproof::testing::expect_same_collisions;

// Labels of all triangles, and which pairs of them are ignored.
struct Labels {
  std::vector<std::vector<Index>> of;  // per object, one per triangle
  std::vector<std::array<Index, 2>> ignored;

  bool ignores(Index a, Index b) const {
    return std::ranges::any_of(ignored, [&](const auto& pair) {
      return pair == std::array{a, b} || pair == std::array{b, a};
    });
  }
};

// The definition, with loops over all triangles.
struct Definition {
  std::span<const Topology> topologies;
  const Labels& labels;

  template <std::size_t N>
  std::set<Index> labels_at(Index object, const std::array<Index, N>& vertices) const {
    std::set<Index> out;
    const auto triangles = topologies[object].triangles();
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      const auto has = [&](Index v) { return std::ranges::count(triangles[t], v) > 0; };
      if (std::ranges::all_of(vertices, has)) out.insert(labels.of[object][t]);
    }
    return out;
  }
  bool tests(const std::set<Index>& a, const std::set<Index>& b) const {
    return std::ranges::any_of(
        a, [&](Index i) { return std::ranges::any_of(b, [&](Index k) { return !labels.ignores(i, k); }); });
  }
  bool tests(const VertexFaceCollision& c) const {
    return tests(labels_at(c.vertex_object, std::array{c.vertex}), {labels.of[c.face_object][c.face]});
  }
  bool tests(const EdgeEdgeCollision& c) const {
    return tests(labels_at(c.object_a, c.a), labels_at(c.object_b, c.b));
  }
  bool tests(const TriangleCrossing& c) const {
    return !labels.ignores(labels.of[c.object_a][c.triangle_a], labels.of[c.object_b][c.triangle_b]);
  }
  template <class Pair>
  std::size_t remove_ignored(std::vector<Pair>& pairs) const {
    std::ranges::sort(pairs, {}, [](const Pair& pair) { return key(pair); });
    return std::erase_if(pairs, [&](const Pair& pair) { return !tests(pair); });
  }
};

// By number, by place or for whole objects; some of the pairs of labels are ignored.
Labels random_labels(std::span<const Topology> topologies, const std::vector<Pose>& x, Rng& rng) {
  Labels labels;
  const Index count = 2 + static_cast<Index>(rng() % 4);
  for (std::size_t i = 0; i < topologies.size(); ++i) {
    auto& of = labels.of.emplace_back();
    const std::uint64_t style = rng() % 4, axis = rng() % 3, any = rng() % count;
    for (const Triangle& t : topologies[i].triangles()) {
      const double place = x[i][3 * std::size_t{t[0]} + axis];
      of.push_back(static_cast<Index>(style == 0   ? rng() % count
                                      : style == 1 ? any
                                                   : static_cast<std::uint64_t>(8 * (place + 8)) % count));
    }
  }
  for (Index a = 0; a < count; ++a) {
    for (Index b = a; b < count; ++b) {
      if (rng() % 2 == 0) labels.ignored.push_back({a, b});
    }
  }
  return labels;
}

std::shared_ptr<const PairFilter> filter_of(std::span<const Object> objects, const Labels& labels) {
  auto filter = ignore_labels(objects, labels.of, labels.ignored);
  EXPECT_TRUE(filter.has_value());
  return filter.value_or(nullptr);
}

struct Found {
  std::size_t kept = 0, ignored = 0;
};

void expect_filtered(const Definition& definition, StepResult all, const StepResult& actual, Found& found) {
  found.ignored += definition.remove_ignored(all.vertex_face) + definition.remove_ignored(all.edge_edge);
  found.kept += all.vertex_face.size() + all.edge_edge.size();
  expect_same_collisions(actual, all);
  EXPECT_EQ(actual.vertex_face_count, all.vertex_face.size());
  EXPECT_EQ(actual.edge_edge_count, all.edge_edge.size());
}

void expect_filtered(const Definition& definition, StaticResult all, const StaticResult& actual,
                     Found& found) {
  found.ignored += definition.remove_ignored(all.crossings);
  found.kept += all.crossings.size();
  oracle::expect_same(actual, all);
  EXPECT_EQ(actual.crossing_count, all.crossings.size());
}

class Filters : public ::testing::TestWithParam<MeshFamily> {};

TEST_P(Filters, AnswerAsBruteForceWithoutIgnoredPairs) {
  Rng rng(71);
  Found steps, poses;
  for (int round = 0; round < 3; ++round) {
    Scene scene;
    const std::size_t objects = 1 + rng() % 3;
    for (std::size_t i = 0; i < objects; ++i) {
      const Mesh mesh = (i == 0 ? GetParam() : mesh_families()[rng() % mesh_families().size()]).make(rng);
      scene.topologies.push_back(mesh.topology());
      scene.x0.push_back(deformed(mesh.positions, 0.2, round % 2 == 0 ? 0 : 1.0 / 32, rng));
      scene.x1.push_back(deformed(scene.x0.back(), 0.3, round % 2 == 0 ? 0 : 1.0 / 32, rng));
    }
    const Labels labels = random_labels(scene.topologies, scene.x0, rng);
    const Definition definition{scene.topologies, labels};
    const auto own = scene.hierarchies(round % 3 == 0 ? 2 : 12);
    StepChecker checker(own, filter_of(own, labels));
    const StepSettings settings{.certificates = rng() % 2 == 0};
    StepResult step;
    StaticResult pose;
    ASSERT_TRUE(checker.check(scene.spans0(), scene.spans1(), settings, step));
    expect_filtered(definition, brute_force_step(scene, settings, step.tolerance), step, steps);
    ASSERT_TRUE(checker.check_static(scene.spans0(), settings, pose));
    expect_filtered(definition, brute_force_static(scene, settings), pose, poses);
    ASSERT_FALSE(HasFailure()) << "round " << round;
  }
  EXPECT_GT(steps.kept + poses.kept, 5u);
  EXPECT_GT(steps.ignored + poses.ignored, 5u);
}

INSTANTIATE_TEST_SUITE_P(Families, Filters, ::testing::ValuesIn(mesh_families()),
                         [](const auto& info) { return info.param.name; });

class FilteredAnimations : public ::testing::TestWithParam<AnimationFamily> {};

// With certificates and fronts that are kept from step to step.
TEST_P(FilteredAnimations, AnswerAsAllPairsWithoutIgnoredOnes) {
  Rng rng(72);
  const Animation animation = GetParam().make(rng);
  Found steps, poses;
  for (int round = 0; round < 3; ++round) {
    const Labels labels = random_labels(animation.topologies, animation.poses[0], rng);
    const Definition definition{animation.topologies, labels};
    const auto own = hierarchies(animation, 4);
    StepChecker all(own), filtered(own, filter_of(own, labels));
    StepResult all_step, step;
    StaticResult all_pose, pose;
    for (std::size_t k = 0; k + 1 < animation.poses.size(); ++k) {
      const auto x0 = spans(animation.poses[k]), x1 = spans(animation.poses[k + 1]);
      const StepSettings settings{.explain = k % 5 == 4};
      ASSERT_TRUE(all.check(x0, x1, {.certificates = false}, all_step));
      ASSERT_TRUE(filtered.check(x0, x1, settings, step));
      expect_filtered(definition, all_step, step, steps);
      if (k % 7 == 0) {
        ASSERT_TRUE(all.check_static(x0, {}, all_pose));
        ASSERT_TRUE(filtered.check_static(x0, {}, pose));
        expect_filtered(definition, all_pose, pose, poses);
      }
      ASSERT_FALSE(HasFailure()) << "step " << k;
    }
  }
  EXPECT_GT(steps.kept + poses.kept, 5u);
  EXPECT_GT(steps.ignored + poses.ignored, 5u);
}

INSTANTIATE_TEST_SUITE_P(Animations, FilteredAnimations, ::testing::ValuesIn(generated_animations()),
                         [](const auto& info) { return info.param.name; });

// Two sheets of 1800 triangles that go through each other, and lie on each other.
struct Sheets {
  static constexpr Index kSide = 30;
  Topology topology;
  Pose x0, x1;
  Sheets() {
    topology = testing::Grid{kSide, kSide}.topology();
    for (Index j = 0; j <= kSide; ++j) {
      for (Index i = 0; i <= kSide; ++i) {
        x0.insert(x0.end(), {double(i), double(j), 0});
        x1.insert(x1.end(), {double(i), double(j), 0.1 * ((i + j) % 3)});
      }
    }
  }
};

// One sheet goes straight through another, so that a search covers several steps.
TEST(Filter, AppliesToCandidatesOfASearchThatLooksAhead) {
  const Sheets s;
  const auto hierarchy = std::make_shared<const Hierarchy>(Hierarchy::build(s.topology, s.x1).value());
  const std::vector<Object> objects{hierarchy, hierarchy};
  const std::vector<Topology> topologies{s.topology, s.topology};
  Labels labels{{{}, {}}, {{0, 3}, {1, 2}, {2, 2}}};
  for (const Triangle& t : s.topology.triangles()) {
    labels.of[0].push_back(s.x0[3 * std::size_t{t[0]}] < 15 ? 0 : 1);
    labels.of[1].push_back(s.x0[3 * std::size_t{t[0]} + 1] < 15 ? 2 : 3);
  }
  const Definition definition{topologies, labels};
  StepChecker all(objects), filtered(objects, filter_of(objects, labels));
  StepResult all_step, step;
  Found found;
  int covered = 0;
  const auto above = [&](int k) {
    Pose x = s.x1;
    for (std::size_t v = 0; v < x.size(); v += 3) x[v] += 0.31, x[v + 1] += 0.17, x[v + 2] += 1 - 0.05 * k;
    return x;
  };
  for (int k = 0; k < 40; ++k) {
    const Pose from = above(k), to = above(k + 1);
    const std::span<const double> x0[] = {s.x1, from}, x1[] = {s.x1, to};
    ASSERT_TRUE(all.check(x0, x1, {.certificates = false}, all_step));
    ASSERT_TRUE(filtered.check(x0, x1, {}, step));
    covered += step.search_steps == 0;
    expect_filtered(definition, all_step, step, found);
    ASSERT_FALSE(HasFailure()) << "step " << k;
  }
  EXPECT_GT(covered, 10);
  EXPECT_GT(found.kept, 1000u);
  EXPECT_GT(found.ignored, 1000u);
}

TEST(FilterWork, IgnoredPairsCostNothing) {
  const Sheets s;
  const auto hierarchy = std::make_shared<const Hierarchy>(Hierarchy::build(s.topology, s.x0).value());
  const std::vector<Object> objects{hierarchy, hierarchy};
  const std::span<const double> x0[] = {s.x0, s.x1}, x1[] = {s.x1, s.x0};
  const auto work_of = [&](std::vector<std::array<Index, 2>> ignored, StepSettings settings) {
    const std::vector<Index> labels[] = {{0}, {1}};
    StepChecker checker(objects, ignore_labels(objects, labels, ignored).value());
    StepResult step;
    EXPECT_TRUE(checker.check(x0, x1, settings, step));
    return step;
  };
  const StepResult all = work_of({}, {});
  EXPECT_GT(all.count(), 10'000u);
  EXPECT_GT(all.work.node_tests, 1000u);

  const StepResult none = work_of({{0, 0}, {1, 1}, {0, 1}}, {});
  EXPECT_TRUE(none.clean());
  EXPECT_EQ(none.work.node_tests, 0u);
  EXPECT_EQ(none.work.certificate_tests, 0u);
  EXPECT_EQ(none.work.leaf_pairs, 0u);
  EXPECT_EQ(none.work.candidates_vf + none.work.candidates_ee, 0u);

  // What remains costs what it costs alone.
  for (const bool certificates : {true, false}) {
    const StepResult within = work_of({{1, 0}}, {.certificates = certificates});
    const StepResult between = work_of({{0, 0}, {1, 1}}, {.certificates = certificates});
    const StepSettings only_within{.between = false, .certificates = certificates};
    const StepSettings only_between{.within = false, .certificates = certificates};
    EXPECT_TRUE(same_counts(within.work, work_of({}, only_within).work));
    EXPECT_TRUE(same_counts(between.work, work_of({}, only_between).work));
  }
}

// Labels 0 and 1 divide a sheet along a line: of pairs within label 1, only those at the line are asked for.
TEST(FilterWork, PartsCostWhatTheirBorderCosts) {
  const Sheets s;
  std::vector<Index> half;
  for (const Triangle& t : s.topology.triangles()) half.push_back(s.x0[3 * std::size_t{t[0]}] < 15 ? 0 : 1);
  const std::vector<Object> objects{
      std::make_shared<const Hierarchy>(Hierarchy::build(s.topology, s.x0).value())};
  const std::array<Index, 2> ignored[] = {{0, 0}, {1, 1}};
  StepChecker all(objects), filtered(objects, ignore_labels(objects, std::span(&half, 1), ignored).value());
  StepResult with, without;
  ASSERT_TRUE(all.check(s.x0, s.x1, {}, without));
  ASSERT_TRUE(filtered.check(s.x0, s.x1, {}, with));
  EXPECT_LT(with.work.node_tests, without.work.node_tests / 2);
  EXPECT_LT(with.work.leaf_pairs, without.work.leaf_pairs / 4);
}

// A triangle three times, in the parts 0, 0 and 1: what is ignored of one copy is not of the others.
TEST(Filter, CopiesWithDifferentLabelsAreNotOne) {
  const Topology twice = Topology::make(3, {{0, 1, 2}, {0, 1, 2}, {0, 1, 2}}).value();
  const Topology once = Topology::make(3, {{0, 1, 2}}).value();
  const Pose flat{0, 0, 0, 4, 0, 0, 0, 4, 0}, needle{1, 1, -1, 1.1, 1, -1, 1, 1, 1};
  const std::vector<Object> objects{Hierarchy::build(twice, flat).value(),
                                    Hierarchy::build(once, needle).value()};
  const std::vector<Index> labels[] = {{0, 0, 1}, {2}};
  const std::span<const double> x[] = {flat, needle};
  const auto crossings = [&](std::vector<std::array<Index, 2>> ignored) {
    StepChecker checker(objects, ignore_labels(objects, labels, ignored).value());
    StaticResult pose;
    EXPECT_TRUE(checker.check_static(x, {}, pose));
    EXPECT_EQ(pose.crossing_count, pose.crossings.size());
    std::vector<std::array<Index, 4>> out;
    for (const TriangleCrossing& c : pose.crossings)
      out.push_back({c.object_a, c.triangle_a, c.object_b, c.triangle_b});
    return out;
  };
  using Pairs = std::vector<std::array<Index, 4>>;
  const Pairs all{{0, 0, 0, 1}, {0, 0, 0, 2}, {0, 0, 1, 0}, {0, 1, 0, 2}, {0, 1, 1, 0}, {0, 2, 1, 0}};
  EXPECT_EQ(crossings({}), all);
  EXPECT_EQ(crossings({{0, 2}}), (Pairs{all[0], all[1], all[3], all[5]}));
  EXPECT_EQ(crossings({{2, 1}}), (Pairs{all[0], all[1], all[2], all[3], all[4]}));
  EXPECT_EQ(crossings({{0, 0}}), (Pairs{all[1], all[2], all[3], all[4], all[5]}));
  EXPECT_EQ(crossings({{0, 1}}), (Pairs{all[0], all[2], all[4], all[5]}));
}

TEST(Filter, ObjectsThatShareAHierarchyHaveLabelsOfTheirOwn) {
  const Topology once = Topology::make(3, {{0, 1, 2}}).value();
  const Pose flat{0, 0, 0, 4, 0, 0, 0, 4, 0}, above{1, 1, 1, 2, 1, 1, 1, 2, 1},
      below{1, 1, -1, 2, 1, -1, 1, 2, -1};
  const Object one = Hierarchy::build(once, flat).value();
  const std::vector<Object> objects{one, one, one};
  const std::vector<Index> labels[] = {{0}, {1}, {2}};
  const std::array<Index, 2> ignored[] = {{0, 1}};
  const std::span<const double> x0[] = {flat, above, above}, x1[] = {flat, below, below};
  StepChecker checker(objects, ignore_labels(objects, labels, ignored).value());
  StepResult step;
  ASSERT_TRUE(checker.check(x0, x1, {}, step));
  std::set<std::array<Index, 2>> pairs;
  for (const VertexFaceCollision& c : step.vertex_face) pairs.insert({c.vertex_object, c.face_object});
  EXPECT_EQ(pairs, (std::set<std::array<Index, 2>>{{1, 2}, {2, 0}, {2, 1}}));
}

TEST(Filter, LabelsThatDoNotFitAreErrors) {
  const Topology once = Topology::make(3, {{0, 1, 2}}).value();
  const std::vector<Object> objects{Hierarchy::build(once, Pose{0, 0, 0, 4, 0, 0, 0, 4, 0}).value()};
  const auto error_of = [&](std::vector<std::vector<Index>> labels, std::array<Index, 2> ignored) {
    const auto filter = ignore_labels(objects, labels, std::span(&ignored, 1));
    return filter ? std::string() : filter.error().line();
  };
  EXPECT_EQ(error_of({{0}}, {0, 7}), "");
  EXPECT_NE(error_of({}, {0, 0}).find("are of 0 objects instead of 1"), std::string::npos);
  EXPECT_NE(error_of({{0, 1}}, {0, 0}).find("2 for 1 triangles"), std::string::npos);
  EXPECT_NE(error_of({{10'001}}, {0, 0}).find("10001"), std::string::npos);
  EXPECT_NE(error_of({{0}}, {0, 10'001}).find("10001"), std::string::npos);
}

// A thread that waits for a loop of the user's filter must not take up another chunk meanwhile. Iterations
// sleep, so that others take them and this thread waits.
struct StartsLoops final : PairFilter {
  mutable std::atomic<int> calls = 0;
  bool loop() const {
    if (++calls % 1024 == 0)
      parallel_for(0, 8, [](int) { std::this_thread::sleep_for(std::chrono::microseconds(200)); });
    return true;
  }
  bool nodes(Index, Index, Index, Index) const override { return loop(); }
  bool vertex_face(Index, Index, Index, Index) const override { return loop(); }
  bool edge_edge(Index, const Edge&, Index, const Edge&) const override { return loop(); }
  bool crossing(Index, Index, Index, Index) const override { return loop(); }
};

TEST(Filter, MayStartLoops) {
  if (!has_threads()) GTEST_SKIP() << "there is one thread";
  const testing::Mesh sheet = testing::cloth(40);
  Scene scene;
  for (const double height : {0.0, 0.01}) {
    scene.topologies.push_back(sheet.topology);
    scene.x0.push_back(sheet.positions);
    for (std::size_t i = 2; i < sheet.positions.size(); i += 3)
      scene.x0.back()[i] += height * std::sin(0.1 * static_cast<double>(i));
    scene.x1.push_back(scene.x0.back());
    for (std::size_t i = 2; i < sheet.positions.size(); i += 3) scene.x1.back()[i] += 0.5 * height;
  }
  const auto x0 = scene.spans0(), x1 = scene.spans1();
  with_threads(8, [&] {
    StepChecker plain(scene.hierarchies(4)), loops(scene.hierarchies(4), std::make_shared<StartsLoops>());
    StepResult expected, step;
    StaticResult expected_pose, pose;
    for (int repeat = 0; repeat < 4; ++repeat) {
      ASSERT_TRUE(plain.check(x0, x1, {}, expected) && loops.check(x0, x1, {}, step));
      expect_same_collisions(step, expected);
    }
    ASSERT_TRUE(plain.check_static(x0, {}, expected_pose) && loops.check_static(x0, {}, pose));
    EXPECT_EQ(pose.crossing_count, expected_pose.crossing_count);
    EXPECT_GT(expected.count(), 100u);
    EXPECT_GT(expected_pose.crossing_count, 100u);
  });
}

}  // namespace
}  // namespace foldproof::oracle
