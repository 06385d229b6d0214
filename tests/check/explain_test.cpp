// Explanations of queries on generated meshes whose answer is known.
#include <gmock/gmock.h>

#include <array>
#include <bit>
#include <cmath>
#include <numbers>
#include <numeric>

#include "base/callers.h"
#include "bvh/meshes.h"
#include "certificate/library.h"
#include "foldproof/check.h"
#include "mesh/grid.h"
#include "oracle/meshes.h"

namespace foldproof {
namespace {

using ::testing::AnyOf;
using ::testing::Each;
using testing::Mesh;

constexpr std::size_t at(Reason reason) { return static_cast<std::size_t>(reason); }

std::size_t count(const std::vector<Reason>& reasons, Reason wanted) {
  return static_cast<std::size_t>(std::count(reasons.begin(), reasons.end(), wanted));
}

/// An open tube, bent to an arc.
Mesh tube(double bend) {
  const testing::Grid grid{.columns = 24, .rows = 60, .closed = true};
  return {grid.topology(), grid.positions([&](double u, double v) {
            const double around = 2 * std::numbers::pi * u, along = v - 0.5;
            const double out = 0.1 * std::cos(around), radius = 1 / bend;
            return std::array{(radius + out) * std::cos(bend * along) - radius,
                              (radius + out) * std::sin(bend * along), 0.1 * std::sin(around)};
          })};
}

/// A single object and its steps.
class Stepper {
 public:
  explicit Stepper(const Mesh& mesh, StepSettings settings = {}, HierarchySettings leaves = {})
      : settings_(settings),
        tree(std::make_shared<const Hierarchy>(*Hierarchy::build(mesh.topology, mesh.positions, leaves))),
        checker_({tree}),
        now_(mesh.positions) {
    settings_.explain = true;
  }

  const Explanation& step(const std::vector<double>& next) {
    const std::span<const double> from[] = {now_}, to[] = {next};
    EXPECT_TRUE(checker_.check(from, to, settings_, result));
    now_ = next;
    return result.explanation;
  }

 private:
  StepSettings settings_;

 public:
  const std::shared_ptr<const Hierarchy> tree;
  StepResult result;

