// Long steps are cut in time: the same answer as a single search, which an explanation takes.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>

#include "foldproof/check.h"

namespace foldproof {
namespace {

struct Soup {
  std::vector<Triangle> triangles;
  std::vector<double> x0, x1;
};

// Small triangles that move far; coordinates are multiples of `grid`.
Soup random_soup(std::mt19937_64& rng, double speed, double grid) {
  const double size = std::max(0.04, grid);
  std::uniform_real_distribution<double> unit(0, 1), offset(-size, size), velocity(-speed, speed);
  const auto round = [&](double v) { return std::round(v / grid) * grid; };
  Soup soup;
  for (Index t = 0; t < 150; ++t) {
    const double at[] = {unit(rng), unit(rng), unit(rng)},
                 move[] = {velocity(rng), velocity(rng), velocity(rng)};
    for (int k = 0; k < 9; ++k) {
      soup.x0.push_back(round(at[k % 3] + offset(rng)));
      soup.x1.push_back(round(soup.x0.back() + move[k % 3] + offset(rng)));
    }
    soup.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
  }
  return soup;
}

// The hits of a list by their ids with their times; all ids of it differ.
template <class Collision, class Key>
std::vector<std::pair<Key, double>> hits(const std::vector<Collision>& list, Key (*key)(const Collision&)) {
  std::vector<std::pair<Key, double>> all;
  std::set<Key> keys;
  for (const Collision& c : list) {
    EXPECT_TRUE(keys.insert(key(c)).second) << "listed twice";
    if (c.answer == Answer::Hit) all.emplace_back(key(c), c.toi);
  }
  return all;
}
std::array<Index, 2> key(const VertexFaceCollision& c) { return {c.vertex, c.face}; }
std::array<Edge, 2> key(const EdgeEdgeCollision& c) { return {c.a, c.b}; }

void expect_same_hits(const StepResult& a, const StepResult& b) {
  EXPECT_EQ(hits<VertexFaceCollision>(a.vertex_face, &key), hits<VertexFaceCollision>(b.vertex_face, &key));
  EXPECT_EQ(hits<EdgeEdgeCollision>(a.edge_edge, &key), hits<EdgeEdgeCollision>(b.edge_edge, &key));
  for (const StepResult* result : {&a, &b}) {
    EXPECT_TRUE(result->lists_all());
    std::uint64_t undecided = 0;
    for (const auto& c : result->vertex_face) undecided += c.answer == Answer::Undecided;
    for (const auto& c : result->edge_edge) undecided += c.answer == Answer::Undecided;
    EXPECT_EQ(result->work.undecided, undecided);
  }
  EXPECT_EQ(a.earliest_toi, b.earliest_toi);
}

TEST(Stretches, HaveTheHitsOfASingleSearch) {
  std::uint64_t hits = 0, cut = 0, undecided = 0, fewer = 0;
  for (std::uint64_t seed = 0; seed < 24; ++seed) {
    std::mt19937_64 rng(seed);
    Soup soup = random_soup(rng, seed % 3 == 0 ? 0.3 : 4, seed % 2 == 0 ? 0x1p-40 : 0x1p-3);
    if (seed % 3 == 1) {  // needles
      for (std::size_t i = 0; i < soup.x0.size(); ++i) {
        if (i % 3 == 0) continue;
        soup.x0[i] *= 1e-7;
        soup.x1[i] *= 1e-7;
      }
    }
    const auto topology = Topology::make(static_cast<Index>(soup.x0.size() / 3), soup.triangles).value();
    const Object object(Hierarchy::build(topology, soup.x0).value());
    StepChecker checker({object}), single({object});
    StepSettings settings;
    settings.thickness = seed % 4 < 2 ? 0 : seed % 3 == 1 ? 1e-9 : 0.01;
    settings.tolerance = 1e-300;
    for (int repeat = 0; repeat < 2; ++repeat) {
      StepResult in_stretches, at_once;
      settings.explain = false;
      ASSERT_TRUE(checker.check(soup.x0, soup.x1, settings, in_stretches));
      settings.explain = true;
      ASSERT_TRUE(single.check(soup.x0, soup.x1, settings, at_once));
      ASSERT_EQ(at_once.work.refits, 1u);
      ASSERT_NO_FATAL_FAILURE(expect_same_hits(in_stretches, at_once)) << seed;
      cut += in_stretches.work.refits > 3;
      hits += in_stretches.count();
      undecided += in_stretches.work.undecided;
      fewer +=
          in_stretches.work.leaf_pairs > 0 && in_stretches.work.candidates_ee < at_once.work.candidates_ee;
    }
  }
  EXPECT_GT(cut, 20u);
  EXPECT_GT(hits, 5000u);
  EXPECT_GT(undecided, 0u);
  EXPECT_GT(fewer, 10u);
}

// What all vertices share is no motion, however many pairs are within the thickness: it cannot be cut.
TEST(Stretches, EndWhereEverythingMovesTogetherAndAllPairsAreClose) {
  std::mt19937_64 rng(1);
  Soup soup = random_soup(rng, 0, 0x1p-10);
  for (std::size_t i = 0; i < soup.x0.size(); ++i) soup.x1[i] = soup.x0[i] + 64;
  const auto topology = Topology::make(static_cast<Index>(soup.x0.size() / 3), soup.triangles).value();
  StepChecker checker({Object(Hierarchy::build(topology, soup.x0).value())});
  for (const bool earliest_only : {false, true}) {
    StepSettings settings;
    settings.thickness = 10;
    settings.earliest_only = earliest_only;
    StepResult result;
    ASSERT_TRUE(checker.check(soup.x0, soup.x1, settings, result));
    EXPECT_EQ(result.earliest_toi, 0);
    EXPECT_EQ(result.work.refits, 2u);  // the whole step, then without the common motion
    EXPECT_EQ(result.vertex_face_count, earliest_only ? 1 : 150u * 149 * 3);
  }
}

}  // namespace
}  // namespace foldproof
