// Step sizes and intersections against exact arithmetic and brute force.

#include <gtest/gtest.h>

#include <cstdlib>
#include <type_traits>

#include "base/callers.h"
#include "soups.h"

namespace foldproof::oracle {
namespace {

constexpr double kTolerance = 1e-7;

// More rounds for a longer run by hand.
int rounds(int usual) {
  const char* factor = std::getenv("FOLDPROOF_ROUNDS");
  return factor == nullptr ? usual : usual * std::max(1, static_cast<int>(std::strtol(factor, nullptr, 10)));
}

ContactChecker checker_of(const Soup& soup, CollisionFilter filter = {}, bool certificates = true) {
  ContactSettings settings;
  settings.tolerance = kTolerance;
  settings.certificates = certificates;
  return ContactChecker(std::make_shared<const CollisionMesh>(mesh_of(soup, std::move(filter))), settings);
}

bool exact_contact(const FeaturePair& pair, std::span<const double> x0, std::span<const double> x1,
                   double distance) {
  if (distance == 0) return touches(pair.kind(), pair.at(x0), pair.at(x1));
  return approach(pair.kind(), pair.at(x0), pair.at(x1), distance, 1e-12) == Approach::Within;
}

// The earliest contact, from the narrow phase of every pair.
double brute_contact(std::span<const FeaturePair> pairs, const Soup& soup, double distance) {
  CcdSettings ccd;
  ccd.thickness = distance;
  ccd.tolerance = kTolerance;
  double earliest = 2;
  for (const FeaturePair& pair : pairs) {
    const auto test = pair.kind() == Kind::EdgeEdge ? edge_edge_ccd : vertex_face_ccd;
    const CcdResult r = test(pair.at(soup.x0), pair.at(soup.x1), ccd);
    if (r.answer != Answer::Separated) earliest = std::min(earliest, r.toi);
  }
  return earliest;
}

// Otherwise an `if` would take a no for a yes.
static_assert(!std::is_constructible_v<bool, Verdict>);

struct Counts {
  int whole = 0, part = 0, none = 0;
};

// It names a pair that collides at that time, and its closest points then.
void expect_limit(const Soup& soup, std::span<const FeaturePair> pairs, const StepSize& size, double time,
                  double distance) {
  ASSERT_EQ(size.contact_time, time);
  const ClosePair& contact = size.contact;
  const auto is_of = [&](const FeaturePair& pair) {
    return std::ranges::all_of(contact.vertices, [&](Index v) {
      return std::ranges::find(pair.vertices, v) != pair.vertices.end();
    });
  };
  ASSERT_TRUE(std::ranges::any_of(pairs, [&](const FeaturePair& pair) {
    const auto test = pair.kind() == Kind::EdgeEdge ? edge_edge_ccd : vertex_face_ccd;
    return is_of(pair) && test(pair.at(soup.x0), pair.at(soup.x1), {distance, kTolerance}).toi == time;
  }));
  EXPECT_LE(contact.distance, distance + 2 * kTolerance);
  Vec3 difference;
  for (int k = 0; k < 4; ++k) {
    const Vec3 from = Vec3::load(&soup.x0[3 * std::size_t{contact.vertices[k]}]);
    const Vec3 to = Vec3::load(&soup.x1[3 * std::size_t{contact.vertices[k]}]);
    difference += contact.weights[k] * (from + time * (to - from));
  }
  EXPECT_LT((difference - contact.distance * contact.normal).norm(), 1e-12);
  EXPECT_NEAR(contact.normal.norm(), 1, 1e-12);
}

void test_step_sizes(std::uint64_t seed, double distance, double grid, Counts& counts) {
  Rng rng(seed);
  const int few = static_cast<int>(rng() % 4);
  const Soup soup = random_soup(rng, 3 * (few & 1), 3 + 2 * few, 3 + few, 0.25, grid);
  ContactChecker checker = checker_of(soup);
  const auto pairs = all_pairs(soup, checker.mesh().edges(), all_may);
  const double brute = brute_contact(pairs, soup, distance);
  const StepSize size = checker.collision_free_step_size(soup.x0, soup.x1, distance).value();
  const double share = size.share;
  const StepSize::Limit limit = size.limit;
  if (brute <= 1) {
    ASSERT_NO_FATAL_FAILURE(expect_limit(soup, pairs, size, brute, distance)) << seed;
  }
  ASSERT_EQ(limit == StepSize::Limit::None, brute > 1) << seed;
  ASSERT_EQ(limit == StepSize::Limit::Start, brute == 0) << seed;
  ASSERT_EQ(limit == StepSize::Limit::Contact, brute > 0 && brute <= 1) << seed;
  ASSERT_GE(share, 0);
  ASSERT_LE(share, 1);
  ASSERT_EQ(share == 1, brute > 1) << seed;
  ASSERT_EQ(share == 0, brute == 0) << seed;
  if (brute <= 1) {
    ASSERT_LE(share, 0.8 * brute) << seed;
  }
  ASSERT_EQ(checker.is_step_collision_free(soup.x0, soup.x1, distance).is_yes(), brute > 1) << seed;
  ++(share == 1 ? counts.whole : share == 0 ? counts.none : counts.part);
  std::vector<double> end(soup.x0.size());
  step_towards(soup.x0, soup.x1, share, end);
  if (share > 0) {
    ASSERT_TRUE(checker.is_step_collision_free(soup.x0, end, distance).is_yes()) << seed;
    for (const FeaturePair& pair : pairs) ASSERT_FALSE(exact_contact(pair, soup.x0, end, distance)) << seed;
  }
  if (share == 1) return;
  // With good reason: something comes within the tolerance of contact.
  bool near = false;
  for (const FeaturePair& pair : pairs)
    near = near || exact_contact(pair, soup.x0, soup.x1, distance + kTolerance);
  ASSERT_TRUE(near) << seed;
}

TEST(ContactChecker, NeverStepsIntoContact) {
  Counts counts;
  for (int seed = 0; seed < rounds(70); ++seed) {
    test_step_sizes(static_cast<std::uint64_t>(seed), 0, 0x1p-40, counts);
    if (HasFatalFailure()) return;
  }
  EXPECT_GT(counts.whole, 10);
  EXPECT_GT(counts.part, 10);
}

TEST(ContactChecker, NeverStepsIntoExactContactOnAGrid) {
  Counts counts;
  for (int seed = 0; seed < rounds(200); ++seed) {
    test_step_sizes(1000000 + static_cast<std::uint64_t>(seed), 0, 0x1p-4, counts);
    if (HasFatalFailure()) return;
  }
  EXPECT_GT(counts.part, 10);
  EXPECT_GT(counts.none, 2);  // elements that start on the same grid point
}

TEST(ContactChecker, KeepsTheMinimumDistance) {
  Counts counts;
  for (int seed = 0; seed < rounds(80); ++seed) {
    test_step_sizes(2000000 + static_cast<std::uint64_t>(seed), 0.03, 0x1p-40, counts);
    if (HasFatalFailure()) return;
  }
  EXPECT_GT(counts.whole, 5);
  EXPECT_GT(counts.part, 5);
  EXPECT_GT(counts.none, 1);
}

// Each pair of codimensional elements alone; half way through the step their distance is 0.1.
TEST(ContactChecker, FindsPointsAndEdgesWithinTheMinimumDistance) {
  const std::vector<double> still = {-1, 0, 0, 1, 0, 0};
  for (const bool edge : {true, false}) {
    std::vector<double> x0 = still, x1 = still;
    if (!edge) x0 = x1 = {0, 0, 0};
    for (const double z : {2.0, -2.0}) (z > 0 ? x0 : x1).insert((z > 0 ? x0 : x1).end(), {0, 0.1, z});
    Soup soup;
    soup.x0 = x0;
    soup.x1 = x1;
    if (edge) soup.edges = {{0, 1}};
    ContactChecker checker = checker_of(soup);
    EXPECT_EQ(checker.collision_free_step_size(x0, x1, 0).value().share, 1);
    EXPECT_EQ(checker.collision_free_step_size(x0, x1, 0.0999).value().share, 1);
    EXPECT_NEAR(checker.collision_free_step_size(x0, x1, 0.1001).value().share, 0.4, 0.01);
    EXPECT_TRUE(checker.is_step_collision_free(x0, x1, 0.0999).is_yes());
    EXPECT_TRUE(checker.is_step_collision_free(x0, x1, 0.1001).is_no());
    EXPECT_EQ(checker.minimum_distance(x0, 1).value(), std::numeric_limits<double>::infinity());
    EXPECT_NEAR(checker.minimum_distance(x0, 3).value(), std::hypot(2, 0.1), 1e-14);
  }
}

// A share of such a bound may be zero.
TEST(ContactChecker, MinimumDistanceTakesTheSmallestBounds) {
  Soup soup;
  soup.x0 = soup.x1 = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 0, 1, 0, 1, 1};
  soup.faces = {{0, 1, 2}, {3, 4, 5}};
  ContactChecker checker = checker_of(soup);
  for (const double bound : {0.0, 0x1p-1074, 1e-322, 0x1p-1022, 1e-300})
    EXPECT_EQ(checker.minimum_distance(soup.x0, bound).value(), std::numeric_limits<double>::infinity());
}

TEST(ContactChecker, StepsAreTheSameWhateverCertificatesAndThreads) {
  int shortened = 0;
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    Rng rng(seed);
    Soup soup = random_soup(rng, 40, 20, 20, 0.1, 0x1p-40);
    ContactChecker with = checker_of(soup), without = checker_of(soup, {}, false);
    for (int step = 0; step < 5; ++step) {
      double a = -1, b = -2;
      with_threads(4, [&] { a = with.collision_free_step_size(soup.x0, soup.x1, 0.001).value().share; });
      with_threads(1, [&] { b = without.collision_free_step_size(soup.x0, soup.x1, 0.001).value().share; });
      EXPECT_EQ(a, b);
      shortened += a > 0 && a < 1;
      for (double& x : soup.x1) x += 1e-3;
    }
  }
  EXPECT_GT(shortened, 5);
}