 private:
  StepChecker checker_;
  std::vector<double> now_;
};

std::uint64_t tested(const Explanation& e) {
  return std::accumulate(e.leaf_pairs.begin() + 1, e.leaf_pairs.end(), std::uint64_t{0});
}

TEST(Explanation, ABendingTubeIsCertifiedOnceItsChartsAreBuilt) {
  Stepper tube_steps(tube(0.5));
  StepSettings off;
  off.certificates = false;
  Stepper all_tested(tube(0.5), off);
  for (int k = 1; k <= 20; ++k) {
    const std::vector<double> next = tube(0.5 + 0.02 * k).positions;
    const Explanation& explained = tube_steps.step(next);
    const auto& [level, margin, reason] = explained.objects.at(0);
    const std::size_t triangles = tube_steps.tree->topology().triangles().size();
    ASSERT_EQ(level.size(), triangles);
    ASSERT_EQ(margin.size(), triangles);
    ASSERT_EQ(reason.size(), triangles);
    // Pairs that are tested, and those without certificates.
    EXPECT_EQ(tested(explained), tube_steps.result.work.leaf_pairs);
    all_tested.step(next);
    EXPECT_EQ(explained.leaf_pairs[at(Reason::Certified)] + tested(explained),
              all_tested.result.work.leaf_pairs);
    if (k == 1) {
      EXPECT_THAT(level, Each(-1)) << "charts are built from the second step on";
      EXPECT_THAT(margin, Each(0));
      EXPECT_THAT(reason, Each(Reason::NotBuilt));
    }
  }
  const auto& [level, margin, reason] = tube_steps.result.explanation.objects[0];
  EXPECT_GT(count(reason, Reason::Certified), level.size() * 3 / 4);
  for (std::size_t t = 0; t < level.size(); ++t) {
    if (reason[t] == Reason::Certified) {
      ASSERT_GE(level[t], 0);
    }
  }
}

/// The mean margin of triangles with a level; the others have none.
double mean_margin(const Explanation::Object& object) {
  double sum = 0;
  std::size_t proven = 0;
  for (std::size_t t = 0; t < object.level.size(); ++t) {
    EXPECT_GE(object.margin[t], 0);
    EXPECT_LE(object.margin[t], 1);
    if (object.level[t] < 0) {
      EXPECT_EQ(object.margin[t], 0);
      continue;
    }
    sum += object.margin[t];
    ++proven;
  }
  EXPECT_GT(proven, object.level.size() / 2);
  return sum / static_cast<double>(proven);
}

TEST(Explanation, MarginsDecreaseWithTheDistanceFromTheChart) {
  Stepper steps(tube(0.5));
  for (int k = 0; k < 10; ++k) steps.step(tube(0.5).positions);
  const double still = mean_margin(steps.result.explanation.objects[0]);
  const double near = mean_margin(steps.step(tube(0.52).positions).objects[0]);
  const double far = mean_margin(steps.step(tube(0.6).positions).objects[0]);
  EXPECT_GT(still, 0.99);
  EXPECT_LT(near, still - 0.005);
  EXPECT_LT(far, near - 0.02);
}

/// Compares levels with the hierarchy: all triangles below a proven node have its level. Returns how many
/// leaves have a level.
std::size_t leaves_with_level(const Hierarchy& h, std::span<const std::int8_t> level) {
  std::size_t proven = 0;
  for (Index leaf = 0; leaf < h.leaf_count(); ++leaf) {
    const int depth = level[h.triangle_ids()[h.leaves()[leaf].triangles]];
    if (depth < 0) continue;
    Index node = 0;
    for (int k = 0; k < depth; ++k) {
      EXPECT_FALSE(h.nodes()[node].is_leaf());
      if (h.nodes()[node].is_leaf()) break;
      node = leaf < h.nodes()[h.nodes()[node].right].leaf_begin ? node + 1 : h.nodes()[node].right;
    }
    const Index begin = h.leaves()[h.nodes()[node].leaf_begin].triangles;
    const Index end = h.leaves()[h.nodes()[node].leaf_end].triangles;
    for (Index t = begin; t < end; ++t) EXPECT_EQ(level[h.triangle_ids()[t]], depth);
    ++proven;
  }
  return proven;
}

TEST(Explanation, ALevelIsThatOfANodeAboveAllItsTriangles) {
  Stepper steps(tube(0.5));
  for (int k = 1; k <= 10; ++k) steps.step(tube(0.5 + 0.02 * k).positions);
  EXPECT_GT(leaves_with_level(*steps.tree, steps.result.explanation.objects[0].level),
            steps.tree->leaf_count() / 2);
}

/// Copies of a mesh side by side, far from each other.
Mesh eight_copies(const Mesh& one) {
  std::vector<Triangle> triangles;
  std::vector<double> x;
  const Index vertices = one.topology.vertex_count();
  for (Index k = 0; k < 8; ++k) {
    for (const Triangle& t : one.topology.triangles())
      triangles.push_back({t[0] + k * vertices, t[1] + k * vertices, t[2] + k * vertices});
    for (std::size_t i = 0; i < one.positions.size(); ++i)
      x.push_back(one.positions[i] + (i % 3 == 0 ? 10.0 * k : 0));
  }
  return {*Topology::make(8 * vertices, std::move(triangles)), std::move(x)};
}

TEST(Explanation, ALevelMayBeThatOfALeaf) {
  // One leaf per copy. No chart proves two of them together: a chart covers one connected component.
  const Mesh squares = eight_copies(testing::cloth(2));
  Stepper steps(squares, {}, {.leaf_triangles = 8});
  ASSERT_EQ(steps.tree->leaf_count(), 8u);
  // Charts of larger nodes are tried first and fail.
  for (int k = 0; k < 12; ++k) steps.step(squares.positions);
  EXPECT_GT(leaves_with_level(*steps.tree, steps.result.explanation.objects[0].level), 0u);
  EXPECT_THAT(steps.result.explanation.objects[0].level, Each(AnyOf(-1, 3)));
}

/// The leaf that owns each triangle or vertex; `begin` is its first in leaf order.
std::vector<Index> owners(const Hierarchy& h, std::span<const Index> ids, Index Hierarchy::Leaf::*begin,
                          std::size_t count) {
  std::vector<Index> owner(count, kNoIndex);
  for (Index leaf = 0; leaf < h.leaf_count(); ++leaf) {
    for (Index i = h.leaves()[leaf].*begin; i < h.leaves()[leaf + 1].*begin; ++i) owner[ids[i]] = leaf;
  }
  return owner;
}

/// Counts the collisions of leaves without a common vertex, whose reason must be NearOther.
std::size_t expect_near(const Stepper& steps, const char* family) {
  const Hierarchy& h = *steps.tree;
  const PatchSlots slots(steps.tree);
  const auto of_face =
      owners(h, h.triangle_ids(), &Hierarchy::Leaf::triangles, h.topology().triangles().size());
  const auto of_vertex = owners(h, h.vertex_ids(), &Hierarchy::Leaf::vertices, h.topology().vertex_count());
  std::size_t count = 0;
  for (const VertexFaceCollision& c : steps.result.vertex_face) {
    const Index a = of_vertex[c.vertex], b = of_face[c.face];
    if (a == b || slots.of_leaves(a, b) != kNoIndex) continue;
    EXPECT_EQ(steps.result.explanation.objects[0].reason[c.face], Reason::NearOther) << family;
    ++count;
  }
  return count;
}

TEST(Explanation, CollidingTrianglesAreNotCertified) {
  oracle::Rng rng(7);
  std::size_t collisions = 0, near = 0, certified = 0;
  for (const oracle::MeshFamily& family : oracle::mesh_families()) {
    const oracle::Mesh mesh = family.make(rng);
    Stepper steps({mesh.topology(), mesh.positions});
    for (int k = 0; k < 12; ++k) {
      // Small steps, so that charts are built, then a large one.
      steps.step(oracle::deformed(mesh.positions, k % 4 == 3 ? 0.4 : 0.01, 0, rng));
      const auto& reason = steps.result.explanation.objects[0].reason;
      for (const VertexFaceCollision& c : steps.result.vertex_face) {
        EXPECT_NE(reason[c.face], Reason::Certified) << family.name;
      }
      if (k > 0) near += expect_near(steps, family.name);
      collisions += steps.result.vertex_face.size();
      certified += count(reason, Reason::Certified);
      EXPECT_EQ(count(reason, Reason::Off), 0u);
    }
  }
  EXPECT_GT(collisions, 100u);
  EXPECT_GT(near, 100u);
  EXPECT_GT(certified, 100u);
}

/// A sheet that is folded in half, with a gap between the halves; when it is negative they have swapped
/// sides.
Mesh folded(double gap) {
  Mesh sheet = testing::cloth(24);
  for (std::size_t i = 0; i < sheet.positions.size(); i += 3) {
    const double u = sheet.positions[i], side = u < 0.5 ? -1 : 1;
    sheet.positions[i] = std::abs(u - 0.5) * 2;
    sheet.positions[i + 2] = side * gap * std::min(1.0, 4 * sheet.positions[i]);
  }
  return sheet;
}

TEST(Explanation, PartsThatPassThroughEachOtherAreNearOther) {
  Stepper steps(folded(0.05));
  for (int k = 0; k < 6; ++k) steps.step(folded(0.05 - 0.001 * k).positions);
  EXPECT_LT(count(steps.result.explanation.objects[0].reason, Reason::NearOther), 300u);
  const Explanation& through = steps.step(folded(-0.05).positions);
  EXPECT_FALSE(steps.result.clean());
  EXPECT_GT(count(through.objects[0].reason, Reason::NearOther), 900u);  // of 1,152
  EXPECT_GT(through.leaf_pairs[at(Reason::NearOther)], 0u);
}

TEST(Explanation, LargePerturbationsFailTheCharts) {
  const Mesh sheet = testing::cloth(24);
  Stepper steps(sheet);
  std::uint64_t small = 0, large = 0;
  for (std::uint32_t k = 0; k < 20; ++k) {
    const std::uint64_t failed = steps.step(testing::perturbed(sheet.positions, k < 10 ? 0.001 : 0.03, k))
                                     .leaf_pairs[at(Reason::TestFailed)];
    if (k < 8) continue;  // charts are still being built
    (k < 10 ? small : large) = std::max(k < 10 ? small : large, failed);
  }
  EXPECT_GT(large, 100u);
  EXPECT_LT(small, large / 5);
}

TEST(Explanation, AClosedLeafIsTooCurved) {
  std::vector<Triangle> triangles;
  for (Index corner = 0; corner < 8; ++corner) {
    Triangle t{corner & 1, 2 + (corner >> 1 & 1), 4 + (corner >> 2)};
    if (std::popcount(corner) % 2 == 0) std::swap(t[0], t[1]);
    triangles.push_back(t);
  }
  const Mesh octahedra = eight_copies(
      {*Topology::make(6, std::move(triangles)), {-1, 0, 0, 1, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, -1, 0, 0, 1}});
  const std::vector<double>& x = octahedra.positions;
  Stepper steps(octahedra, {}, {.leaf_triangles = 8});
  ASSERT_EQ(steps.tree->leaf_count(), 8u);
  EXPECT_THAT(steps.step(x).objects[0].reason, Each(Reason::NotBuilt));
  for (int k = 0; k < 3; ++k) steps.step(x);
  EXPECT_THAT(steps.result.explanation.objects[0].reason, Each(Reason::TooCurved));
  EXPECT_THAT(steps.result.explanation.objects[0].level, Each(-1));
  EXPECT_EQ(steps.result.explanation.leaf_pairs[at(Reason::TooCurved)], 8u);
}

TEST(Explanation, WithoutCertificatesEverythingIsOff) {
  StepSettings settings;
  settings.certificates = false;
  Stepper steps(tube(0.5), settings);
  for (int k = 1; k <= 3; ++k) {
    const Explanation& explained = steps.step(tube(0.5 + 0.02 * k).positions);
    EXPECT_THAT(explained.objects[0].level, Each(-1));
    EXPECT_THAT(explained.objects[0].reason, Each(Reason::Off));
    EXPECT_EQ(explained.leaf_pairs[at(Reason::Off)], steps.result.work.leaf_pairs);
    EXPECT_EQ(explained.leaf_pairs[at(Reason::Certified)], 0u);
  }
}

/// Explanations of ten steps of two tubes that cross, and of the pose after each.
std::vector<Explanation> two_tubes() {
  const Mesh first = tube(0.5);
  const auto tree = std::make_shared<const Hierarchy>(*Hierarchy::build(first.topology, first.positions));
  StepChecker checker({tree, tree});
  StepSettings settings;
  settings.explain = true;
  std::vector<Explanation> all;
  const auto along = [](int k) { return tube(0.5 + 0.02 * k).positions; };
  const auto across = [&](int k) {
    std::vector<double> x = along(k);
    for (std::size_t i = 0; i < x.size(); i += 3) std::swap(x[i + 1], x[i + 2]);
    return x;
  };
  StepResult result;
  StaticResult pose;
  for (int k = 0; k < 10; ++k) {
    const auto a0 = along(k), b0 = across(k), a1 = along(k + 1), b1 = across(k + 1);
    const std::span<const double> from[] = {a0, b0}, to[] = {a1, b1};
    EXPECT_TRUE(checker.check(from, to, settings, result));
    all.push_back(result.explanation);
    EXPECT_TRUE(checker.check_static(to, settings, pose));
    EXPECT_EQ(tested(pose.explanation), pose.work.leaf_pairs);
    all.push_back(pose.explanation);
  }
  return all;
}

TEST(Explanation, IsTheSameForAnyNumberOfThreadsAndPerObject) {
  std::vector<Explanation> one, many;
  with_threads(1, [&] { one = two_tubes(); });
  with_threads(4, [&] { many = two_tubes(); });
  ASSERT_EQ(one.size(), many.size());
  for (std::size_t i = 0; i < one.size(); ++i) {
    ASSERT_EQ(one[i].objects.size(), 2u);
    const Reason crossing = i == 0 ? Reason::NotBuilt : Reason::NearOther;
    EXPECT_EQ(one[i].leaf_pairs, many[i].leaf_pairs);
    for (int object = 0; object < 2; ++object) {
      EXPECT_EQ(one[i].objects[object].level, many[i].objects[object].level);
      EXPECT_EQ(one[i].objects[object].reason, many[i].objects[object].reason);
      EXPECT_GT(count(one[i].objects[object].reason, crossing), 0u);
    }
  }
  EXPECT_GT(count(one.back().objects[1].reason, Reason::Certified), 1000u);
}

}  // namespace
}  // namespace foldproof
