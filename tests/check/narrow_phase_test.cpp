// The narrow phase tests every pair of features of the pairs of leaves that it is given, and finds the time
// of impact of those that collide.
#include "check/narrow_phase.h"

#include <gtest/gtest.h>

#include "check/answer.h"
#include "check/stages.h"

namespace foldproof::oracle {
namespace {

// The narrow phase with what it needs of the motion.
class Stage {
 public:
  explicit Stage(Scene scene, Index leaf_triangles = 1)
      : scene_(std::move(scene)),
        objects_(scene_.hierarchies(leaf_triangles)),
        motion_(objects_),
        x0_(scene_.spans0()),
        x1_(scene_.spans1()) {
    EXPECT_TRUE(motion_.update(x0_, x1_));
    const float margin = separation_margin(motion_.frame(), 0.5);
    for (Index a = 0; a < motion_.size(); ++a) {
      for (Index b = a; b < motion_.size(); ++b)
        tasks_.push_back({{&motion_.bvhs()[a], &motion_.bvhs()[b], margin}, a, b});
    }
  }

  const Hierarchy& hierarchy(Index object) const { return motion_.hierarchy(object); }

  std::vector<TaskLeaves> all_pairs() const {
    std::vector<TaskLeaves> pairs;
    for (Index task = 0; task < tasks_.size(); ++task) {
      const auto& [traversal, a, b] = tasks_[task];
      for (Index i = 0; i < hierarchy(a).leaf_count(); ++i) {
        for (Index k = a == b ? i : 0; k < hierarchy(b).leaf_count(); ++k)
          pairs.push_back({task, {LeafIndex(i), LeafIndex(k)}});
      }
    }
    return pairs;
  }

  StepResult test(const StepSettings& settings = {}, int max_iterations = 100000) {
    return test(all_pairs(), settings, {}, max_iterations);
  }
  StepResult test(const std::vector<TaskLeaves>& pairs, const StepSettings& settings, Filter filter = {},
                  int max_iterations = 100000) {
    motion_.fill_features(tasks_, pairs);
    NarrowStep step(settings, settings.tolerance, motion_.bvhs(), tasks_, x0_, x1_);
    step.filter = filter;
    step.ccd.max_iterations = max_iterations;
    StepResult out;
    test_leaf_pairs(step, pairs, scratch_, out);
    finish(settings, out);
    return out;
  }