TEST(ContactChecker, StepsThatStartWhereTheLastOneEndedAreNotStuck) {
  // A point falls on a face again and again.
  const std::vector<double> start = {-1, -1, 0, 1, -1, 0, 0, 1, 0, 0, 0, 1};
  Soup soup;
  soup.faces = {{0, 1, 2}};
  soup.x0 = start;
  ContactChecker checker = checker_of(soup);
  std::vector<double> x = start, to = start;
  to[11] = -1;
  for (int step = 0; step < 8; ++step) {
    const double share = checker.collision_free_step_size(x, to).value().share;
    EXPECT_NEAR(share, 0.8 * x[11] / (x[11] + 1), 1e-6);
    step_towards(x, to, share, x);
    EXPECT_GT(x[11], 0);
    EXPECT_TRUE(checker.has_intersections(x).is_no());
  }
  EXPECT_TRUE(checker.has_intersections(std::vector<double>{-1, -1, 0, 1, -1, 0, 0, 1, 0, 0, 0, 0}).is_yes());
}

std::vector<std::vector<Index>> elements_of(const CollisionMesh& mesh) {
  std::vector<std::vector<Index>> elements;
  for (const Triangle& t : mesh.faces()) elements.push_back({t.begin(), t.end()});
  for (const Index e : mesh.codim_edges())
    elements.push_back({mesh.edges()[e].begin(), mesh.edges()[e].end()});
  for (const Index v : mesh.codim_points()) elements.push_back({v});
  return elements;
}

