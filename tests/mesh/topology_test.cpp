#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "foldproof/mesh.h"

namespace foldproof {
namespace {

static_assert(3 * std::uint64_t{Topology::kMaxTriangles} + 2 < kNoIndex);

using testing::ElementsAre;

TEST(Topology, NumbersEveryEdgeOnce) {
  const auto mesh = Topology::make(4, {{0, 1, 2}, {2, 1, 3}});
  ASSERT_TRUE(mesh);
  EXPECT_THAT(mesh->edges(), ElementsAre(Edge{0, 1}, Edge{0, 2}, Edge{1, 2}, Edge{1, 3}, Edge{2, 3}));
  EXPECT_THAT(mesh->triangle_edges(),
              ElementsAre(std::array<Index, 3>{0, 2, 1}, std::array<Index, 3>{2, 3, 4}));
}

TEST(Topology, KeepsTrianglesThatNameAVertexTwice) {
  const auto mesh = Topology::make(2, {{0, 0, 1}, {1, 1, 1}});
  ASSERT_TRUE(mesh);
  EXPECT_THAT(mesh->edges(), ElementsAre(Edge{0, 1}));
  EXPECT_THAT(mesh->triangle_edges(), ElementsAre(std::array<Index, 3>{kNoIndex, 0, 0},
                                                  std::array<Index, 3>{kNoIndex, kNoIndex, kNoIndex}));
}

TEST(Topology, RejectsATriangleThatNamesAMissingVertex) {
  const auto mesh = Topology::make(3, {{0, 1, 2}, {0, 1, 3}});
  ASSERT_FALSE(mesh);
  EXPECT_EQ(mesh.error().line(),
            "triangle 1: names vertex 3, but there are 3 (counting from 0); export the mesh again");
}

TEST(Topology, RejectsAMeshWithoutTriangles) {
  const auto mesh = Topology::make(3, {});
  ASSERT_FALSE(mesh);
  EXPECT_EQ(mesh.error().line(), "mesh: has no triangles; give a mesh with at least one face");
}

TEST(Topology, EqualityDependsOnOrder) {
  const auto a = Topology::make(4, {{0, 1, 2}, {2, 1, 3}}), b = Topology::make(4, {{2, 1, 3}, {0, 1, 2}});
  EXPECT_TRUE(*a == *a);
  EXPECT_FALSE(*a == *b);
}

TEST(ShareVertex, ComparesAllCorners) {
  EXPECT_TRUE(share_vertex({0, 1, 2}, {5, 4, 0}));
  EXPECT_FALSE(share_vertex({0, 1, 2}, {5, 4, 3}));
}

}  // namespace
}  // namespace foldproof
