// Hierarchies of every shape with up to six leaves: each feature has one owner, each two leaves meet once, in
// however many tasks, and each pair of features is a candidate once (docs/soundness.md, C1, V1 and R4).
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "bvh/meshes.h"
#include "bvh/traverse.h"

namespace foldproof {
namespace {

// The shapes of binary trees with this many leaves: per node in depth-first order 1 for a leaf and 0 for an
// inner node.
std::vector<std::vector<Index>> shapes(Index leaves) {
  if (leaves == 1) return {{1}};
  std::vector<std::vector<Index>> all;
  for (Index left = 1; left < leaves; ++left) {
    for (const auto& a : shapes(left)) {
      for (const auto& b : shapes(leaves - left)) {
        std::vector<Index>& shape = all.emplace_back(1, 0);
        shape.insert(shape.end(), a.begin(), a.end());
        shape.insert(shape.end(), b.begin(), b.end());
      }
    }
  }
  return all;
}

// Strips have common edges, fans a common vertex; soups have neither.
std::vector<testing::Mesh> meshes(Index triangles) {
  std::vector<Triangle> strip, fan, soup;
  for (Index t = 0; t < triangles; ++t) {
    strip.push_back({t, t + 1, t + 2});
    fan.push_back({0, t + 1, t + 2});
    soup.push_back({3 * t, 3 * t + 1, 3 * t + 2});
  }
  std::vector<testing::Mesh> all;
  for (auto& list : {strip, fan, soup}) {
    const Index vertices = list.back()[2] + 1;
    std::vector<double> x(3 * std::size_t{vertices});
    for (std::size_t i = 0; i < x.size(); ++i) x[i] = 0.01 * static_cast<double>(i * i % 17);
    all.push_back({*Topology::make(vertices, list), x});
  }
  return all;
}

// Calls `visit` with every hierarchy of each mesh and shape.
template <class Visit>
void for_each_tree(Visit visit) {
  int trees = 0;
  for (Index leaves = 1; leaves <= 6; ++leaves) {
    for (const auto& shape : shapes(leaves)) {
      for (const testing::Mesh& mesh : meshes(leaves)) {
        std::vector<Index> triangles(leaves);
        for (Index t = 0; t < leaves; ++t)
          triangles[t] = (t * 5 + 1) % leaves;  // a permutation, except for 5 leaves
        if (leaves == 5) triangles = {3, 0, 4, 1, 2};
        auto hierarchy = Hierarchy::from_parts(mesh.topology, triangles, shape);
        ASSERT_TRUE(hierarchy);
        visit(std::make_shared<const Hierarchy>(*std::move(hierarchy)), mesh.positions);
        ++trees;
      }
    }
  }
  EXPECT_EQ(trees, 3 * (1 + 1 + 2 + 5 + 14 + 42));
}

using Pairs = std::map<std::pair<Index, Index>, int>;

void count(Pairs& pairs, Index a, Index b) { ++pairs[std::minmax(a, b)]; }

template <class A, class B>
bool share(const A& a, const B& b) {
  return std::any_of(a.begin(), a.end(), [&](Index v) { return std::count(b.begin(), b.end(), v) > 0; });
}

// Everything is near everything.
constexpr float kMargin = 4;

TEST(Trees, EachFeatureHasOneOwnerThatHasIt) {
  for_each_tree([](const std::shared_ptr<const Hierarchy>& h, const std::vector<double>&) {
    const Topology& topology = h->topology();
    std::vector<Index> ids[3] = {{h->vertex_ids().begin(), h->vertex_ids().end()},
                                 {h->edge_ids().begin(), h->edge_ids().end()},
                                 {h->triangle_ids().begin(), h->triangle_ids().end()}};
    const std::size_t sizes[3] = {topology.vertex_count(), topology.edges().size(),
                                  topology.triangles().size()};
    for (int kind = 0; kind < 3; ++kind) {
      std::sort(ids[kind].begin(), ids[kind].end());
      ASSERT_EQ(ids[kind].size(), sizes[kind]);
      for (Index k = 0; k < sizes[kind]; ++k) ASSERT_EQ(ids[kind][k], k);
    }
    const auto leaves = h->leaves();
    ASSERT_EQ(leaves[h->leaf_count()].vertices, sizes[0]);
    ASSERT_EQ(leaves[h->leaf_count()].edges, sizes[1]);
    ASSERT_EQ(leaves[h->leaf_count()].triangles, sizes[2]);
    for (Index leaf = 0; leaf < h->leaf_count(); ++leaf) {
      ASSERT_EQ(leaves[leaf + 1].triangles, leaves[leaf].triangles + 1);
      const Triangle& own = h->triangles()[leaves[leaf].triangles];
      for (Index v = leaves[leaf].vertices; v < leaves[leaf + 1].vertices; ++v)
        ASSERT_EQ(std::count(own.begin(), own.end(), v), 1);
      for (Index e = leaves[leaf].edges; e < leaves[leaf + 1].edges; ++e) {
        for (const Index v : h->edges()[e]) ASSERT_EQ(std::count(own.begin(), own.end(), v), 1);
      }
    }
  });
}

TEST(Trees, EachTwoLeavesMeetOnceInSubtreesOfAnySize) {
  for_each_tree([](const std::shared_ptr<const Hierarchy>& h, const std::vector<double>& x) {
    KineticBvh bvh(h);
    bvh.refit({}, x, x);
    const Traversal traversal{&bvh, &bvh, kMargin};
    for (Index max_leaves = 1; max_leaves <= 10; ++max_leaves) {
      const Subtrees subtrees(*h, max_leaves);
      TraversalResult near, found;
      std::vector<NodePair> stack;
      for (const NodeIndex node : subtrees.top)
        find_subtree_pairs(traversal, children_of(h->nodes(), node), max_leaves, stack, near);
      for (const NodeIndex root : subtrees.roots) near.subtree_pairs.push_back({root, root});
      for (const NodePair start : near.subtree_pairs) traverse(traversal, start, stack, found);
      Pairs pairs;
      for (const LeafPair pair : found.leaf_pairs) count(pairs, pair.a, pair.b);
      ASSERT_EQ(pairs.size(), h->leaf_count() * (h->leaf_count() + 1) / 2);
      for (const auto& [pair, times] : pairs) ASSERT_EQ(times, 1);
    }
  });
}

TEST(Trees, EachPairOfFeaturesIsACandidateOnce) {
  for_each_tree([](const std::shared_ptr<const Hierarchy>& h, const std::vector<double>& x) {
    KineticBvh bvh(h);
    bvh.refit({}, x, x);
    for (Index leaf = 0; leaf < h->leaf_count(); ++leaf) bvh.fill_features(LeafIndex(leaf));
    const Traversal traversal{&bvh, &bvh, kMargin};
    TraversalResult found;
    std::vector<NodePair> stack;
    traverse(traversal, NodePair{}, stack, found);
    CandidateBuffer candidates;
    for (const LeafPair leaves : found.leaf_pairs) find_candidates(traversal, leaves, candidates);
    ASSERT_TRUE(candidates[FeaturePair::FaceVertex].empty());
    Pairs vertex_face, edge_edge;
    for (const auto& [v, f] : candidates[FeaturePair::VertexFace]) ++vertex_face[{v, f}];
    for (const auto& [a, b] : candidates[FeaturePair::EdgeEdge]) count(edge_edge, a, b);
    for (Index v = 0; v < h->vertex_ids().size(); ++v) {
      for (Index f = 0; f < h->triangles().size(); ++f)
        ASSERT_EQ((vertex_face[{v, f}]), !share(std::array{v}, h->triangles()[f]));
    }
    for (Index a = 0; a < h->edges().size(); ++a) {
      for (Index b = a; b < h->edges().size(); ++b)
        ASSERT_EQ((edge_edge[{a, b}]), !share(h->edges()[a], h->edges()[b]));
    }
  });
}

TEST(Trees, TwoHierarchiesMeetInEachPairOfLeavesOnce) {
  std::vector<std::unique_ptr<KineticBvh>> all;
  for_each_tree([&](const std::shared_ptr<const Hierarchy>& h, const std::vector<double>& x) {
    if (h->leaf_count() > 4) return;
    all.push_back(std::make_unique<KineticBvh>(h));
    all.back()->refit({}, x, x);
  });
  for (const auto& a : all) {
    for (const auto& b : all) {
      if (a == b) continue;
      TraversalResult found;
      std::vector<NodePair> stack;
      traverse({a.get(), b.get(), kMargin}, NodePair{}, stack, found);
      std::map<std::pair<Index, Index>, int> pairs;
      for (const LeafPair pair : found.leaf_pairs) ++pairs[{pair.a, pair.b}];
      ASSERT_EQ(pairs.size(), a->hierarchy->leaf_count() * b->hierarchy->leaf_count());
      for (const auto& [pair, times] : pairs) ASSERT_EQ(times, 1);
    }
  }
}

}  // namespace
}  // namespace foldproof
