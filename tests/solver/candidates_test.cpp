// Candidates: complete, of the right kinds, and none that the filter excludes.

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <thread>

#include "base/callers.h"
#include "base/rounds.h"
#include "oracle/one_target.h"
#include "soups.h"

namespace foldproof::oracle {
namespace {

using Keys = std::set<std::pair<Features, std::array<Index, 2>>>;

ContactChecker checker_of(const Soup& soup, CollisionFilter filter = {}, Index leaf_triangles = 4) {
  return ContactChecker(
      std::make_shared<const CollisionMesh>(mesh_of(soup, std::move(filter), leaf_triangles)));
}

// Whether the exact distance is <= inflation at the ends or at some times in between.
bool sampled_within(const FeaturePair& pair, const Soup& soup, double inflation) {
  for (const double t : {0.0, 0.13, 0.5, 0.77, 1.0}) {
    if (within_distance(pair.kind(), pair.at(soup.x0), pair.at(soup.x1), t, Rational(inflation))) return true;
  }
  return false;
}

void expect_complete(const Candidates& found, std::span<const FeaturePair> pairs, const Soup& soup,
                     double inflation, int& within) {
  const Keys keys = keys_of(found);
  ASSERT_EQ(keys.size(), found.size()) << "a pair twice";
  Keys all;
  for (const FeaturePair& pair : pairs) {
    all.insert(pair.key());
    if (keys.contains(pair.key())) continue;
    ASSERT_FALSE(sampled_within(pair, soup, inflation)) << pair.ids[0] << ' ' << pair.ids[1];
    ASSERT_NE(approach(pair.kind(), pair.at(soup.x0), pair.at(soup.x1), inflation, 1e-4), Approach::Within);
  }
  for (const auto& key : keys) ASSERT_TRUE(all.contains(key)) << "not a relevant pair";
  for (const FeaturePair& pair : pairs)
    within += keys.contains(pair.key()) && sampled_within(pair, soup, inflation);
}

TEST(Candidates, AreComplete) {
  int within = 0;
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    Rng rng(seed);
    const Soup soup = random_soup(rng, 4, 6, 6, seed % 2 == 0 ? 0.2 : 0, seed % 3 == 0 ? 0x1p-4 : 0x1p-40);
    const auto can = [](Index i, Index j) { return (i ^ j) % 3 != 0; };
    for (const bool filtered : {false, true}) {
      ContactChecker checker = checker_of(soup, filtered ? CollisionFilter(can) : CollisionFilter());
      const auto edges = checker.mesh().edges();
      const auto pairs = filtered ? all_pairs(soup, edges, can) : all_pairs(soup, edges, all_may);
      Candidates found;
      for (const double inflation : {0.0, 0.05, 0.3}) {
        ASSERT_TRUE(checker.candidates(soup.x0, soup.x1, inflation, found));
        expect_complete(found, pairs, soup, inflation, within);
        if (HasFatalFailure()) return;
      }
      Soup still = soup;
      still.x1 = still.x0;
      ASSERT_TRUE(checker.candidates(soup.x0, 0.05, found));
      expect_complete(found, pairs, still, 0.05, within);
      if (HasFatalFailure()) return;
    }
  }
  EXPECT_GT(within, 300);
}

// A sheet that waves a little, with rods and points above it: charts prove most of it.
Soup waving_sheet(int n, double phase) {
  Soup soup;
  const auto add = [&](double x, double y, double z) { soup.x0.insert(soup.x0.end(), {x, y, z}); };
  const auto height = [&](double x, double y) { return 0.1 * std::sin(3 * x + phase) * std::cos(2 * y); };
  for (int i = 0; i < n; ++i) {
    for (int k = 0; k < n; ++k) {
      const double x = double(i) / n, y = double(k) / n;
      add(x, y, height(x, y));
      if (i == 0 || k == 0) continue;
      const auto v = static_cast<Index>(i * n + k), w = static_cast<Index>(n);
      soup.faces.push_back({v - w - 1, v - 1, v - w});
      soup.faces.push_back({v - 1, v, v - w});
    }
  }
  for (int i = 0; i + 1 < n; i += 2) {
    const auto v = soup.vertex_count();
    const double x = double(i) / n;
    add(x, 0.3, height(x, 0.3) + 0.02);
    add(x + 0.1, 0.35, height(x + 0.1, 0.35) + 0.02);
    soup.edges.push_back({v, v + 1});
    add(x, 0.6, height(x, 0.6) + 0.02);
  }
  return soup;
}

// Moves vertices such that all lists, some, or none stay complete.
void move(Rng& rng, std::vector<double>& x, double grid) {
  std::uniform_real_distribution<double> unit(-1, 1);
  const auto round = [&](double v) { return std::round(v / grid) * grid; };
  const double distance = std::ldexp(unit(rng), static_cast<int>(rng() % 6) - 6);
  switch (rng() % 8) {
    case 0:  // nothing
      break;
    case 1: {  // all together, sometimes so far that rounding destroys the shape
      const double shift = rng() % 4 == 0 ? 0x1p53 : round(distance * 100);
      for (double& v : x) v += shift;
      break;
    }
    case 2: {  // one vertex
      const std::size_t v = rng() % (x.size() / 3);
      for (std::size_t axis = 0; axis < 3; ++axis) x[3 * v + axis] += round(distance);
      break;
    }
    case 3:  // new positions
      for (double& v : x) v = round((unit(rng) + 1) / 2);
      break;
    case 4:  // flatter
      for (std::size_t i = 2; i < x.size(); i += 3) x[i] = round(x[i] * 0.75);
      break;
    default:  // a small rotation
      for (std::size_t i = 0; i + 2 < x.size(); i += 3) {
        const double angle = distance / 16, u = x[i], v = x[i + 1];
        x[i] = round(u - angle * v);
        x[i + 1] = round(v + angle * u);
      }
  }
}

// Many calls of the same checker, against the boxes of all pairs.
TEST(Candidates, AreThePairsWithCloseBoxesWhateverTheEarlierCalls) {
  std::size_t listed = 0, not_listed = 0;
  for (int seed = 0; seed < testing::rounds(24); ++seed) {
    Rng rng(seed);
    const double grid = seed % 2 == 0 ? 0x1p-5 : 0x1p-30;
    const int faces = seed % 6 == 0 ? 50 : 9;
    Soup soup = random_soup(rng, faces, 5, 5, 0.1, grid);
    ContactChecker checker = checker_of(soup, {}, 2);
    const auto pairs = all_pairs(soup, checker.mesh().edges(), all_may);
    Candidates found;
    for (int call = 0; call < 60; ++call) {
      move(rng, soup.x0, grid);
      if (call % 16 == 0) soup.x0 = random_soup(rng, faces, 5, 5, 0.1, grid).x0;
      if (rng() % 2 == 0) soup.x1 = soup.x0;
      move(rng, soup.x1, grid);
      const double inflations[] = {0, grid, 0.0625, 0.0625, 0.0625, 0.25, 1, 0x1p-1074};
      const double inflation = inflations[rng() % std::size(inflations)];
      const bool pose = rng() % 2 == 0;
      const auto& end = pose ? soup.x0 : soup.x1;
      if (rng() % 4 == 0) {
        EXPECT_TRUE(checker.minimum_distance(soup.x1, 0.01));
      }
      ASSERT_TRUE(checker.candidates(soup.x0, end, inflation, found));
      ASSERT_EQ(keys_of(found).size(), found.size()) << "a pair twice";
      Keys expected;
      for (const FeaturePair& pair : pairs) {
        if (boxes_within(pair, soup.x0, end, inflation)) expected.insert(pair.key());
      }
      ASSERT_EQ(keys_of(found), expected)
          << "seed " << seed << ", call " << call << ", inflation " << inflation;
      listed += expected.size();
      not_listed += pairs.size() - expected.size();
    }
  }
  EXPECT_GT(listed, 10000);
  EXPECT_GT(not_listed, 10000);
}

TEST(Candidates, AreTheSameOnEveryInstructionSet) {
  Soup soup = waving_sheet(14, 0);
  soup.x1 = waving_sheet(14, 0.4).x0;
  for (const bool pose : {true, false}) {
    const auto answer = [&] {
      Candidates found;
      EXPECT_TRUE(checker_of(soup).candidates(soup.x0, pose ? soup.x0 : soup.x1, 0.03, found));
      return found;
    };
    const Candidates expected = answer();
    EXPECT_GT(expected.vertex_face.size(), 100);
    EXPECT_GT(expected.edge_edge.size(), 100);
    testing::on_each_target([&] {
      const Candidates found = answer();
      EXPECT_EQ(found.vertex_face, expected.vertex_face);
      EXPECT_EQ(found.edge_edge, expected.edge_edge);
      EXPECT_EQ(found.edge_vertex, expected.edge_vertex);
      EXPECT_EQ(found.vertex_vertex, expected.vertex_vertex);
    });
  }
}

TEST(Candidates, ListsAreRebuiltOnlyWhereTheShapeChanged) {
  constexpr int kSize = 40;
  constexpr double kInflation = 0.01;
  std::vector<double> x = waving_sheet(kSize, 0).x0;
  ContactChecker checker = checker_of(waving_sheet(kSize, 0));
  Candidates found;
  const auto lists_built = [&] {
    EXPECT_TRUE(checker.candidates(x, kInflation, found));
    return checker.work().leaf_pairs;
  };
  const std::uint64_t all = lists_built();
  EXPECT_GT(all, 1000);
  EXPECT_EQ(lists_built(), 0);
  for (std::size_t i = 0; i < x.size(); i += 3) x[i] += 0.25;  // a translation without rounding
  EXPECT_LT(lists_built(), all / 20);
  x[0] += 0.5;
  EXPECT_LT(lists_built(), all / 20);
  std::uint64_t built = 0;
  for (int step = 1; step <= 20; ++step) {
    x = waving_sheet(kSize, 0.002 * step).x0;
    for (std::size_t i = 0; i < x.size(); i += 3) x[i] += 0.25;
    built += lists_built();
  }
  EXPECT_LT(built, 20 * all / 4);
}

// A thread that waits for a loop of the user's filter must not take up another block of lists meanwhile.
TEST(Candidates, AFilterMayStartLoops) {
  const Soup sheet = waving_sheet(50, 0);
  std::atomic<int> calls = 0;
  // Iterations sleep, so that however busy the machine is, others take them and this thread waits.
  const CollisionFilter loops([&](Index, Index) {
    if (++calls % 2048 == 0)
      parallel_for(0, 8, [](int) { std::this_thread::sleep_for(std::chrono::microseconds(200)); });
    return true;
  });
  const auto found_in_arena = [&](const CollisionFilter& filter) {
    ContactChecker checker = checker_of(sheet, filter);
    Candidates found;
    with_threads(8, [&] { EXPECT_TRUE(checker.candidates(sheet.x0, 0.1, found)); });
    return found.size();
  };
  const std::size_t expected = found_in_arena(CollisionFilter([](Index, Index) { return true; }));
  for (int repetition = 0; repetition < 3; ++repetition) EXPECT_EQ(found_in_arena(loops), expected);
}

// A thread that waits in a call must not take up another iteration of the user's loop, which calls the same
// checker. One loop shows it by chance (26 of 30), a dozen always (210 of 210): idle threads, which make
// others wait, are there when a loop starts.
TEST(Candidates, IterationsOfALoopMayShareTheCheckerOfTheirThread) {
  const Soup sheet = waving_sheet(30, 0);
  const CollisionFilter sleeps([calls = std::make_shared<std::atomic<int>>(0)](Index, Index) {
    if (++*calls % 512 == 0) std::this_thread::sleep_for(std::chrono::microseconds(200));
    return true;
  });
  PerThread<ContactChecker> checkers([&] { return checker_of(sheet, sleeps); });
  PerThread<int> calls([] { return 0; });
  std::atomic<int> nested = 0;
  const auto ask = [&](int i) {
    int& mine = calls.local();
    nested += mine++ > 0;
    ContactChecker& checker = checkers.local();
    const std::vector<double> x0 = waving_sheet(30, 0.002 * i).x0,
                              x1 = waving_sheet(30, 0.002 * i + 0.001).x0;
    Candidates found;
    EXPECT_TRUE(checker.candidates(x0, x1, 0.1, found));
    EXPECT_TRUE(checker.minimum_distance(x0, 0.1));
    --mine;
  };
  for (int loop = 0; loop < testing::rounds(12); ++loop) with_threads(8, [&] { parallel_for(0, 16, ask); });
  EXPECT_EQ(nested, 0);
}

TEST(Candidates, ACancelledLoopOfTheCallerHidesNone) {
  Soup sheets = waving_sheet(20, 0);
  const std::vector<double> lower = sheets.x0;
  const Index count = sheets.vertex_count();
  for (std::size_t k = 0, faces = sheets.faces.size(); k < faces; ++k) {
    const Triangle t = sheets.faces[k];
    sheets.faces.push_back({t[0] + count, t[1] + count, t[2] + count});
  }
  const auto at_distance = [&](double z) {
    std::vector<double> x = lower;
    x.insert(x.end(), lower.begin(), lower.end());
    for (std::size_t i = lower.size() + 2; i < x.size(); i += 3) x[i] += z;
    return x;
  };
  const std::vector<double> near = at_distance(0.01), far = at_distance(5);
  sheets.x0 = sheets.x1 = far;
  ContactChecker kept = checker_of(sheets), fresh = checker_of(sheets);
  Candidates found, expected;
  ASSERT_TRUE(fresh.candidates(near, 0.1, expected));
  ASSERT_TRUE(kept.candidates(near, 0.1, found));
  ASSERT_TRUE(kept.candidates(far, 0.1, found));
  in_cancelled_loop([&] {
    EXPECT_TRUE(kept.candidates(far, 0.1, found));
    EXPECT_FALSE(kept.is_step_collision_free(far, at_distance(-5)).is_yes());
  });
  ASSERT_TRUE(kept.candidates(near, 0.1, found));
  EXPECT_GT(expected.size(), 1000u);
  EXPECT_EQ(found.size(), expected.size());
}

TEST(Candidates, FilterExcludesExactlyThePairsItSays) {
  Rng rng(7);
  const Soup soup = random_soup(rng, 30, 20, 20, 0.1, 0x1p-40);
  std::vector<Index> group(soup.vertex_count());
  for (Index v = 0; v < group.size(); ++v) group[v] = (v / 5) % 4;
  const std::vector<std::array<Index, 2>> excluded = {{0, 0}, {2, 1}, {3, 3}};
  const auto can = [&](Index i, Index j) {
    const auto [a, b] = std::minmax(group[i], group[j]);
    return !(a == b && (a == 0 || a == 3)) && !(a == 1 && b == 2);
  };
  ContactChecker any = checker_of(soup);
  Candidates found;
  ASSERT_TRUE(any.candidates(soup.x0, soup.x1, 0.1, found));
  const Keys all = keys_of(found);
  const auto expected_of = [&](auto may) {
    Keys expected;
    for (const FeaturePair& pair : all_pairs(soup, any.mesh().edges(), may)) {
      if (all.contains(pair.key())) expected.insert(pair.key());
    }
    return expected;
  };
  const auto patch = [&](Index i, Index j) { return group[i] != group[j]; };
  const std::pair<CollisionFilter, Keys> cases[] = {
      {CollisionFilter::groups(group, excluded).value(), expected_of(can)},
      {CollisionFilter(can), expected_of(can)},
      {CollisionFilter::patches(group).value(), expected_of(patch)},
      {CollisionFilter([](Index, Index) { return false; }), {}}};
  for (const auto& [filter, expected] : cases) {
    ContactChecker checker = checker_of(soup, filter);
    ASSERT_TRUE(checker.candidates(soup.x0, soup.x1, 0.1, found));
    EXPECT_EQ(keys_of(found), expected);
    EXPECT_LT(expected.size(), all.size());
  }
}

TEST(CollisionMesh, KeepsTheUsersEdgesAndAppendsThoseOfFaces) {
  const std::vector<double> x(3 * 9, 0.5);
  const auto mesh = CollisionMesh::make(x, {{7, 2}, {2, 1}, {5, 7}}, {{0, 1, 2}, {1, 3, 2}}).value();
  const std::vector<Edge> expected = {{7, 2}, {2, 1}, {5, 7}, {0, 1}, {0, 2}, {1, 3}, {2, 3}};
  EXPECT_EQ(std::vector<Edge>(mesh.edges().begin(), mesh.edges().end()), expected);
  EXPECT_EQ(std::vector<Index>(mesh.codim_edges().begin(), mesh.codim_edges().end()),
            (std::vector<Index>{0, 2}));
  EXPECT_EQ(std::vector<Index>(mesh.codim_points().begin(), mesh.codim_points().end()),
            (std::vector<Index>{4, 6, 8}));
  EXPECT_EQ(mesh.faces().size(), 2);
  for (std::size_t e = 0; e < mesh.edges().size(); ++e) {
    const Edge& edge = mesh.hierarchy()->topology().edges()[e];
    const Edge& row = mesh.edges()[mesh.edge_row(static_cast<Index>(e))];
    EXPECT_EQ(edge, (Edge{std::min(row[0], row[1]), std::max(row[0], row[1])}));
  }
  CollisionMeshSettings inside;
  inside.points = false;
  EXPECT_TRUE(CollisionMesh::make(x, {}, {{0, 1, 2}}, inside).value().codim_points().empty());
  EXPECT_EQ(CollisionMesh::make(x, {}, {}).value().codim_points().size(), 9);
}

TEST(CollisionMesh, RefusesInvalidInput) {
  const std::vector<double> x(9, 0.5);
  const auto problem = [&](std::vector<Edge> edges, std::vector<Triangle> faces,
                           CollisionMeshSettings s = {}) {
    const auto mesh = CollisionMesh::make(x, std::move(edges), std::move(faces), s);
    return mesh ? std::string() : mesh.error().line();
  };
  EXPECT_EQ(problem({{0, 3}}, {}),
            "edge 0: names vertex 3, but there are 3 (counting from 0); correct the edge matrix");
  EXPECT_EQ(problem({{0, 1}, {2, 2}}, {}),
            "edge 1: goes from vertex 2 to itself; leave it out; a vertex in no edge and no face is a point");
  EXPECT_EQ(problem({{0, 1}, {1, 2}, {1, 0}}, {}), "edge 2: is the same as edge 0; give every edge once");
  EXPECT_NE(problem({}, {{0, 1, 4}}), "");
  CollisionMeshSettings none;
  none.points = false;
  EXPECT_NE(problem({}, {}, none), "");
  CollisionMeshSettings other;
  other.filter = CollisionFilter::patches({0, 1}).value();
  EXPECT_EQ(problem({{0, 1}}, {}, other), "filter: is for 2 vertices; give a group for each of the 3");
  EXPECT_FALSE(CollisionFilter::groups({0, 1}, std::vector<std::array<Index, 2>>{{0, 2}}));
  EXPECT_FALSE(CollisionFilter::patches({0, 20000}));
  EXPECT_FALSE(CollisionMesh::make(std::vector<double>(8), {}, {}));
  EXPECT_FALSE(CollisionMesh::make(std::vector<double>(9, std::nan("")), {}, {}));
}

}  // namespace
}  // namespace foldproof::oracle
