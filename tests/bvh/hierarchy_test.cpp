#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "bvh/meshes.h"

namespace foldproof {
namespace {

using foldproof::testing::Mesh;
using ::testing::HasSubstr;

Hierarchy build(const Mesh& mesh, Index leaf_triangles = 16) {
  auto tree = Hierarchy::build(mesh.topology, mesh.positions, {leaf_triangles});
  EXPECT_TRUE(tree) << tree.error().line();
  return std::move(*tree);
}

std::vector<Mesh> all_meshes() {
  return {testing::cloth(1), testing::cloth(40), testing::soup(300, 1), testing::soup(1, 2), testing::odd()};
}

// The ids are a permutation of the expected ones.
void expect_permutation(std::span<const Index> ids, const std::set<Index>& expected) {
  EXPECT_EQ(ids.size(), expected.size());
  EXPECT_EQ(std::set<Index>(ids.begin(), ids.end()), expected);
}

TEST(Hierarchy, EveryFeatureHasExactlyOneOwner) {
  for (const Mesh& mesh : all_meshes()) {
    const Hierarchy tree = build(mesh, 8);
    std::set<Index> vertices, edges, triangles;
    for (Index t = 0; t < mesh.topology.triangles().size(); ++t) {
      triangles.insert(t);
      for (const Index v : mesh.topology.triangles()[t]) vertices.insert(v);
    }
    for (Index e = 0; e < mesh.topology.edges().size(); ++e) edges.insert(e);
    expect_permutation(tree.vertex_ids(), vertices);
    expect_permutation(tree.edge_ids(), edges);
    expect_permutation(tree.triangle_ids(), triangles);
  }
}

TEST(Hierarchy, LeafOrderNamesTheUsersFeatures) {
  for (const Mesh& mesh : all_meshes()) {
    const Hierarchy tree = build(mesh);
    for (std::size_t k = 0; k < tree.triangles().size(); ++k) {
      for (int c = 0; c < 3; ++c) {
        EXPECT_EQ(tree.vertex_ids()[tree.triangles()[k][c]],
                  mesh.topology.triangles()[tree.triangle_ids()[k]][c]);
      }
    }
    for (std::size_t k = 0; k < tree.edges().size(); ++k) {
      const Edge& user = mesh.topology.edges()[tree.edge_ids()[k]];
      EXPECT_EQ(tree.vertex_ids()[tree.edges()[k][0]], user[0]);
      EXPECT_EQ(tree.vertex_ids()[tree.edges()[k][1]], user[1]);
    }
  }
}

// A leaf owns only features of its own triangles, so a box around the triangles bounds all it owns.
TEST(Hierarchy, LeavesOwnFeaturesOfTheirTriangles) {
  for (const Mesh& mesh : all_meshes()) {
    const Hierarchy tree = build(mesh, 4);
    for (Index leaf = 0; leaf < tree.leaf_count(); ++leaf) {
      const auto begin = tree.leaves()[leaf], end = tree.leaves()[leaf + 1];
      std::set<Index> vertices;
      std::set<Edge> edges;
      for (Index t = begin.triangles; t < end.triangles; ++t) {
        for (int c = 0; c < 3; ++c) {
          const Index a = tree.triangles()[t][c], b = tree.triangles()[t][(c + 1) % 3];
          vertices.insert(a);
          edges.insert({std::min(a, b), std::max(a, b)});
        }
      }
      for (Index v = begin.vertices; v < end.vertices; ++v) EXPECT_TRUE(vertices.count(v));
      for (Index e = begin.edges; e < end.edges; ++e) {
        const Edge edge = tree.edges()[e];
        EXPECT_TRUE(edges.count({std::min(edge[0], edge[1]), std::max(edge[0], edge[1])}));
      }
    }
  }
}

TEST(Hierarchy, NodesNestAndCoverTheLeaves) {
  for (const Mesh& mesh : all_meshes()) {
    const Hierarchy tree = build(mesh, 4);
    EXPECT_EQ(tree.nodes()[0].leaf_begin, 0u);
    EXPECT_EQ(tree.nodes()[0].leaf_end, tree.leaf_count());
    for (Index i = 0; i < tree.nodes().size(); ++i) {
      const auto& node = tree.nodes()[i];
      if (node.is_leaf()) {
        EXPECT_EQ(node.leaf_end, node.leaf_begin + 1);
        continue;
      }
      ASSERT_GT(node.right, i + 1);
      EXPECT_EQ(tree.nodes()[i + 1].leaf_begin, node.leaf_begin);
      EXPECT_EQ(tree.nodes()[i + 1].leaf_end, tree.nodes()[node.right].leaf_begin);
      EXPECT_EQ(tree.nodes()[node.right].leaf_end, node.leaf_end);
    }
  }
}

TEST(Hierarchy, LeavesAreFullAndNeverTooLarge) {
  const Mesh mesh = testing::cloth(50);
  const Hierarchy tree = build(mesh, 16);
  for (Index leaf = 0; leaf < tree.leaf_count(); ++leaf) {
    EXPECT_LE(tree.leaves()[leaf + 1].triangles - tree.leaves()[leaf].triangles, 20u);
  }
  EXPECT_LE(tree.leaf_count(), 5000u / 16 * 9 / 8);
}

// The number of components of a leaf's triangles, connected over common edges.
int component_count(const Hierarchy& tree, Index leaf) {
  const Index begin = tree.leaves()[leaf].triangles, end = tree.leaves()[leaf + 1].triangles;
  std::vector<Index> group(end - begin);
  for (Index i = 0; i < group.size(); ++i) group[i] = i;
  int components = static_cast<int>(group.size());
  for (Index i = 0; i < group.size(); ++i) {
    for (Index k = 0; k < i; ++k) {
      int common = 0;
      for (const Index v : tree.triangles()[begin + i]) {
        for (const Index w : tree.triangles()[begin + k]) common += v == w;
      }
      if (common < 2 || group[i] == group[k]) continue;
      --components;
      const Index old = group[i];
      for (Index& g : group) g = g == old ? group[k] : g;
    }
  }
  return components;
}

TEST(Hierarchy, LeavesAreConnectedPiecesOfSurface) {
  const Hierarchy tree = build(testing::cloth(50), 16);
  int connected = 0;
  for (Index leaf = 0; leaf < tree.leaf_count(); ++leaf) connected += component_count(tree, leaf) == 1;
  EXPECT_GE(connected, 0.95 * tree.leaf_count());
}

TEST(Hierarchy, RejectsBadPositions) {
  Mesh mesh = testing::cloth(2);
  mesh.positions[7] = std::nan("");
  auto tree = Hierarchy::build(mesh.topology, mesh.positions);
  ASSERT_FALSE(tree);
  EXPECT_THAT(tree.error().line(), HasSubstr("vertex 2: has a coordinate that is not finite"));
  mesh.positions.pop_back();
  tree = Hierarchy::build(mesh.topology, mesh.positions);
  ASSERT_FALSE(tree);
  EXPECT_THAT(tree.error().line(), HasSubstr("26 numbers for 9 vertices"));
}

TEST(Hierarchy, RejectsATopologyThatWasMovedAway) {
  Mesh mesh = testing::cloth(2);
  const Topology taken = std::move(mesh.topology);
  for (const Topology& empty : {mesh.topology, Topology()}) {  // NOLINT(bugprone-use-after-move): as it says
    const auto tree = Hierarchy::build(empty, std::vector<double>(std::size_t{empty.vertex_count()} * 3));
    ASSERT_FALSE(tree);
    EXPECT_THAT(tree.error().line(), HasSubstr("has no triangles"));
  }
}

TEST(Hierarchy, LeavesMayHoldMoreThanThereIs) {
  const Mesh mesh = testing::cloth(4);
  for (const Index most : {32u, 3435973837u, kNoIndex}) {
    const auto tree = Hierarchy::build(mesh.topology, mesh.positions, {.leaf_triangles = most});
    ASSERT_TRUE(tree);
    EXPECT_EQ(tree->leaf_count(), 1u);
  }
}

// The argument of from_parts.
std::vector<Index> leaf_sizes(const Hierarchy& tree) {
  std::vector<Index> sizes;
  for (const Hierarchy::Node& node : tree.nodes()) {
    const Index leaf = node.leaf_begin;
    sizes.push_back(node.is_leaf() ? tree.leaves()[leaf + 1].triangles - tree.leaves()[leaf].triangles : 0);
  }
  return sizes;
}

std::vector<Index> triangle_order(const Hierarchy& tree) {
  return {tree.triangle_ids().begin(), tree.triangle_ids().end()};
}

TEST(Hierarchy, IsRestoredFromItsParts) {
  for (const Mesh& mesh : all_meshes()) {
    const Hierarchy tree = build(mesh, 8);
    const auto again = Hierarchy::from_parts(mesh.topology, triangle_order(tree), leaf_sizes(tree));
    ASSERT_TRUE(again) << again.error().line();
    EXPECT_EQ(again->topology(), tree.topology());
    EXPECT_TRUE(std::ranges::equal(again->vertex_ids(), tree.vertex_ids()));
    EXPECT_TRUE(std::ranges::equal(again->edge_ids(), tree.edge_ids()));
    EXPECT_TRUE(std::ranges::equal(again->triangle_ids(), tree.triangle_ids()));
    EXPECT_TRUE(std::ranges::equal(again->triangles(), tree.triangles()));
    EXPECT_TRUE(std::ranges::equal(again->edges(), tree.edges()));
    const auto same_leaf = [](const Hierarchy::Leaf& a, const Hierarchy::Leaf& b) {
      return a.triangles == b.triangles && a.edges == b.edges && a.vertices == b.vertices;
    };
    EXPECT_TRUE(std::ranges::equal(again->leaves(), tree.leaves(), same_leaf));
    const auto same_node = [](const Hierarchy::Node& a, const Hierarchy::Node& b) {
      return a.right == b.right && a.leaf_begin == b.leaf_begin && a.leaf_end == b.leaf_end;
    };
    EXPECT_TRUE(std::ranges::equal(again->nodes(), tree.nodes(), same_node));
  }
}

TEST(Hierarchy, RejectsPartsThatAreNoTree) {
  const Mesh mesh = testing::cloth(2);  // 8 triangles
  const std::vector<Index> order{0, 1, 2, 3, 4, 5, 6, 7};
  const auto error_of = [&](std::vector<Index> triangles, std::vector<Index> sizes) {
    const auto tree = Hierarchy::from_parts(mesh.topology, std::move(triangles), sizes);
    return tree ? "no error" : tree.error().line();
  };
  EXPECT_EQ(error_of(order, {8}), "no error");
  EXPECT_EQ(error_of(order, {0, 0, 1, 2, 5}), "no error");
  EXPECT_EQ(error_of(order, {0, 1, 0, 2, 5}), "no error");
  const std::vector<std::vector<Index>> bad{
      {},        {0},          {0, 8}, {8, 0},       {4, 4}, {0, 4, 3},    {0, 4, 5},         {0, 4, 0},
      {0, 0, 8}, {0, 2, 2, 4}, {7},    {0, 0, 3, 5}, {9},    {0, 4, 4, 0}, {0, 0xffffffff, 9}};
  for (const auto& sizes : bad) {
    EXPECT_THAT(error_of(order, sizes), HasSubstr("nodes: do not form a tree")) << sizes.size();
  }
  EXPECT_THAT(error_of({0, 1, 2, 3, 4, 5, 6, 6}, {8}), HasSubstr("does not name every triangle once"));
  EXPECT_THAT(error_of({0, 1, 2, 3, 4, 5, 6, 8}, {8}), HasSubstr("does not name every triangle once"));
  EXPECT_THAT(error_of({0, 1, 2}, {3}), HasSubstr("does not name every triangle once"));
}

// Queries may recurse over levels.
TEST(Hierarchy, RejectsAChainOfLeaves) {
  const Mesh mesh = testing::cloth(23);
  const auto count = static_cast<Index>(mesh.topology.triangles().size());
  std::vector<Index> order(count);
  std::iota(order.begin(), order.end(), 0u);
  for (const Index leaves : {1024u, 1025u}) {
    std::vector<Index> sizes;
    for (Index k = 1; k < leaves; ++k) sizes.insert(sizes.end(), {0, 1});
    sizes.push_back(count - (leaves - 1));
    const auto tree = Hierarchy::from_parts(mesh.topology, order, sizes);
    EXPECT_EQ(tree ? "no error" : tree.error().line(),
              leaves == 1024 ? "no error" : "nodes: have more than 1024 levels; build it again");
  }
}

TEST(Hierarchy, HandlesTheLargestDoubles) {
  Mesh mesh = testing::cloth(8);
  for (double& c : mesh.positions) c = (c - 0.5) * 1.7e308;
  EXPECT_EQ(build(mesh, 4).triangle_ids().size(), 128u);
}

// No chart fails for the sake of a line, and whole leaves are left out of tests of vertices.
TEST(Hierarchy, FacesLinesAndPointsHaveLeavesOfTheirOwn) {
  const Mesh cloth = testing::cloth(12);
  const Index n = cloth.topology.vertex_count();
  std::vector<double> positions = cloth.positions;
  std::vector<Edge> lines;
  std::vector<Index> points;
  for (Index k = 0; k < 40; ++k) {
    lines.push_back({k, n + k});  // hairs
    points.push_back(n + 40 + k);
  }
  for (Index k = 0; k < 80; ++k) positions.insert(positions.end(), {0.001 * k, 0.5, 0.5 + 0.0001 * k});
  const auto faces = cloth.topology.triangles();
  const Hierarchy alone = build(cloth, 8);
  for (const bool with_faces : {true, false}) {
    for (const bool with_points : {true, false}) {
      auto topology = Topology::make(
          n + 80, with_faces ? std::vector(faces.begin(), faces.end()) : std::vector<Triangle>(), lines,
          with_points ? points : std::vector<Index>());
      const Hierarchy tree = Hierarchy::build(*topology, positions, {8}).value();
      std::array<Index, 3> leaves{};
      for (Index leaf = 0; leaf < tree.leaf_count(); ++leaf) {
        const Element element = tree.element(leaf);
        ++leaves[static_cast<std::size_t>(element)];
        for (Index t = tree.leaves()[leaf].triangles; t < tree.leaves()[leaf + 1].triangles; ++t)
          EXPECT_EQ(topology->element(tree.triangle_ids()[t]), element);
      }
      EXPECT_EQ(leaves[0] > 0, with_faces);
      EXPECT_GT(leaves[1], 1u);
      EXPECT_EQ(leaves[2] > 0, with_points);
      if (with_faces) {  // the tree of the faces is that which they have alone
        EXPECT_TRUE(std::ranges::equal(alone.triangle_ids(), tree.triangle_ids().first(faces.size())));
        EXPECT_EQ(leaves[0], alone.leaf_count());
      }
    }
  }
}

TEST(Hierarchy, RefusesPartsThatMixElements) {
  const auto topology = *Topology::make(5, {{0, 1, 2}}, std::vector<Edge>{{3, 4}}, {});
  EXPECT_TRUE(Hierarchy::from_parts(topology, {0, 1}, std::vector<Index>{0, 1, 1}));
  EXPECT_FALSE(Hierarchy::from_parts(topology, {0, 1}, std::vector<Index>{2}));
  EXPECT_FALSE(Hierarchy::from_parts(topology, {1, 0}, std::vector<Index>{0, 1, 1}));
}

}  // namespace
}  // namespace foldproof
