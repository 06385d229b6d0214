// Pairs within a distance: none missing, by exact arithmetic; each once, by what is nearest of it.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>

#include "base/callers.h"
#include "base/rounds.h"
#include "oracle/one_target.h"
#include "soups.h"

namespace foldproof::oracle {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
using Type = ClosePair::Kind;

ContactChecker checker_of(const Soup& soup, CollisionFilter filter = {}) {
  return ContactChecker(std::make_shared<const CollisionMesh>(mesh_of(soup, std::move(filter), 2)));
}

std::vector<ClosePair> close_pairs(ContactChecker& checker, std::span<const double> x, double distance,
                                   std::span<const std::uint8_t> active = {}) {
  std::vector<ClosePair> found;
  EXPECT_TRUE(checker.close_pairs(x, distance, found, active));
  return found;
}

Rational exact_square(Kind kind, const std::array<Index, 4>& vertices, std::span<const double> x) {
  const FourPoints at = FeaturePair{Features::VertexFace, {}, vertices}.at(x);
  return squared_distance(kind, at, at, 0);
}

double rounded_root(const Rational& square) {
  // Without underflow at any scale.
  const int shift =
      square == 0
          ? 0
          : (static_cast<int>(msb(numerator(square))) - static_cast<int>(msb(denominator(square)))) / 2;
  const Rational factor(boost::multiprecision::cpp_int(1) << std::abs(2 * shift));
  return std::ldexp(
      std::sqrt((shift > 0 ? Rational(square / factor) : Rational(square * factor)).convert_to<double>()),
      shift);
}

// The largest difference of coordinates of a pair's points.
double extent(const std::array<Index, 4>& vertices, std::span<const double> x) {
  double largest = 0;
  for (const Index v : vertices) {
    for (const Index w : vertices) {
      for (int axis = 0; axis < 3; ++axis)
        largest = std::max(largest, std::abs(x[3 * v + axis] - x[3 * w + axis]));
    }
  }
  return largest;
}

// The features of a close pair, sorted; its key.
using Key = std::pair<Type, std::array<std::vector<Index>, 2>>;

Key key_of(Type type, std::vector<Index> a, std::vector<Index> b) {
  for (auto* feature : {&a, &b}) {
    std::ranges::sort(*feature);
    feature->erase(std::unique(feature->begin(), feature->end()), feature->end());
  }
  if (a.size() > b.size() || (a.size() == b.size() && b < a)) std::swap(a, b);
  return {type, {a, b}};
}

Key key_of(const ClosePair& pair) {
  const auto& v = pair.vertices;
  if (pair.kind == Type::EdgeEdge) return key_of(pair.kind, {v[0], v[1]}, {v[2], v[3]});
  return key_of(pair.kind, {v[0]}, {v[1], v[2], v[3]});
}

// By the definition: of all vertices, edges and faces of the two features the smallest that are as near as
// the features are. Empty where several pairs are. `square`: of the distance of the features.
std::optional<Key> nearest_features(const FeaturePair& pair, std::span<const double> x,
                                    const Rational& square) {
  const auto& v = pair.vertices;
  std::set<Key> keys;
  const auto consider = [&](Type type, Kind kind, std::array<Index, 4> f, std::size_t first) {
    if (exact_square(kind, f, x) == square)
      keys.insert(key_of(type, {f.begin(), f.begin() + first}, {f.begin() + first, f.end()}));
  };
  const bool edges = pair.kind() == Kind::EdgeEdge;
  const std::vector<Index> a(v.begin(), v.begin() + (edges ? 2 : 1)), b(v.begin() + (edges ? 2 : 1), v.end());
  for (const Index i : a) {
    for (const Index k : b) consider(Type::VertexVertex, Kind::VertexFace, {i, k, k, k}, 1);
  }
  if (keys.empty()) {
    for (const Index i : a) {
      for (std::size_t k = 0; k < b.size(); ++k) {
        const Index p = b[k], q = b[(k + 1) % b.size()];
        if (p != q) consider(Type::VertexEdge, Kind::VertexFace, {i, p, q, q}, 1);
      }
    }
    for (const Index k : b) {
      if (edges) consider(Type::VertexEdge, Kind::VertexFace, {k, a[0], a[1], a[1]}, 1);
    }
  }
  if (keys.empty()) consider(edges ? Type::EdgeEdge : Type::VertexFace, pair.kind(), v, edges ? 2 : 1);
  return keys.size() == 1 ? std::optional(*keys.begin()) : std::nullopt;
}

bool nearly_parallel(const FeaturePair& pair, std::span<const double> rest, std::span<const double> x) {
  if (pair.kind() != Kind::EdgeEdge) return false;
  const FourPoints r = pair.at(rest), p = pair.at(x);
  return (p[1] - p[0]).cross(p[3] - p[2]).squaredNorm() <
         1e-3 * (r[1] - r[0]).squaredNorm() * (r[3] - r[2]).squaredNorm();
}

// What one close pair says of itself.
void expect_consistent(const ClosePair& pair, std::span<const double> x) {
  Vec3 difference;
  double sum[2] = {0, 0};
  const int first = pair.kind == Type::EdgeEdge ? 2 : 1;
  for (int k = 0; k < 4; ++k) {
    difference += pair.weights[k] * Vec3::load(&x[3 * pair.vertices[k]]);
    sum[k < first ? 0 : 1] += pair.weights[k];
    ASSERT_GE(pair.weights[k] * (k < first ? 1 : -1), 0);
  }
  double largest = extent(pair.vertices, x);
  for (const Index v : pair.vertices)
    largest = std::max(largest, Vec3::load(&x[3 * v]).cwiseAbs().maxCoeff());
  ASSERT_NEAR(sum[0], 1, 1e-15);
  ASSERT_NEAR(sum[1], -1, 1e-15);
  ASSERT_NEAR(pair.normal.norm(), 1, 1e-15);
  ASSERT_NEAR((difference / largest).norm(), pair.distance / largest, 1e-15);
  if (pair.distance > 1e-6 * largest) {
    ASSERT_GT(pair.normal.dot(difference / largest), (1 - 1e-9) * pair.distance / largest);
  }
}

struct Counts {
  int listed = 0, left_out = 0, unique = 0, parallel = 0, merged = 0;
};

// `tolerance`: of distances, relative to a pair's extent. `rest`: the mesh's.
void expect_all_close(ContactChecker& checker, const Soup& soup, std::span<const double> rest,
                      double distance, double tolerance, bool unique, Counts& counts) {
  const auto& x = soup.x0;
  const std::vector<ClosePair> found = close_pairs(checker, x, distance);
  std::map<Key, const ClosePair*> by_key;
  std::size_t total = 0;
  for (const ClosePair& pair : found) {
    expect_consistent(pair, x);
    ASSERT_TRUE(by_key.emplace(key_of(pair), &pair).second) << "a pair twice";
    ASSERT_EQ(pair.count > 1 && pair.kind > Type::VertexEdge, false);
    total += pair.count;
    counts.merged += pair.count > 1;
  }
  std::size_t least = 0, most = 0;
  std::map<Key, std::size_t> expected;
  for (const FeaturePair& pair : all_pairs(soup, checker.mesh().edges(), all_may)) {
    const Rational square = exact_square(pair.kind(), pair.vertices, x);
    const double true_distance = rounded_root(square), room = tolerance * extent(pair.vertices, x);
    const bool is_close = std::isinf(distance) || square <= Rational(distance) * Rational(distance);
    least += is_close;
    most += is_close || true_distance <= distance + room;
    ++(is_close ? counts.listed : counts.left_out);
    if (!is_close) continue;
    const bool parallel = nearly_parallel(pair, rest, x);
    const auto& v = pair.vertices;
    const auto key = parallel ? std::optional(key_of(Type::EdgeEdge, {v[0], v[1]}, {v[2], v[3]}))
                              : nearest_features(pair, x, square);
    if (!key || !unique) continue;
    ++expected[*key];
    ASSERT_TRUE(by_key.contains(*key)) << "missing: " << ::testing::PrintToString(v);
    const ClosePair& close = *by_key.at(*key);
    ASSERT_NEAR(close.distance / extent(v, x), true_distance / extent(v, x), tolerance);
    ASSERT_EQ(close.mollifier_threshold > 0, parallel);
    counts.parallel += parallel;
    ++counts.unique;
  }
  ASSERT_GE(total, least) << "a pair is missing";
  ASSERT_LE(total, most) << "a pair too many";
  if (least != most || !unique) return;
  for (const auto& [key, count] : expected) ASSERT_GE(by_key.at(key)->count, count);
}

Soup scaled(Soup soup, double scale, double shift) {
  for (double& x : soup.x0) x = x * scale + shift;
  soup.x1 = soup.x0;
  return soup;
}

TEST(ClosePairs, AreThoseOfExactArithmetic) {
  Counts counts;
  for (int seed = 0; seed < testing::rounds(12); ++seed) {
    for (const double scale : {1.0, 1e-9, 1e9, 0x1p-500, 0x1p500}) {
      Rng rng(static_cast<std::uint64_t>(seed));
      const Soup soup = scaled(random_soup(rng, 4, 4, 4, 0, seed % 3 == 0 ? 0x1p-4 : 0x1p-40), scale, 0);
      ContactChecker checker = checker_of(soup);
      // Elsewhere thresholds under- and overflow, or coordinates that were on a grid are rounded.
      const bool unique = scale == 1 || (seed % 3 != 0 && scale > 0x1p-200 && scale < 0x1p200);
      for (const double distance : {0.0, 0.05, 0.3, kInfinity}) {
        expect_all_close(checker, soup, soup.x0, distance * scale, 1e-14, unique, counts);
        if (HasFatalFailure()) {
          ADD_FAILURE() << "seed " << seed << ", scale " << scale << ", distance " << distance;
          return;
        }
      }
    }
  }
  EXPECT_GT(counts.listed, 1000 * testing::rounds(12));
  EXPECT_GT(counts.left_out, 3000);
  EXPECT_GT(counts.unique, 400 * testing::rounds(12));
  EXPECT_GT(counts.parallel, testing::rounds(12) / 4);
  EXPECT_GT(counts.merged, 100);
}

// Needles, segments and points as triangles, edges that are nearly parallel, far from the origin.
TEST(ClosePairs, OfDegenerateFeaturesAreComplete) {
  Counts counts;
  for (int seed = 0; seed < testing::rounds(60); ++seed) {
    Rng rng(100 + static_cast<std::uint64_t>(seed));
    std::uniform_real_distribution<double> unit(0, 1);
    Soup soup = random_soup(rng, 5, 5, 1, 0, seed % 2 == 0 ? 0x1p-6 : 0x1p-45);
    const auto place = [&](Index v, Index a, Index b, double t, double off) {
      for (int axis = 0; axis < 3; ++axis)
        soup.x0[3 * v + axis] = soup.x0[3 * a + axis] * (1 - t) + soup.x0[3 * b + axis] * t + off * unit(rng);
    };
    for (std::size_t f = 0; f < soup.faces.size(); ++f) {
      const auto [a, b, c] = soup.faces[f];
      const double off = std::ldexp(1.0, -8 * static_cast<int>(rng() % 8));
      if (f % 5 == 0) place(c, a, b, unit(rng), off * 0.01);
      if (f % 5 == 1) place(c, a, b, 0, 0);
      if (f % 5 == 2) place(c, a, b, 0, 0), place(b, a, a, 0, 0);
    }
    const double scales[] = {1, 1e-9, 1e9};
    const double scale = scales[rng() % 3], shift = rng() % 3 == 0 ? 1000 * scale : 0;
    soup = scaled(std::move(soup), scale, shift);
    ContactChecker checker = checker_of(soup);
    for (const double distance : {0.0, 0.02, 0.2}) {
      expect_all_close(checker, soup, soup.x0, distance * scale, 0x1p-25, false, counts);
      ASSERT_FALSE(HasFatalFailure()) << "seed " << seed << ", distance " << distance;
    }
  }
  EXPECT_GT(counts.listed, 17 * testing::rounds(60));
  EXPECT_GT(counts.left_out, 1000);
}

// Decided by the last digits: the least double that is not below a pair's distance, and one a little smaller.
TEST(ClosePairs, TheDistanceItselfIsClose) {
  for (int seed = 0; seed < testing::rounds(2000); ++seed) {
    Rng rng(static_cast<std::uint64_t>(seed));
    const bool edges = seed % 2 == 0;
    Soup soup = edges ? random_soup(rng, 0, 2, 0, 0, 0x1p-40) : random_soup(rng, 1, 0, 1, 0, 0x1p-40);
    if (edges) soup.edges.resize(2);
    soup = scaled(std::move(soup), 1, seed % 3 == 0 ? 1000 : 0);
    ContactChecker checker = checker_of(soup);
    const auto pairs = all_pairs(soup, checker.mesh().edges(), all_may);
    ASSERT_EQ(pairs.size(), 1u);
    const Rational square = exact_square(pairs[0].kind(), pairs[0].vertices, soup.x0);
    double distance = rounded_root(square);
    while (Rational(distance) * Rational(distance) < square) distance = std::nextafter(distance, kInfinity);
    ASSERT_EQ(close_pairs(checker, soup.x0, distance).size(), 1u) << seed;
    if (distance > 0.01) {
      ASSERT_EQ(close_pairs(checker, soup.x0, distance * (1 - 0x1p-30)).size(), 0u) << seed;
    }
  }
}

// A point above a corner, an edge and the inside of two triangles.
TEST(ClosePairs, CountEdgesAndCornersOncePerPair) {
  Soup soup;
  soup.faces = {{0, 1, 2}, {2, 1, 3}};
  soup.x0 = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 0, 0.25};
  soup.x1 = soup.x0;
  ContactChecker checker = checker_of(soup);
  const auto only = [&](double x, double y) {
    soup.x0[12] = x;
    soup.x0[13] = y;
    const auto found = close_pairs(checker, soup.x0, 0.25);
    EXPECT_EQ(found.size(), 1u);
    EXPECT_EQ(found.at(0).distance, 0.25);
    EXPECT_EQ(found.at(0).vertices[0], found.at(0).kind == Type::VertexVertex ? 1u : 4u);
    return std::pair(found.at(0).kind, found.at(0).count);
  };
  EXPECT_EQ(only(0.25, 0.25), std::pair(Type::VertexFace, Index{1}));
  EXPECT_EQ(only(0.5, 0.5), std::pair(Type::VertexEdge, Index{2}));
  EXPECT_EQ(only(1, 0), std::pair(Type::VertexVertex, Index{2}));
}