 private:
  Scene scene_;
  std::vector<Object> objects_;
  StepMotion motion_;
  std::vector<std::span<const double>> x0_, x1_;
  std::vector<TraversalTask> tasks_;
  NarrowScratch scratch_;
};

const Topology& triangle() {
  static const Topology topology = Topology::make(3, {{0, 1, 2}}).value();
  return topology;
}

// A large triangle in the plane z = 0, and a small one above whose first corner points down. The corner goes
// from height `from` to height `to`.
Scene corner_above_face(double from, double to, bool face_first = true) {
  const std::vector<double> face{-9, -9, 0, 20, -9, 0, -9, 20, 0};
  const auto corner = [](double z) { return std::vector<double>{0, 0, z, 1, 0, z + 1, 0, 1, z + 1}; };
  Scene scene;
  for (const bool is_face : {face_first, !face_first})
    add_object(scene, triangle(), is_face ? face : corner(from), is_face ? face : corner(to));
  return scene;
}

// Two triangles that stand upright, one on an edge along x and one below on an edge along y.
Scene crossed_edges(double from, double to) {
  const auto upper = [](double z) { return std::vector<double>{-1, 0, z, 1, 0, z, 0, 0, z + 1}; };
  const std::vector<double> lower{0, -1, 0, 0, 1, 0, 0, 0, -1};
  Scene scene;
  add_object(scene, triangle(), upper(from), upper(to));
  add_object(scene, triangle(), lower, lower);
  return scene;
}

TEST(NarrowPhase, FindsWhenACornerMeetsAFace) {
  for (const bool face_first : {true, false}) {
    const StepResult found = Stage(corner_above_face(0.6, -0.4, face_first)).test();
    ASSERT_EQ(found.vertex_face.size(), 1u);
    const VertexFaceCollision& hit = found.vertex_face[0];
    EXPECT_EQ((std::array{hit.vertex_object, hit.vertex, hit.face_object, hit.face}),
              (std::array<Index, 4>{face_first, 0, !face_first, 0}));
    EXPECT_EQ(hit.answer, Answer::Hit);
    EXPECT_NEAR(hit.toi, 0.6, 1e-9);
    EXPECT_LE(hit.toi, 0.6) << "something touches before";
    EXPECT_EQ(found.edge_edge.size(), 0u);
    EXPECT_EQ(found.earliest_toi, hit.toi);
  }
}

TEST(NarrowPhase, FindsWhenTwoEdgesMeet) {
  const StepResult found = Stage(crossed_edges(0.25, -0.25)).test();
  ASSERT_EQ(found.edge_edge.size(), 1u);
  const EdgeEdgeCollision& hit = found.edge_edge[0];
  EXPECT_EQ(hit.object_a, 0u);
  EXPECT_EQ(hit.a, (Edge{0, 1}));
  EXPECT_EQ(hit.object_b, 1u);
  EXPECT_EQ(hit.b, (Edge{0, 1}));
  EXPECT_NEAR(hit.toi, 0.5, 1e-9);
  EXPECT_LE(hit.toi, 0.5);
}

TEST(NarrowPhase, AThicknessIsReachedEarlier) {
  StepSettings settings;
  settings.thickness = 0.1;
  const StepResult found = Stage(corner_above_face(0.6, -0.4)).test(settings);
  ASSERT_EQ(found.vertex_face.size(), 1u);
  EXPECT_NEAR(found.vertex_face[0].toi, 0.5, 1e-9);
}

TEST(NarrowPhase, WhatTouchesAtTheStartIsHitAtTimeZero) {
  const StepResult found = Stage(corner_above_face(0, 1)).test();
  ASSERT_EQ(found.vertex_face.size(), 1u);
  EXPECT_EQ(found.vertex_face[0].toi, 0);
}

TEST(NarrowPhase, WhatComesNearButDoesNotTouchIsACandidateOnly) {
  const StepResult found = Stage(corner_above_face(0.6, 0.01)).test();
  EXPECT_GT(found.work.candidates_vf, 0u);
  EXPECT_EQ(found.vertex_face_count + found.edge_edge_count, 0u);
  EXPECT_EQ(found.earliest_toi, 1);
}

// One iteration is too few to follow the corner to the face. The time until which it is free is proven.
TEST(NarrowPhase, ReportsUndecidedPairsAsHits) {
  const StepResult found = Stage(corner_above_face(0.6, -0.4)).test({}, 1);
  ASSERT_GE(found.vertex_face.size(), 1u);
  EXPECT_EQ(found.vertex_face[0].vertex, 0u);
  EXPECT_EQ(found.vertex_face[0].answer, Answer::Undecided);
  EXPECT_LE(found.vertex_face[0].toi, 0.6);
  std::uint64_t undecided = 0;
  for (const auto& hit : found.vertex_face) undecided += hit.answer == Answer::Undecided;
  for (const auto& hit : found.edge_edge) undecided += hit.answer == Answer::Undecided;
  EXPECT_EQ(found.work.undecided, undecided);
}

// The corners of neighbors touch all the time.
TEST(NarrowPhase, DoesNotTestFeaturesWithACommonVertex) {
  Scene scene;
  const std::vector<double> x{0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 1};
  add_object(scene, Topology::make(4, {{0, 1, 2}, {1, 3, 2}}).value(), x, x);
  StepSettings settings;
  settings.thickness = 0.1;
  const StepResult found = Stage(scene).test(settings);
  EXPECT_EQ(found.vertex_face_count + found.edge_edge_count, 0u);
  // What remains: the far corner of each with the other, far edges with each other.
  EXPECT_LE(found.work.candidates_vf, 2u);
}

// Against brute force: a strip that is folded through itself, in leaves of several triangles.
TEST(NarrowPhase, FindsWhatBruteForceFinds) {
  constexpr Index kCells = 12;
  Scene scene;
  add_flat_strip(scene, kCells, [](double u) {
    const double height = std::max(0.0, u - 0.5);
    return std::array{12 * std::min(u, 1 - u) + 0.3 * u, u > 0.8 ? -height : height};
  });
  StepSettings settings;
  settings.tolerance = 1e-6;
  for (const Index leaf_triangles : {1u, 6u}) {
    const StepResult found = Stage(scene, leaf_triangles).test(settings),
                     expected = brute_force_step(scene, settings, settings.tolerance);
    EXPECT_GT(expected.edge_edge.size(), 3u);
    const auto same = [](const auto& a, const auto& b) { return key(a) == key(b) && a.toi == b.toi; };
    EXPECT_TRUE(std::ranges::equal(found.vertex_face, expected.vertex_face, same));
    EXPECT_TRUE(std::ranges::equal(found.edge_edge, expected.edge_edge, same));
  }
}

// ---- Many pairs: a row of corners above a row of triangles. Corner k meets its triangle at
// (k + 1) / (kMany + 1). These are so many pairs of leaves that they are tested in several rounds.

constexpr Index kMany = 9000;

Scene row_of_corners() {
  std::vector<Triangle> triangles;
  std::vector<double> floor, x0, x1;
  for (Index k = 0; k < kMany; ++k) {
    const double at = 4.0 * k, toi = (k + 1.0) / (kMany + 1);
    triangles.push_back({3 * k, 3 * k + 1, 3 * k + 2});
    floor.insert(floor.end(), {at - 1, -1, 0, at + 1, -1, 0, at, 2, 0});
    x0.insert(x0.end(), {at, 0, toi, at + 0.1, 0, toi + 1, at, 0.1, toi + 1});
    x1.insert(x1.end(), {at, 0, toi - 1, at + 0.1, 0, toi, at, 0.1, toi});
  }
  const Topology topology = Topology::make(3 * kMany, std::move(triangles)).value();
  Scene scene;
  add_object(scene, topology, floor, floor);
  add_object(scene, topology, x0, x1);
  return scene;
}

class ManyPairs : public ::testing::Test {
 protected:
  // In no order that the answer could be in by chance.
  ManyPairs() : limit_(4), stage(row_of_corners(), 1) {
    const Owners floor(stage.hierarchy(0)), row(stage.hierarchy(1));
    for (Index k = 0; k < kMany; ++k)
      pairs.push_back({1, {LeafIndex(floor.of_triangle.at(k)), LeafIndex(row.of_triangle.at(k))}});
    std::shuffle(pairs.begin(), pairs.end(), Rng(1));
  }

