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

TEST(Topology, LinesAndPointsComeAfterTheFaces) {
  const auto mesh =
      Topology::make(7, {{0, 1, 2}}, std::vector<Edge>{{4, 3}, {2, 4}}, std::vector<Index>{6, 5});
  ASSERT_TRUE(mesh);
  EXPECT_THAT(mesh->triangles(), ElementsAre(Triangle{0, 1, 2}, Triangle{4, 3, 3}, Triangle{2, 4, 4},
                                             Triangle{6, 6, 6}, Triangle{5, 5, 5}));
  EXPECT_THAT(mesh->faces(), ElementsAre(Triangle{0, 1, 2}));
  EXPECT_THAT(mesh->lines(), ElementsAre(Edge{4, 3}, Edge{2, 4}));
  EXPECT_THAT(mesh->points(), ElementsAre(6, 5));
  EXPECT_THAT(mesh->edges(), ElementsAre(Edge{0, 1}, Edge{0, 2}, Edge{1, 2}, Edge{2, 4}, Edge{3, 4}));
  EXPECT_EQ(mesh->element(0), Element::Face);
  EXPECT_EQ(mesh->element(2), Element::Line);
  EXPECT_EQ(mesh->element(3), Element::Point);
  EXPECT_FALSE(*mesh == *Topology::make(7, {mesh->triangles().begin(), mesh->triangles().end()}));
}

TEST(Topology, NamesALineOrPointThatIsWrong) {
  const auto where = [](std::vector<Edge> lines, std::vector<Index> points) {
    return Topology::make(4, {{0, 1, 2}}, lines, points).error().where;
  };
  EXPECT_EQ(where({{0, 1}, {3, 3}}, {}), "line 1");
  EXPECT_EQ(where({{0, 1}, {0, 4}}, {}), "line 1");
  EXPECT_EQ(where({{0, 1}}, {3, 4}), "point 1");
  EXPECT_EQ(where({}, {3, 2}), "point 1");  // on the face
  EXPECT_EQ(where({{0, 3}}, {3}), "point 0");
}

TEST(MayCross, LinesAndPointsWithACommonVertexDoNot) {
  const auto mesh =
      *Topology::make(6, {{0, 1, 2}}, std::vector<Edge>{{2, 3}, {3, 4}, {0, 1}}, std::vector<Index>{5});
  EXPECT_TRUE(may_cross(mesh, 0, 1));
  EXPECT_FALSE(may_cross(mesh, 1, 2));
  EXPECT_TRUE(may_cross(mesh, 1, 3));
  EXPECT_TRUE(may_cross(mesh, 2, 4));
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