// As of ipc-toolkit's: sin^2 of the angle below 1e-3 where lengths are those at rest.
TEST(ClosePairs, NearlyParallelEdgesStayEdges) {
  Soup soup;
  soup.edges = {{0, 1}, {2, 3}};
  soup.x0 = soup.x1 = {0, 0, 0, 2, 0, 0, 3, 0, 0, 4, 0, 0};
  ContactChecker checker = checker_of(soup);
  const auto turned = [&](double sine) {  // the ends 1 and 2 remain nearest
    soup.x0[9] = 3 + std::sqrt(1 - sine * sine);
    soup.x0[10] = sine;
    return close_pairs(checker, soup.x0, 1).at(0);
  };
  const double limit = std::sqrt(1e-3);
  const ClosePair parallel = turned(0.999 * limit), not_parallel = turned(1.001 * limit);
  EXPECT_EQ(parallel.kind, Type::EdgeEdge);
  EXPECT_NEAR(parallel.mollifier_threshold, 4e-3, 1e-15);
  EXPECT_EQ(parallel.distance, 1);
  EXPECT_EQ(parallel.weights, (std::array<double, 4>{0, 1, -1, 0}));
  EXPECT_EQ(not_parallel.kind, Type::VertexVertex);
  EXPECT_EQ(not_parallel.mollifier_threshold, 0);
  for (double& x : soup.x0) x *= 2;  // twice as long as at rest
  soup.x0[10] *= 0.3;
  EXPECT_EQ(close_pairs(checker, soup.x0, 2).at(0).kind, Type::VertexVertex);
}