TEST(ContactChecker, IntersectionsAreExact) {
  int crossing = 0;
  for (int seed = 0; seed < rounds(60); ++seed) {
    Rng rng(3000000 + static_cast<std::uint64_t>(seed));
    // No neighbors: no two elements have a vertex in common.
    Soup soup = random_soup(rng, 3, 2, 3, 0, seed % 2 == 0 ? 0x1p-30 : 0x1p-3);
    std::erase_if(soup.edges, [](const Edge& e) { return e[0] != e[1] + 1; });
    ASSERT_EQ(soup.edges.size(), 2);
    const auto odd = [](Index i, Index j) { return (i + j) % 3 != 1; };
    for (const bool filtered : {false, true}) {
      ContactChecker checker = checker_of(soup, filtered ? CollisionFilter(odd) : CollisionFilter());
      const auto elements = elements_of(checker.mesh());
      bool expected = false;
      for (std::size_t i = 0; i < elements.size(); ++i) {
        for (std::size_t j = i + 1; j < elements.size(); ++j) {
          if (filtered && !may_collide(elements[i], elements[j], odd)) continue;
          std::vector<Vec3> a, b;
          for (const Index v : elements[i]) a.push_back(Vec3::load(&soup.x0[3 * v]));
          for (const Index v : elements[j]) b.push_back(Vec3::load(&soup.x0[3 * v]));
          expected = expected || hulls_intersect(a, b);
        }
      }
      EXPECT_EQ(checker.has_intersections(soup.x0).is_yes(), expected) << seed;
      crossing += expected;
    }
  }
  EXPECT_GT(crossing, 10);
}