 private:
  ThreadLimit limit_;  // which limits the pairs of a round

 protected:
  Stage stage;
  std::vector<TaskLeaves> pairs;
};

TEST_F(ManyPairs, FindsAllInTheOrderOfTheirIds) {
  const StepResult found = stage.test(pairs, {});
  ASSERT_EQ(found.vertex_face.size(), kMany);
  EXPECT_EQ(found.vertex_face_count, kMany);
  EXPECT_EQ(found.edge_edge_count, 0u);
  for (Index k = 0; k < kMany; ++k) {
    const VertexFaceCollision& hit = found.vertex_face[k];
    ASSERT_EQ((std::array{hit.vertex_object, hit.vertex, hit.face_object, hit.face}),
              (std::array<Index, 4>{1, 3 * k, 0, k}));
    ASSERT_NEAR(hit.toi, (k + 1.0) / (kMany + 1), 1e-6);
  }
  EXPECT_EQ(found.earliest_toi, found.vertex_face[0].toi);
}

TEST_F(ManyPairs, ListsTheFirstAndCountsAll) {
  StepSettings settings;
  settings.max_listed = 10;
  const StepResult found = stage.test(pairs, settings);
  ASSERT_EQ(found.vertex_face.size(), 10u);
  for (Index k = 0; k < 10; ++k) EXPECT_EQ(found.vertex_face[k].face, k);
  EXPECT_EQ(found.vertex_face_count, kMany);
}

TEST_F(ManyPairs, KeepsTheEarliestOnly) {
  StepSettings settings;
  settings.earliest_only = true;
  const StepResult found = stage.test(pairs, settings);
  ASSERT_EQ(found.vertex_face.size(), 1u);
  EXPECT_EQ(found.vertex_face[0].face, 0u);
  EXPECT_NEAR(found.earliest_toi, 1.0 / (kMany + 1), 1e-6);
}

// Ignores faces with odd numbers.
struct EvenFaces final : PairFilter {
  bool nodes(Index, Index, Index, Index) const override { return true; }
  bool vertex_face(Index, Index, Index, Index face) const override { return face % 2 == 0; }
  bool edge_edge(Index, const Edge&, Index, const Edge&) const override { return true; }
  bool crossing(Index, Index, Index, Index) const override { return true; }
};

TEST_F(ManyPairs, LeavesOutWhatTheFilterIgnores) {
  const EvenFaces even;
  const StepResult found = stage.test(pairs, {}, Filter{&even, {}, true});
  ASSERT_EQ(found.vertex_face.size(), kMany / 2);
  for (Index k = 0; k < kMany / 2; ++k) ASSERT_EQ(found.vertex_face[k].face, 2 * k);
}

// Whatever the number of pairs is to that of chunks and rounds.
TEST(NarrowPhase, ChunksHaveEachPairOnceInTheirOrder) {
  for (const std::size_t count : {0u, 1u, 2u, 3u, 4u, 1535u, 1536u, 1537u, 3072u, 4000u}) {
    std::vector<Index> pairs(count);
    for (Index i = 0; i < count; ++i) pairs[i] = i;
    std::vector<Hits> scratch;
    std::vector<Index> seen;
    const auto test = [](std::span<const Index> chunk, Hits& hits) {
      EXPECT_LE(chunk.size(), 3u);
      for (const Index pair : chunk) hits.crossings.push_back({0, pair, 0, 0});
    };
    in_chunks(std::span<const Index>(pairs), 3, scratch, test, [&](const Hits& hits) {
      for (const TriangleCrossing& hit : hits.crossings) seen.push_back(hit.triangle_a);
    });
    EXPECT_EQ(seen, pairs) << count;
    EXPECT_LE(scratch.size(), kRound);
  }
}

}  // namespace
}  // namespace foldproof::oracle