TEST(ClosePairs, WithActiveVerticesAreThoseOfAllThatHaveOne) {
  std::size_t kept = 0, dropped = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Rng rng(seed);
    const Soup soup = random_soup(rng, 12, 6, 6, 0, 0x1p-40);
    ContactChecker checker = checker_of(soup);
    std::vector<std::uint8_t> active(soup.vertex_count());
    for (auto& flag : active) flag = rng() % 4 == 0 ? 1 + rng() % 255 : 0;
    std::vector<ClosePair> expected = close_pairs(checker, soup.x0, 0.2);
    dropped += std::erase_if(expected, [&](const ClosePair& pair) {
      return std::ranges::none_of(pair.vertices, [&](Index v) { return active[v] != 0; });
    });
    kept += expected.size();
    EXPECT_EQ(close_pairs(checker, soup.x0, 0.2, active), expected);
  }
  EXPECT_GT(kept, 100u);
  EXPECT_GT(dropped, 100u);
}

TEST(ClosePairs, DependOnThePoseAndTheFilterAlone) {
  std::size_t pairs = 0;
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    Rng rng(seed);
    Soup soup = random_soup(rng, 20, 6, 6, 0, 0x1p-40);
    const auto may = [](Index i, Index j) { return (i ^ j) % 3 != 0; };
    ContactChecker kept = checker_of(soup, CollisionFilter(may));
    Candidates candidates;
    for (int call = 0; call < 12; ++call) {
      for (double& x : soup.x0) x += std::ldexp(static_cast<double>(rng() % 1024), -18);
      if (rng() % 3 == 0) {
        EXPECT_TRUE(kept.candidates(soup.x0, 0.1, candidates));
      }
      if (rng() % 3 == 0) {
        EXPECT_GT(close_pairs(kept, soup.x0, kInfinity).size(), 500u);
      }
      if (rng() % 3 == 0) {
        EXPECT_TRUE(kept.minimum_distance(soup.x0, kInfinity));
      }
      ContactChecker fresh = checker_of(soup, CollisionFilter(may));
      std::vector<ClosePair> found, expected;
      with_threads(4, [&] { found = close_pairs(kept, soup.x0, 0.05); });
      with_threads(1, [&] { expected = close_pairs(fresh, soup.x0, 0.05); });
      const auto by_vertices = [](const ClosePair& a, const ClosePair& b) { return a.vertices < b.vertices; };
      std::ranges::sort(found, by_vertices);
      std::ranges::sort(expected, by_vertices);
      ASSERT_EQ(found.size(), expected.size());
      for (std::size_t k = 0; k < found.size(); ++k) ASSERT_EQ(found[k].vertices, expected[k].vertices);
      pairs += found.size();
    }
  }
  EXPECT_GT(pairs, 1000u);
}