TEST(ContactChecker, NeighborsFoldOnFacesAndNotOnRods) {
  Soup fold;  // two triangles folded flat onto each other along their edge
  fold.faces = {{0, 1, 2}, {0, 1, 3}};
  fold.x0 = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0.1, 0.9, 0};
  EXPECT_TRUE(checker_of(fold).has_intersections(fold.x0).is_yes());
  EXPECT_TRUE(
      checker_of(fold, CollisionFilter::patches({0, 0, 0, 0}).value()).has_intersections(fold.x0).is_no());
  Soup twice;  // one triangle as two faces
  twice.faces = {{0, 1, 2}, {2, 1, 0}};
  twice.x0 = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  EXPECT_TRUE(checker_of(twice).has_intersections(twice.x0).is_yes());
  EXPECT_TRUE(
      checker_of(twice, CollisionFilter::patches({0, 0, 0}).value()).has_intersections(twice.x0).is_no());
  Soup rod;  // two edges folded onto each other
  rod.edges = {{0, 1}, {1, 2}};
  rod.x0 = {0, 0, 0, 1, 0, 0, 0.5, 0, 0};
  EXPECT_TRUE(checker_of(rod).has_intersections(rod.x0).is_no());
  EXPECT_TRUE(checker_of(rod).is_step_collision_free(rod.x0, rod.x0).is_yes());
  Soup whisker;  // an edge from a corner of a triangle lies in it
  whisker.faces = {{0, 1, 2}};
  whisker.edges = {{0, 3}};
  whisker.x0 = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0.2, 0.2, 0};
  EXPECT_TRUE(checker_of(whisker).has_intersections(whisker.x0).is_yes());
  EXPECT_TRUE(checker_of(whisker).is_step_collision_free(whisker.x0, whisker.x0).is_no());
}

TEST(ContactChecker, FindsTheMinimumDistance) {
  for (int seed = 0; seed < rounds(40); ++seed) {
    Rng rng(4000000 + static_cast<std::uint64_t>(seed));
    const Soup soup = random_soup(rng, 2, 3, 4, 0, 0x1p-40);
    ContactChecker checker = checker_of(soup);
    Rational smallest = 1000;
    for (const FeaturePair& pair : all_pairs(soup, checker.mesh().edges(), all_may))
      smallest = std::min(smallest, squared_distance(pair.kind(), pair.at(soup.x0), pair.at(soup.x0), 0));
    const double expected = std::sqrt(smallest.convert_to<double>());
    for (const double bound : {5.0, 1e300, std::numeric_limits<double>::infinity()})
      EXPECT_NEAR(checker.minimum_distance(soup.x0, bound).value(), expected, 1e-14) << seed;
    EXPECT_NEAR(checker.minimum_distance(soup.x0, expected * 1.0001).value(), expected, 1e-14) << seed;
    if (expected > 1e-9) {
      EXPECT_EQ(checker.minimum_distance(soup.x0, expected * 0.9999).value(),
                std::numeric_limits<double>::infinity());
    }
  }
}

