#include "bvh/traverse.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "bvh/meshes.h"
#include "foldproof/ccd.h"
#include "oracle/one_target.h"

namespace foldproof {
namespace {

using foldproof::testing::Mesh;

struct Moving {
  KineticBvh bvh;
  std::vector<double> x0, x1;
};

Moving moving(const Mesh& mesh, double amount, std::uint32_t seed, Index leaf_triangles,
              const Frame& frame = {}) {
  auto hierarchy = Hierarchy::build(mesh.topology, mesh.positions, {leaf_triangles});
  Moving m{KineticBvh(std::make_shared<Hierarchy>(std::move(*hierarchy))), mesh.positions,
           testing::perturbed(mesh.positions, amount, seed)};
  m.bvh.refit(frame, m.x0, m.x1);
  for (Index leaf = 0; leaf < m.bvh.hierarchy->leaf_count(); ++leaf) m.bvh.fill_features(LeafIndex(leaf));
  return m;
}

using Ids = std::vector<Index>;

// The gap between kinetic boxes, in double: the maximum over the six sides of the smaller gap of both ends.
double expected_gap(const Moving& a, const Ids& feature_a, const Moving& b, const Ids& feature_b) {
  double best = -1e300;
  for (int axis = 0; axis < 3; ++axis) {
    double above = 1e300, below = 1e300;
    for (const auto& [xa, xb] : {std::pair(&a.x0, &b.x0), std::pair(&a.x1, &b.x1)}) {
      double low_a = 1e300, high_a = -1e300, low_b = 1e300, high_b = -1e300;
      for (const Index v : feature_a) {
        low_a = std::min(low_a, (*xa)[3 * v + axis]);
        high_a = std::max(high_a, (*xa)[3 * v + axis]);
      }
      for (const Index v : feature_b) {
        low_b = std::min(low_b, (*xb)[3 * v + axis]);
        high_b = std::max(high_b, (*xb)[3 * v + axis]);
      }
      above = std::min(above, low_b - high_a);
      below = std::min(below, low_a - high_b);
    }
    best = std::max({best, above, below});
  }
  return best;
}

bool share(const Ids& a, const Ids& b) {
  return std::any_of(a.begin(), a.end(), [&](Index v) { return std::count(b.begin(), b.end(), v) > 0; });
}

// All features by the user's ids: vertices, edges or triangles.
std::vector<Ids> features(const Moving& m, int corners) {
  std::vector<Ids> all;
  const Hierarchy& h = *m.bvh.hierarchy;
  if (corners == 1)
    for (const Index v : h.vertex_ids()) all.push_back({v});
  if (corners == 2)
    for (const Index e : h.edge_ids())
      all.push_back({h.topology().edges()[e][0], h.topology().edges()[e][1]});
  if (corners == 3) {
    for (const Index t : h.triangle_ids()) {
      const Triangle& v = h.topology().triangles()[t];
      all.push_back({v[0], v[1], v[2]});
    }
  }
  return all;  // leaf order
}

CandidateBuffer all_candidates(const Moving& a, const Moving& b, float margin) {
  CandidateBuffer found;
  const Traversal traversal{&a.bvh, &b.bvh, margin};
  std::vector<NodePair> stack;
  TraversalResult result;
  traverse(traversal, NodePair{}, stack, result);
  EXPECT_GE(result.node_tests, result.leaf_pairs.size());
  for (const LeafPair leaves : result.leaf_pairs) find_candidates(traversal, leaves, found);
  return found;
}

// The largest cell of a leaf's grid (docs/soundness.md, B4).
double max_cell_size(const Moving& m) {
  float min_scale = std::numeric_limits<float>::infinity();
  for (const LeafGrid& grid : m.bvh.grids)
    min_scale = std::min(min_scale, *std::min_element(grid.scale, grid.scale + 8));
  return 1 / min_scale;
}

// Whether the narrow phase proves the pair farther apart than the distance.
bool is_separated(const Moving& a, const Ids& feature_a, const Moving& b, const Ids& feature_b,
                  double distance) {
  FourPoints x0, x1;
  std::size_t k = 0;
  const auto add = [&](const Moving& m, const Ids& feature) {
    for (const Index v : feature) {
      x0[k] = Vec3(m.x0[3 * v], m.x0[3 * v + 1], m.x0[3 * v + 2]);
      x1[k++] = Vec3(m.x1[3 * v], m.x1[3 * v + 1], m.x1[3 * v + 2]);
    }
  };
  const bool swapped = feature_b.size() == 1;
  swapped ? add(b, feature_b) : add(a, feature_a);
  swapped ? add(a, feature_a) : add(b, feature_b);
  const CcdSettings settings{.thickness = distance};
  const CcdResult result =
      feature_a.size() == 2 ? edge_edge_ccd(x0, x1, settings) : vertex_face_ccd(x0, x1, settings);
  return result.answer == Answer::Separated;
}

// Every pair that comes within the distance is found exactly once, no pair whose boxes are clearly farther,
// and no incident pair.
void expect_complete(const Moving& a, const Moving& b, int corners_a, int corners_b, double distance,
                     const std::vector<CandidatePair>& found) {
  const bool same = &a == &b;
  const auto fa = features(a, corners_a), fb = features(b, corners_b);
  std::map<std::pair<Index, Index>, int> counts;
  for (auto [i, k] : found) {
    if (same && corners_a == corners_b && k < i) std::swap(i, k);
    ++counts[{i, k}];
  }
  const double grid = 2 * std::max(max_cell_size(a), max_cell_size(b));
  std::size_t near = 0, dropped = 0;
  for (Index i = 0; i < fa.size(); ++i) {
    for (Index k = same && corners_a == corners_b ? i + 1 : 0; k < fb.size(); ++k) {
      const int seen = counts.count({i, k}) ? counts[{i, k}] : 0;
      const double gap = expected_gap(a, fa[i], b, fb[k]);
      if (same && share(fa[i], fb[k])) {
        EXPECT_EQ(seen, 0);
      } else if (gap <= distance) {
        ++near;
        EXPECT_LE(seen, 1) << "found twice";
        if (seen == 1) continue;
        ++dropped;
        EXPECT_TRUE(is_separated(a, fa[i], b, fb[k], distance)) << "missed";
      } else if (gap > distance + grid + 4e-6) {
        EXPECT_EQ(seen, 0) << "gap " << gap << " is wide";
      }
    }
  }
  EXPECT_GT(near, dropped);
  EXPECT_GT(dropped, near / 4) << "what cannot touch is dropped";
}

TEST(Traverse, FindsEachNearPairOfFeaturesOnceWithinAnObject) {
  for (const Index leaf : {1u, 5u, 16u}) {
    for (const Mesh& mesh : {testing::cloth(9), testing::soup(120, 3)}) {
      for (const double distance : {0.0, 0.03}) {
        const Moving m = moving(mesh, 0.15, 7, leaf);
        const auto found = all_candidates(m, m, separation_margin({}, distance));
        EXPECT_TRUE(found[FeaturePair::FaceVertex].empty());
        expect_complete(m, m, 1, 3, distance, found[FeaturePair::VertexFace]);
        expect_complete(m, m, 2, 2, distance, found[FeaturePair::EdgeEdge]);
      }
    }
  }
}

TEST(Traverse, FindsEachNearPairOfFeaturesOnceBetweenObjects) {
  const Moving a = moving(testing::cloth(7), 0.2, 1, 4), b = moving(testing::soup(90, 5), 0.2, 2, 16);
  auto found = all_candidates(a, b, separation_margin({}, 0.01));
  expect_complete(a, b, 1, 3, 0.01, found[FeaturePair::VertexFace]);
  expect_complete(a, b, 2, 2, 0.01, found[FeaturePair::EdgeEdge]);
  expect_complete(a, b, 3, 1, 0.01, found[FeaturePair::FaceVertex]);
}

TEST(Traverse, SeparatesFlatLeaves) {
  // Two flat sheets, one a little above the other: their triangles have boxes without a height.
  Mesh low = testing::cloth(6), high = low;
  for (std::size_t i = 2; i < low.positions.size(); i += 3) {
    low.positions[i] = 0;
    high.positions[i] = 1e-3;
  }
  const Moving a = moving(low, 0, 1, 4), b = moving(high, 0, 1, 4);
  const Traversal traversal{&a.bvh, &b.bvh, separation_margin({}, 0)};
  CandidateBuffer found;
  for (Index i = 0; i < a.bvh.hierarchy->leaf_count(); ++i) {
    for (Index k = 0; k < b.bvh.hierarchy->leaf_count(); ++k)
      find_candidates(traversal, {LeafIndex(i), LeafIndex(k)}, found);
  }
  EXPECT_TRUE(found[FeaturePair::VertexFace].empty() && found[FeaturePair::FaceVertex].empty() &&
              found[FeaturePair::EdgeEdge].empty());
}

TEST(Traverse, AMarginBeyondTheFrameFindsEverything) {
  const Moving a = moving(testing::cloth(5), 0.1, 1, 4), b = moving(testing::soup(20, 5), 0.1, 2, 16);
  for (const double distance : {3.0, 1e20, 1e300}) {
    const auto found = all_candidates(a, b, separation_margin({}, distance));
    EXPECT_EQ(found[FeaturePair::EdgeEdge].size(),
              a.bvh.hierarchy->edges().size() * b.bvh.hierarchy->edges().size());
    EXPECT_EQ(found[FeaturePair::VertexFace].size(),
              a.bvh.hierarchy->vertex_ids().size() * b.bvh.hierarchy->triangles().size());
  }
}

TEST(Traverse, AllInstructionSetsFindTheSameCandidates) {
  testing::expect_all_targets_agree([] {
    const Moving m = moving(testing::soup(300, 4), 0.1, 7, 16);
    const auto found = all_candidates(m, m, separation_margin({}, 0.01));
    std::vector<Index> all;
    for (const auto* list : {&found[FeaturePair::VertexFace], &found[FeaturePair::EdgeEdge]}) {
      for (const CandidatePair& pair : *list) all.insert(all.end(), {pair.a, pair.b});
    }
    EXPECT_GT(all.size(), 1000u);
    return all;
  });
}

TEST(Traverse, SubtreesAndTheirPairsHaveTheSameLeafPairs) {
  const Moving m = moving(testing::cloth(20), 0.05, 3, 4);
  const Traversal traversal{&m.bvh, &m.bvh, separation_margin({}, 0)};
  std::vector<NodePair> stack;
  TraversalResult whole;
  traverse(traversal, NodePair{}, stack, whole);
  const auto sorted = [](const std::vector<LeafPair>& pairs) {
    std::multiset<std::pair<Index, Index>> set;
    for (const LeafPair p : pairs) set.insert({p.a, p.b});
    return set;
  };
  for (const Index max_leaves : {1u, 7u, 50u, 10000u}) {
    const Subtrees subtrees(*m.bvh.hierarchy, max_leaves);
    EXPECT_EQ(subtrees.top.empty(), max_leaves == 10000);
    TraversalResult near, cut;
    for (const NodeIndex node : subtrees.top)
      find_subtree_pairs(traversal, children_of(m.bvh.hierarchy->nodes(), node), max_leaves, stack, near);
    for (const NodeIndex root : subtrees.roots) near.subtree_pairs.push_back({root, root});
    for (const NodePair start : near.subtree_pairs) traverse(traversal, start, stack, cut);
    EXPECT_EQ(sorted(whole.leaf_pairs), sorted(cut.leaf_pairs)) << max_leaves;
  }
}

// Theorem 1: the kinetic box bounds its vertices at every time, up to the rounding that the margin covers.
TEST(KineticBox, BoundsItsVerticesAtEveryTime) {
  const Frame frame{{0.5, 0.5, 0}, 0.25};
  const Moving m = moving(testing::cloth(12), 0.4, 11, 8, frame);
  const Hierarchy& h = *m.bvh.hierarchy;
  for (Index node = 0; node < h.nodes().size(); ++node) {
    const auto& box = m.bvh.boxes[node].x;
    const Index first = h.leaves()[h.nodes()[node].leaf_begin].triangles;
    const Index last = h.leaves()[h.nodes()[node].leaf_end].triangles;
    for (Index t = first; t < last; ++t) {
      for (const Index v : h.topology().triangles()[h.triangle_ids()[t]]) {
        for (int axis = 0; axis < 3; ++axis) {
          for (const double time : {0.0, 0.3, 0.5, 0.9, 1.0}) {
            const double x = (1 - time) * m.x0[3 * v + axis] + time * m.x1[3 * v + axis];
            const double y = (x - frame.center[axis]) * frame.scale;
            EXPECT_GE(y, (1 - time) * box[0][0][axis] + time * box[1][0][axis] - 1e-7);
            EXPECT_LE(y, -((1 - time) * box[0][1][axis] + time * box[1][1][axis]) + 1e-7);
          }
        }
      }
    }
  }
}

TEST(SeparationMargin, IsNeverBelowTheDistanceInTheFrame) {
  for (const double distance : {0.0, 1e-12, 0.3, 1e20}) {
    const Frame frame{Vec3::Zero(), 0.125};
    EXPECT_GE(separation_margin(frame, distance), distance * 0.125);
    EXPECT_GT(separation_margin(frame, distance), 0x1p-22);
  }
  EXPECT_LT(separation_margin({}, 1e300), std::numeric_limits<float>::infinity());
}

}  // namespace
}  // namespace foldproof