TEST(ClosePairs, AreTheSameOnEveryInstructionSet) {
  Rng rng(5);
  const Soup soup = random_soup(rng, 40, 20, 20, 0, 0x1p-40);
  testing::expect_all_targets_agree([&] {
    ContactChecker checker = checker_of(soup);
    std::vector<double> bits;
    for (const ClosePair& pair : close_pairs(checker, soup.x0, 0.4)) {
      bits.push_back(pair.distance);
      bits.insert(bits.end(), pair.weights.begin(), pair.weights.end());
      bits.insert(bits.end(), pair.normal.begin(), pair.normal.end());
    }
    EXPECT_GT(bits.size(), 8000u);
    return bits;
  });
}

TEST(ClosePairs, RefuseInvalidInput) {
  Soup soup;
  soup.x0 = soup.x1 = {0, 0, 0, 3, 4, 0};
  ContactChecker checker = checker_of(soup);
  std::vector<ClosePair> found;
  const auto line = [&](double distance, std::vector<std::uint8_t> active = {}) {
    return checker.close_pairs(soup.x0, distance, found, active).error().line();
  };
  EXPECT_EQ(line(-1), "distance: is not a length; give a number of at least 0, or infinity");
  EXPECT_EQ(line(std::nan("")), "distance: is not a length; give a number of at least 0, or infinity");
  EXPECT_EQ(line(1, {1}), "active: has 1 numbers; give one for each of the 2 vertices, or none");
  soup.x0[4] = kInfinity;
  EXPECT_FALSE(checker.close_pairs(soup.x0, 1, found));
}

}  // namespace
}  // namespace foldproof::oracle