// By counts of pairs: never many more than candidates() finds with the answer as inflation.
TEST(ContactChecker, MinimumDistanceCostsWhatItsAnswerCosts) {
  const Soup soup = two_sheets();
  std::vector<Index> sheet(soup.vertex_count(), 0);
  std::fill(sheet.begin() + soup.vertex_count() / 2, sheet.end(), 1);
  for (const bool within : {true, false}) {
    ContactChecker checker =
        checker_of(soup, within ? CollisionFilter() : CollisionFilter::patches(sheet).value());
    const double answer = checker.minimum_distance(soup.x0, 1).value();
    EXPECT_NEAR(answer, within ? 0.0177 : 0.188, 0.001);
    Candidates near;
    ASSERT_TRUE(checker.candidates(soup.x0, answer, near));
    EXPECT_LT(near.size(), 5'000'000u);  // of 100 million pairs
    for (const double bound : {answer, 1.0, 1000.0, 1e300, std::numeric_limits<double>::infinity()}) {
      EXPECT_EQ(checker.minimum_distance(soup.x0, bound).value(), answer);
      EXPECT_LT(checker.work().candidates_vf + checker.work().candidates_ee, near.size() + 10000) << bound;
      EXPECT_LT(checker.work().node_tests, 100'000u) << bound;
    }
  }
}

// V2: such a face is a point, but would have the pairs of a face.
TEST(CollisionMesh, RefusesAFaceThatIsAPoint) {
  const std::vector<double> x{0, 0, 1, -1, 0, 0, 1, 0, 0};
  const auto mesh = CollisionMesh::make(x, {{1, 2}}, {{0, 1, 2}, {0, 0, 0}});
  ASSERT_FALSE(mesh);
  EXPECT_EQ(mesh.error().where, "face 1");
  EXPECT_TRUE(CollisionMesh::make(x, {{1, 2}}, {{0, 1, 2}, {0, 0, 1}}));
}

TEST(CollisionMesh, RefusesAFaceOfVerticesThatAreNotThere) {
  const std::vector<double> x{0, 0, 1, -1, 0, 0, 1, 0, 0};
  EXPECT_EQ(CollisionMesh::make(x, {}, {{0, 1, 2}, {0, 1, 3}}).error().line(),
            "face 1: names vertex 3, but there are 3 (counting from 0); correct the face matrix");
}

TEST(ContactChecker, CallsTheMinimumDistanceByItsName) {
  Soup soup;
  soup.faces = {{0, 1, 2}};
  soup.x0 = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  ContactChecker checker = checker_of(soup);
  const std::string line = "min_distance: is not a length; give a number of at least 0";
  EXPECT_EQ(checker.collision_free_step_size(soup.x0, soup.x0, -1).error().line(), line);
  EXPECT_EQ(checker.is_step_collision_free(soup.x0, soup.x0, std::nan("")).result().error().line(), line);
}

// Groups are asked for nodes, a function only for features: the answers are the same, the work is not.
TEST(ContactChecker, GroupsAnswerAsAFunctionDoes) {
  int shortened = 0, intersect = 0;
  std::uint64_t nodes[2] = {0, 0};
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    Rng rng(seed);
    const Soup soup = random_soup(rng, 12, 12, 6, 0.2, seed % 2 == 0 ? 0x1p-20 : 1.0 / 32);
    std::vector<Index> group(soup.vertex_count());
    for (Index v = 0; v < group.size(); ++v)
      group[v] = static_cast<Index>(
          rng() % 4 == 0 ? rng() % 6 : static_cast<std::uint64_t>(3 * std::abs(soup.x0[3 * v])) % 6);
    std::vector<std::array<Index, 2>> excluded;
    for (Index a = 0; a < 6; ++a) {
      for (Index b = a; b < 6; ++b) {
        if (rng() % 3 != 0 && std::ranges::count(group, a) > 0 && std::ranges::count(group, b) > 0)
          excluded.push_back({a, b});
      }
    }
    const auto may = [&](Index i, Index j) {
      return std::ranges::none_of(excluded, [&](const auto& e) {
        return e == std::array{group[i], group[j]} || e == std::array{group[j], group[i]};
      });
    };
    ContactChecker by_group = checker_of(soup, CollisionFilter::groups(group, excluded).value());
    ContactChecker by_function = checker_of(soup, CollisionFilter(may));
    const auto a = by_group.collision_free_step_size(soup.x0, soup.x1).value();
    nodes[0] += by_group.work().node_tests;
    const auto b = by_function.collision_free_step_size(soup.x0, soup.x1).value();
    nodes[1] += by_function.work().node_tests;
    EXPECT_EQ(a.share, b.share) << seed;
    EXPECT_EQ(a.limit, b.limit) << seed;
    EXPECT_EQ(by_group.has_intersections(soup.x0).is_yes(), by_function.has_intersections(soup.x0).is_yes())
        << seed;
    shortened += a.share < 1 && a.share > 0;
    intersect += by_group.has_intersections(soup.x0).is_yes();
  }
  EXPECT_GT(shortened, 3);
  EXPECT_GT(intersect, 3);
  EXPECT_LT(nodes[0], nodes[1]);

  Rng rng(7);
  const Soup soup = random_soup(rng, 30, 0, 0, 0.2, 0x1p-20);
  const std::array<Index, 2> all{0, 0};
  const std::vector<Index> one(soup.vertex_count(), 0);
  ContactChecker none = checker_of(soup, CollisionFilter::groups(one, std::span(&all, 1)).value());
  EXPECT_TRUE(none.is_step_collision_free(soup.x0, soup.x1).is_yes());
  EXPECT_EQ(none.work().node_tests + none.work().leaf_pairs + none.work().candidates_ee, 0u);
}

