// Whole shapes: Eq. 8 at the root and below, several centers, uncertified pairs, and errors.
#include <gtest/gtest.h>

#include <optional>
#include <set>

#include "base/callers.h"
#include "foldproof/check.h"
#include "oracle/brute_force.h"
#include "reduced/features.h"
#include "reduced/shape.h"

namespace foldproof::testing {
namespace {

std::vector<double> zeros(const ReducedMotion& motion) { return std::vector<double>(motion.modes(), 0.0); }

std::vector<double> at_distance(const ReducedMotion& motion, double distance, std::mt19937& random) {
  auto p = random_direction(motion, random);
  for (double& c : p) c *= distance;
  return p;
}

// Tests every pair of features of the reconstructed meshes.
bool touches(const ReducedMesh& mesh, const ReducedMotion& motion, std::span<const double> p0,
             std::span<const double> p1) {
  oracle::Scene scene;
  scene.topologies.push_back(mesh.topology);
  for (const auto& [p, x] : {std::pair(p0, &scene.x0), std::pair(p1, &scene.x1)}) {
    x->emplace_back(mesh.rest.size());
    motion.positions(p, x->back());
  }
  return !oracle::brute_force_step(scene, {}, 1e-9).clean();
}

TEST(ReducedShape, NothingTouchesWithinTheRadius) {
  for (const ReducedMesh& mesh : {bending_tube(20, 30, 0.4), waving_cloth(14)}) {
    const auto motion = mesh.motion(4);
    const auto shape = ReducedShape::build(motion, {{zeros(*motion)}}).value();
    ASSERT_GT(shape.radius(0), 0.3);
    ASSERT_TRUE(shape.never_certified().empty());
    std::mt19937 random(31);
    ReducedShape::Scratch scratch;
    for (int round = 0; round < 4; ++round) {
      const auto p0 = at_distance(*motion, 0.9999 * shape.radius(0), random);
      const auto p1 = at_distance(*motion, 0.9999 * shape.radius(0), random);
      EXPECT_EQ(shape.proven_free(p0, p1, scratch), ReducedProof::Free);
      EXPECT_EQ(scratch.visited, 1u) << "inside the root's ball one pair is enough";
      EXPECT_FALSE(touches(mesh, *motion, p0, p1));
    }
  }
}

// Beyond the radius some steps are still proven, pair by pair, and those are free.
TEST(ReducedShape, ProvenStepsBeyondTheRadiusAreFree) {
  const ReducedMesh mesh = waving_cloth(12);
  const auto motion = mesh.motion();
  std::mt19937 random(32);
  std::vector<ReducedCenter> centers{{zeros(*motion)}};
  for (int k = 0; k < 3; ++k) centers.push_back({at_distance(*motion, 2, random)});
  const auto shape = ReducedShape::build(motion, centers).value();
  ReducedShape::Scratch scratch;
  int proven = 0, unproven = 0;
  for (int round = 0; round < 40; ++round) {
    const double beyond = 1.001 + 0.0004 * round * round;  // of the radius; to 1.6
    auto p0 = at_distance(*motion, beyond * shape.radius(0), random), p1 = p0;
    for (double& c : p1) c *= 0.98;
    const ReducedProof answer = shape.proven_free(p0, p1, scratch);
    EXPECT_EQ(answer, shape.find_unproven(p0, p1, scratch));
    EXPECT_EQ(answer == ReducedProof::Unproven, !scratch.unproven.empty());
    (answer == ReducedProof::Free ? proven : unproven) += 1;
    if (answer == ReducedProof::Free && proven <= 6) {
      EXPECT_FALSE(touches(mesh, *motion, p0, p1));
    }
  }
  EXPECT_GT(proven, 0);
  EXPECT_GT(unproven, 0);
}

// A cloth whose mean passes through itself: the pairs that touch there are uncertified, all others have a
// radius.
TEST(ReducedShape, ListsThePairsThatTouchAtTheCenter) {
  ReducedMesh mesh = waving_cloth(12);
  // One corner's vertex is pulled below the middle of the sheet, its neighbor above.
  const Index row = 13;
  mesh.subspace.mean[3 + 2] += 0.1;
  for (int axis = 0; axis < 3; ++axis)
    mesh.subspace.mean[axis] = mesh.subspace.mean[3 * (6 * row + 6) + axis] - (axis == 2 ? 0.05 : 0.01);
  const auto motion = mesh.motion();
  const auto shape = ReducedShape::build(motion, {{zeros(*motion)}}).value();
  EXPECT_GT(shape.radius(0), 0);
  ASSERT_FALSE(shape.uncertified(0).empty());
  std::vector<double> x(mesh.rest.size());
  motion->positions(zeros(*motion), x);
  StepChecker checker({motion->hierarchy()});
  StaticResult crossings;
  const std::span<const double> pose[] = {x};
  ASSERT_TRUE(checker.check_static(pose, {}, crossings));
  ASSERT_FALSE(crossings.clean());
  const Hierarchy& h = *motion->hierarchy();
  std::vector<Index> leaf_of(h.triangles().size());
  for (Index leaf = 0; leaf < h.leaf_count(); ++leaf) {
    for (Index t = h.leaves()[leaf].triangles; t < h.leaves()[leaf + 1].triangles; ++t)
      leaf_of[h.triangle_ids()[t]] = leaf;
  }
  std::set<std::array<Index, 2>> crossing, listed;
  for (const auto& c : crossings.crossings)
    crossing.insert({std::min(leaf_of[c.triangle_a], leaf_of[c.triangle_b]),
                     std::max(leaf_of[c.triangle_a], leaf_of[c.triangle_b])});
  for (const UncertifiedPair& pair : shape.uncertified(0)) {
    if (pair.touches) listed.insert({pair.leaf_a, pair.leaf_b});
  }
  EXPECT_EQ(crossing, listed);
  ReducedShape::Scratch scratch;
  EXPECT_EQ(shape.proven_free(zeros(*motion), zeros(*motion), scratch), ReducedProof::FreeExceptUncertified);
}

// Pairs with small balls may count as uncertified. All others are then separated within the larger radius.
TEST(ReducedShape, CertifiesALargerRadiusWithoutPairsOfSmallBalls) {
  ReducedMesh mesh = waving_cloth(12);
  // One corner's vertex hangs just above the middle of the sheet.
  const Index row = 13, middle = 6 * row + 6;
  for (int axis = 0; axis < 3; ++axis)
    mesh.subspace.mean[axis] = mesh.subspace.mean[3 * middle + axis] + (axis == 2 ? 0.02 : 0.01);
  const auto motion = mesh.motion();
  const auto shape = ReducedShape::build(motion, {{zeros(*motion)}}).value();
  const auto all = shape.certified(0, 0);
  EXPECT_EQ(all.radius, shape.radius(0));
  EXPECT_EQ(all.uncertified.size(), shape.uncertified(0).size());
  const double at_least = 1.5 * all.radius;
  const auto larger = shape.certified(0, at_least);
  EXPECT_GE(larger.radius, at_least);
  ASSERT_GT(larger.uncertified.size(), all.uncertified.size());
  std::set<std::array<Index, 2>> uncertified;
  for (const UncertifiedPair& pair : larger.uncertified) {
    uncertified.insert({pair.leaf_a, pair.leaf_b});
    EXPECT_LT(pair.radius, at_least);
  }
  const Hierarchy& h = *motion->hierarchy();
  std::vector<Index> leaf_node(h.leaf_count());
  for (Index n = 0; n < h.nodes().size(); ++n) {
    if (h.nodes()[n].is_leaf()) leaf_node[h.nodes()[n].leaf_begin] = n;
  }
  std::mt19937 random(35);
  for (int round = 0; round < 3; ++round) {
    const auto p0 = at_distance(*motion, 0.999 * larger.radius, random);
    const auto p1 = at_distance(*motion, 0.999 * larger.radius, random);
    for (Index a = 0; a < h.leaf_count(); ++a) {
      for (Index b = a; b < h.leaf_count(); ++b) {
        if (uncertified.contains({a, b})) continue;
        ASSERT_FALSE(Features(*motion, {leaf_node[a], leaf_node[b]}).touch(p0, p1)) << a << " " << b;
      }
    }
  }
}

TEST(ReducedShape, IsTheSameForAnyNumberOfThreads) {
  if (!has_threads()) GTEST_SKIP() << "there is one thread";
  const auto motion = bending_tube(12, 24, 0.4).motion();
  const auto build = [&](int threads) {
    std::optional<ReducedShape> shape;
    with_threads(threads, [&] { shape = ReducedShape::build(motion, {{zeros(*motion)}}).value(); });
    return std::move(*shape);
  };
  const auto one = build(1), four = build(4);
  EXPECT_EQ(one.impl().radii, four.impl().radii);
  EXPECT_EQ(one.balls().radii, four.balls().radii);
  EXPECT_EQ(one.balls().pairs.size(), four.balls().pairs.size());
}

TEST(ReducedShape, ComesBackFromItsBalls) {
  const auto motion = bending_tube(12, 24, 0.4).motion();
  std::vector<ReducedCenter> centers{{zeros(*motion)}, {zeros(*motion)}};
  centers[1].p[0] = motion->deviations()[0];
  const auto shape = ReducedShape::build(motion, centers).value();
  const auto back = ReducedShape::from_balls(motion, centers, shape.balls()).value();
  EXPECT_EQ(back.impl().radii, shape.impl().radii);
  EXPECT_EQ(back.clearance(), shape.clearance());
  EXPECT_TRUE(std::ranges::equal(back.never_certified(), shape.never_certified()));
  for (const Index c : {0, 1}) {
    EXPECT_EQ(back.radius(c), shape.radius(c));
    EXPECT_EQ(back.uncertified(c).size(), shape.uncertified(c).size());
    EXPECT_EQ(back.certified(c, 0.1).radius, shape.certified(c, 0.1).radius);
  }
}

TEST(ReducedShape, RefusesBallsOfAnotherHierarchyOrThatAreNone) {
  const auto motion = bending_tube(12, 24, 0.4).motion(), other = bending_tube(12, 12, 0.4).motion();
  const std::vector<ReducedCenter> centers{{zeros(*motion)}};
  const ReducedBalls good = ReducedShape::build(motion, centers).value().balls();
  ASSERT_TRUE(ReducedShape::from_balls(motion, centers, good));
  EXPECT_FALSE(ReducedShape::from_balls(other, centers, good));
  EXPECT_FALSE(ReducedShape::from_balls(motion, {centers[0], centers[0]}, good));
  EXPECT_FALSE(ReducedShape::from_balls(motion, centers, {}));
  const auto refused = [&](auto change) {
    ReducedBalls balls = good;
    change(balls);
    const auto shape = ReducedShape::from_balls(motion, centers, balls);
    return !shape && shape.error().where == "balls";
  };
  using B = ReducedBalls&;
  ASSERT_GT(good.pairs[0].count, 0u);
  EXPECT_TRUE(refused([](B b) { b.radii[3] = -1; }));
  EXPECT_TRUE(refused([](B b) { b.radii[3] = NAN; }));
  EXPECT_TRUE(refused([](B b) { b.radii.pop_back(); }));
  EXPECT_TRUE(refused([](B b) { b.clearance = 0; }));
  EXPECT_TRUE(refused([](B b) { b.pairs[0].begin = 0; }));               // a circle
  EXPECT_TRUE(refused([](B b) { b.pairs[0].begin = 0xffffffff; }));      // beyond the end
  EXPECT_TRUE(refused([](B b) { b.pairs[0].count = 0; }));               // parts of nothing
  EXPECT_TRUE(refused([](B b) { b.pairs[0].count = 2; }));               // a part is missing
  EXPECT_TRUE(refused([](B b) { std::swap(b.pairs[1], b.pairs[2]); }));  // of other nodes
  EXPECT_TRUE(refused([](B b) { b.pairs[1].a = 0xffffffff; }));
}

TEST(ReducedShape, WorksWithOneMode) {
  const ReducedMesh mesh = bending_tube(12, 24, 0.4, 1);
  const auto motion = mesh.motion(4);
  ASSERT_EQ(motion->modes(), 1u);
  const auto shape = ReducedShape::build(motion, {{{0.0}}}).value();
  ReducedShape::Scratch scratch;
  const std::vector<double> p0{-0.9 * shape.radius(0) * motion->deviations()[0]}, p1{-p0[0]};
  EXPECT_EQ(shape.proven_free(p0, p1, scratch), ReducedProof::Free);
  EXPECT_FALSE(touches(mesh, *motion, p0, p1));
  EXPECT_EQ(shape.distance(0, p0), shape.distance(0, p1));
  EXPECT_GE(shape.distance(0, p0), 0.9 * shape.radius(0));
}

TEST(ReducedShape, ProvesNothingFromInvalidCoordinates) {
  const auto motion = waving_cloth(6).motion();
  const auto shape = ReducedShape::build(motion, {{zeros(*motion)}}).value();
  ReducedShape::Scratch scratch;
  const auto good = zeros(*motion);
  auto bad = good;
  for (const double number : {std::nan(""), double{INFINITY}, 1e308}) {
    bad[1] = number;
    EXPECT_EQ(shape.proven_free(good, bad, scratch), ReducedProof::Unproven);
    EXPECT_EQ(shape.proven_free(bad, good, scratch), ReducedProof::Unproven);
  }
  EXPECT_EQ(shape.proven_free(good, std::span(good).first(1), scratch), ReducedProof::Unproven);
  EXPECT_EQ(shape.proven_free({}, {}, scratch), ReducedProof::Unproven);
}

// A mode that only moves the shape, far: no distance limits it, only the rounding of positions, which the
// clearance covers.
TEST(ReducedShape, ProvesNothingWhereRoundingExceedsTheClearance) {
  ReducedMesh mesh = waving_cloth(6);
  mesh.subspace.mean = Eigen::Map<const Eigen::VectorXd>(mesh.rest.data(), mesh.subspace.mean.size());
  mesh.subspace.basis = Eigen::MatrixXd::Constant(mesh.subspace.mean.size(), 1, 0x1p-4);
  mesh.subspace.deviations = Eigen::VectorXd::Constant(1, 0x1p30);
  const auto motion = mesh.motion();
  const auto shape = ReducedShape::build(motion, {{zeros(*motion)}}).value();
  ReducedShape::Scratch scratch;
  int free = 0;
  for (double p = 1; p < 0x1p60; p *= 2) {
    const std::vector<double> far{p};
    const bool proven = shape.proven_free(far, far, scratch) != ReducedProof::Unproven;
    if (!proven) continue;
    EXPECT_LE(4 * motion->rounding(far), shape.clearance()) << p;
    ++free;
  }
  EXPECT_GT(free, 10);
}

TEST(ReducedShape, RefusesInvalidInput) {
  const ReducedMesh mesh = waving_cloth(6);
  const auto motion = mesh.motion();
  EXPECT_FALSE(ReducedShape::build(motion, {}));
  EXPECT_FALSE(ReducedShape::build(motion, {{{1.0}}}));
  EXPECT_FALSE(ReducedShape::build(motion, {{std::vector<double>(motion->modes(), NAN)}}));
  EXPECT_FALSE(ReducedShape::build(motion, {{zeros(*motion), -1}}));
  EXPECT_FALSE(ReducedShape::build(motion, {{zeros(*motion)}}, {-1.0}));
  const std::atomic<bool> cancel{true};
  EXPECT_FALSE(ReducedShape::build(motion, {{zeros(*motion)}}, {}, {{}, &cancel}));
  const auto refused = [&](auto spoil) {
    Pca subspace = mesh.subspace;
    spoil(subspace);
    return !ReducedMotion::make(mesh.hierarchy(), subspace);
  };
  EXPECT_FALSE(refused([](Pca&) {}));
  EXPECT_TRUE(refused([](Pca& s) { s.mean.conservativeResize(s.mean.size() - 3); }));
  EXPECT_TRUE(refused([](Pca& s) { s.basis.conservativeResize(Eigen::NoChange, 0); }));
  EXPECT_TRUE(refused([](Pca& s) { s.deviations[0] = 0; }));
  EXPECT_TRUE(refused([](Pca& s) { s.deviations.conservativeResize(1); }));
  EXPECT_TRUE(refused([](Pca& s) { s.basis(3, 0) = NAN; }));
  EXPECT_TRUE(refused([](Pca& s) { s.basis(3, 0) = 1e39; }));
}

// R5: squares that underflow or overflow make balls too large.
TEST(ReducedShape, RefusesWhatSquaresCannotHold) {
  const ReducedMesh mesh = waving_cloth(6);
  const auto build = [&](double scale, double deviation_scale) {
    ReducedMesh other = mesh;
    for (double& x : other.rest) x *= scale;
    other.subspace.mean *= scale;
    other.subspace.deviations *= deviation_scale;
    const auto motion = other.motion();
    return ReducedShape::build(motion, {{zeros(*motion)}});
  };
  for (const double scale : {0x1p-1000, 0x1p-536, 1e-71, 1e71, 0x1p1000}) EXPECT_FALSE(build(scale, scale));
  for (const double deviations : {1e71, 1e156, 1e200, 1e300}) EXPECT_FALSE(build(1, deviations));
  for (const double scale : {0x1p-228, 0x1p-40, 1.0, 0x1p40, 0x1p228}) {
    const auto shape = build(scale, scale);
    ASSERT_TRUE(shape);
    EXPECT_GT(shape->radius(0), 1) << scale;
  }
}

// Two modes whose products are infinite and cancel: such coordinates are no number, and no maximum notices
// it.
TEST(ReducedShape, RefusesACenterThatIsNoShape) {
  ReducedMesh mesh = waving_cloth(6);
  mesh.subspace.basis.setZero();
  mesh.subspace.basis(0, 0) = 1e10;
  mesh.subspace.basis(0, 1) = -1e10;
  const auto motion = mesh.motion();
  std::vector<double> p = zeros(*motion);
  p[0] = p[1] = 1e308;
  EXPECT_FALSE(ReducedShape::build(motion, {{p}}));
}

// R5: it is rounded up, also where its square is no number above 0.
TEST(ReducedShape, ADistanceIsNeverZeroBesideACenter) {
  const auto motion = waving_cloth(6).motion();
  const auto shape = ReducedShape::build(motion, {{zeros(*motion)}}).value();
  for (const double q : {1e-200, 1e-160, 1e-20, 1.0}) {
    std::vector<double> p = zeros(*motion);
    p[1] = q * motion->deviations()[1];
    EXPECT_GE(shape.distance(0, p), q);
  }
  EXPECT_EQ(shape.distance(0, zeros(*motion)), 0);
}

// Tabulated values of the chi-square distribution: 1 to 3 standard deviations of one number, and the median
// and the 95th percentile of more.
TEST(NormalShare, IsTheChiSquareDistribution) {
  EXPECT_NEAR(normal_share(1, 1), 0.682689, 1e-6);
  EXPECT_NEAR(normal_share(3, 1), 0.997300, 1e-6);
  EXPECT_NEAR(normal_share(std::sqrt(1.386294), 2), 0.5, 1e-6);
  EXPECT_NEAR(normal_share(std::sqrt(18.307038), 10), 0.95, 1e-6);
  EXPECT_NEAR(normal_share(std::sqrt(124.342113), 100), 0.95, 1e-6);
  EXPECT_EQ(normal_share(0, 5), 0);
  EXPECT_EQ(normal_share(1e6, 5), 1);
}

TEST(ReducedMotion, IsMeanPlusBasisTimesCoordinates) {
  const ReducedMesh mesh = waving_cloth(6);
  const auto motion = mesh.motion();
  std::mt19937 random(33);
  const auto p = at_distance(*motion, 3, random);
  std::vector<double> x(mesh.rest.size());
  motion->positions(p, x);
  const Eigen::VectorXd expected = mesh.subspace.reconstruct(
      Eigen::Map<const Eigen::VectorXd>(p.data(), static_cast<Eigen::Index>(p.size())));
  for (std::size_t i = 0; i < x.size(); ++i) EXPECT_NEAR(x[i], expected[static_cast<Eigen::Index>(i)], 1e-12);
  for (Index v = 0; v < motion->hierarchy()->vertex_ids().size(); ++v) {
    double alone[3];
    motion->vertex(v, p, alone);
    for (int axis = 0; axis < 3; ++axis)
      EXPECT_EQ(alone[axis], x[3 * motion->hierarchy()->vertex_ids()[v] + axis]);
  }
}

}  // namespace
}  // namespace foldproof::testing
