// Candidates: complete, of the right kinds, and none that the filter forbids.

#include <gtest/gtest.h>

#include <cmath>

#include "soups.h"

namespace foldproof::oracle {
namespace {

using Keys = std::set<std::pair<Features, std::array<Index, 2>>>;

ContactChecker checker_of(const Soup& soup, CollisionFilter filter, bool certificates) {
  ContactSettings settings;
  settings.certify_candidates = certificates;
  return ContactChecker(std::make_shared<const CollisionMesh>(mesh_of(soup, std::move(filter))), settings);
}

// Nearer than `inflation` at the ends or at times in between, by exact distances.
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
  ASSERT_TRUE(std::is_sorted(found.vertex_face.begin(), found.vertex_face.end()));
  ASSERT_TRUE(std::is_sorted(found.edge_edge.begin(), found.edge_edge.end()));
  Keys all;
  for (const FeaturePair& pair : pairs) {
    all.insert(pair.key());
    if (keys.contains(pair.key())) continue;
    ASSERT_FALSE(sampled_within(pair, soup, inflation)) << pair.ids[0] << ' ' << pair.ids[1];
    ASSERT_NE(approach(pair.kind(), pair.at(soup.x0), pair.at(soup.x1), inflation, 1e-4), Approach::Within);
  }
  for (const auto& key : keys) ASSERT_TRUE(all.contains(key)) << "no pair that counts";
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
      ContactChecker checker = checker_of(soup, filtered ? CollisionFilter(can) : CollisionFilter(), true);
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

// A sheet with rods and points above it that waves a little: charts prove most of it.
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

TEST(Candidates, AreCompleteWithCertificates) {
  constexpr int kSize = 14;
  constexpr double kInflation = 0.03;
  Soup soup = waving_sheet(kSize, 0);
  ContactChecker with = checker_of(soup, {}, true), without = checker_of(soup, {}, false);
  const auto pairs = all_pairs(soup, with.mesh().edges(), all_may);
  CcdSettings ccd;
  ccd.thickness = kInflation;
  std::uint64_t passes = 0;
  std::size_t fewer = 0, all = 0;
  Candidates some, more;
  for (int step = 1; step <= 10; ++step) {
    soup.x1 = waving_sheet(kSize, 0.1 * step).x0;
    ASSERT_TRUE(with.candidates(soup.x0, soup.x1, kInflation, some));
    ASSERT_TRUE(without.candidates(soup.x0, soup.x1, kInflation, more));
    passes += with.work().certificate_passes;
    const Keys keys = keys_of(some), all_keys = keys_of(more);
    EXPECT_TRUE(std::includes(all_keys.begin(), all_keys.end(), keys.begin(), keys.end()));
    for (const FeaturePair& pair : pairs) {
      if (keys.contains(pair.key())) continue;
      const auto test = pair.kind() == Kind::EdgeEdge ? edge_edge_ccd : vertex_face_ccd;
      const CcdResult r = test(pair.at(soup.x0), pair.at(soup.x1), ccd);
      ASSERT_TRUE(r.answer == Answer::Separated || !sampled_within(pair, soup, kInflation));
    }
    fewer += keys.size();
    all += all_keys.size();
    soup.x0 = soup.x1;
  }
  EXPECT_GT(passes, 100);
  EXPECT_LT(fewer, all);
}

TEST(Candidates, FilterLeavesOutExactlyWhatItForbids) {
  Rng rng(7);
  const Soup soup = random_soup(rng, 30, 20, 20, 0.1, 0x1p-40);
  std::vector<Index> group(soup.vertex_count());
  for (Index v = 0; v < group.size(); ++v) group[v] = (v / 5) % 4;
  const std::vector<std::array<Index, 2>> apart = {{0, 0}, {2, 1}, {3, 3}};
  const auto can = [&](Index i, Index j) {
    const auto [a, b] = std::minmax(group[i], group[j]);
    return !(a == b && (a == 0 || a == 3)) && !(a == 1 && b == 2);
  };
  ContactChecker any = checker_of(soup, {}, false);
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
      {CollisionFilter::groups(group, apart).value(), expected_of(can)},
      {CollisionFilter(can), expected_of(can)},
      {CollisionFilter::patches(group).value(), expected_of(patch)},
      {CollisionFilter([](Index, Index) { return false; }), {}}};
  for (const auto& [filter, expected] : cases) {
    ContactChecker checker = checker_of(soup, filter, false);
    ASSERT_TRUE(checker.candidates(soup.x0, soup.x1, 0.1, found));
    EXPECT_EQ(keys_of(found), expected);
    EXPECT_LT(expected.size(), all.size());
  }
}

TEST(CollisionMesh, KeepsTheUsersEdgesAndAddsThoseOfFaces) {
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
    const Edge& row = mesh.edges()[mesh.edge_of(static_cast<Index>(e))];
    EXPECT_EQ(edge, (Edge{std::min(row[0], row[1]), std::max(row[0], row[1])}));
  }
  CollisionMeshSettings inside;
  inside.points = false;
  EXPECT_TRUE(CollisionMesh::make(x, {}, {{0, 1, 2}}, inside).value().codim_points().empty());
  EXPECT_EQ(CollisionMesh::make(x, {}, {}).value().codim_points().size(), 9);
}

TEST(CollisionMesh, SaysWhatIsWrong) {
  const std::vector<double> x(9, 0.5);
  const auto problem = [&](std::vector<Edge> edges, std::vector<Triangle> faces,
                           CollisionMeshSettings s = {}) {
    const auto mesh = CollisionMesh::make(x, std::move(edges), std::move(faces), s);
    return mesh ? std::string() : mesh.error().line();
  };
  EXPECT_EQ(problem({{0, 3}}, {}),
            "edge 0: names vertex 3, but there are 3 (counting from 0); mend the edge matrix");
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