TEST(ContactChecker, RefusesInvalidInput) {
  Soup soup;
  soup.faces = {{0, 1, 2}};
  soup.x0 = {0, 0, 0, 1, 0, 0, 0, 1, 0, 5, 5, 5};
  ContactChecker checker = checker_of(soup);
  Candidates found;
  for (const double number :
       {std::nan(""), std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()}) {
    for (const std::size_t at : {4, 11}) {  // of the face, and of the point beside it
      auto bad = soup.x0;
      bad[at] = number;
      EXPECT_TRUE(checker.is_step_collision_free(soup.x0, bad).is_error());
      EXPECT_TRUE(checker.is_step_collision_free(bad, soup.x0).is_error());
      EXPECT_FALSE(checker.collision_free_step_size(soup.x0, bad));
      EXPECT_FALSE(checker.collision_free_step_size(bad, soup.x0));
      EXPECT_FALSE(checker.candidates(bad, 1, found));
      EXPECT_FALSE(checker.candidates(soup.x0, bad, 1, found));
      EXPECT_FALSE(checker.minimum_distance(bad, 1));
      EXPECT_TRUE(checker.has_intersections(bad).is_error());
      EXPECT_TRUE(checker.is_step_collision_free(soup.x0, soup.x0).is_yes());
    }
  }
  for (const std::size_t at : {4, 11}) {
    auto from = soup.x0, to = soup.x0;
    from[at] = -1e308;
    to[at] = 1e308;
    const auto share = checker.collision_free_step_size(from, to);
    ASSERT_FALSE(share);
    EXPECT_EQ(share.error().where, at == 4 ? "object 0, vertex 1" : "object 0, vertex 3");
    EXPECT_TRUE(checker.is_step_collision_free(from, to).is_error());
    EXPECT_FALSE(checker.candidates(from, to, 1, found));
    EXPECT_TRUE(checker.candidates(from, 1, found));
  }
  EXPECT_FALSE(checker.collision_free_step_size(std::span(soup.x0).first(3), soup.x0));
  EXPECT_FALSE(checker.collision_free_step_size(soup.x0, soup.x0, -1));
  EXPECT_FALSE(checker.candidates(soup.x0, -1, found));
  EXPECT_FALSE(checker.candidates(soup.x0, std::numeric_limits<double>::infinity(), found));
  EXPECT_FALSE(checker.minimum_distance(soup.x0, std::nan("")));
  EXPECT_EQ(checker.minimum_distance(soup.x0, -1).error().line(),
            "bound: is not a length; give a number of at least 0, or infinity");
  checker.settings().conservative_rescaling = 0;
  const auto refused = checker.collision_free_step_size(soup.x0, soup.x0);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().where, "conservative_rescaling");
}

}  // namespace
}  // namespace foldproof::oracle
