// Lines and points: which pairs are tested, alone and on their own. Random scenes are those of the family
// "hairy".
#include <gtest/gtest.h>

#include "check/animations.h"
#include "foldproof/check.h"
#include "oracle/meshes.h"

namespace foldproof::oracle {
namespace {

// A mesh of one element at height z: a face or a line around the z axis, or a point on it.
Mesh element(Element kind, double z, double turn = 0) {
  Mesh mesh;
  const double c = std::cos(turn), s = std::sin(turn);
  switch (kind) {
    case Element::Face:
      mesh.positions = {-1, -1, z, 1, -1, z, 0, 1, z};
      mesh.triangles = {{0, 1, 2}};
      break;
    case Element::Line:
      mesh.positions = {-c, -s, z, c, s, z};
      mesh.lines = {{1, 0}};
      break;
    case Element::Point:
      mesh.positions = {0, 0, z};
      mesh.points = {0};
      break;
  }
  mesh.vertex_count = static_cast<Index>(mesh.positions.size() / 3);
  return mesh;
}

Mesh joined(const Mesh& a, const Mesh& b) {
  Mesh mesh = a;
  const Index n = a.vertex_count;
  mesh.vertex_count += b.vertex_count;
  mesh.positions.insert(mesh.positions.end(), b.positions.begin(), b.positions.end());
  for (const auto& [p, q, r] : b.triangles) mesh.triangles.push_back({p + n, q + n, r + n});
  for (const auto& [p, q] : b.lines) mesh.lines.push_back({p + n, q + n});
  for (const Index p : b.points) mesh.points.push_back(p + n);
  return mesh;
}

// A scene of two meshes, as one object or two: from (a, b) to (a, c).
Scene scene_of(const Mesh& a, const Mesh& b, const Mesh& c, bool one) {
  Scene scene;
  if (one) {
    scene.topologies = {joined(a, b).topology()};
    scene.x0 = {joined(a, b).positions};
    scene.x1 = {joined(a, c).positions};
  } else {
    scene.topologies = {a.topology(), b.topology()};
    scene.x0 = {a.positions, b.positions};
    scene.x1 = {a.positions, c.positions};
  }
  return scene;
}

StepResult check(const Scene& scene, bool certificates) {
  StepChecker checker(scene.hierarchies(4));
  StepSettings settings;
  settings.certificates = certificates;
  StepResult out;
  EXPECT_TRUE(checker.check(scene.spans0(), scene.spans1(), settings, out));
  return out;
}

std::uint64_t crossings(const Scene& scene) {
  StepChecker checker(scene.hierarchies(4));
  StaticResult out;
  EXPECT_TRUE(checker.check_static(scene.spans0(), {}, out));
  return out.crossing_count;
}

constexpr Element kKinds[] = {Element::Face, Element::Line, Element::Point};

TEST(Lines, EveryTwoElementsThatPassThroughEachOtherCollide) {
  for (const Element a : kKinds) {
    for (const Element b : kKinds) {
      for (const bool one : {true, false}) {
        for (const bool certificates : {true, false}) {
          SCOPED_TRACE(testing::Message() << int(a) << int(b) << one << certificates);
          const Scene scene = scene_of(element(a, 0), element(b, 1, 1), element(b, -1, 1), one);
          const StepResult found = check(scene, certificates);
          // Two faces, and a face above a line, meet in several pairs of features.
          const bool both_wide =
              a != Element::Point && b != Element::Point && (a == Element::Face || b == Element::Face);
          const std::uint64_t count = found.vertex_face_count + found.edge_edge_count;
          EXPECT_GT(count, 0u);
          EXPECT_TRUE(both_wide || count == 1) << count;
          EXPECT_NEAR(found.earliest_toi, 0.5, 1e-6);
        }
      }
    }
  }
}

TEST(Lines, EveryTwoElementsThatMeetCross) {
  for (const Element a : kKinds) {
    for (const Element b : kKinds) {
      for (const bool one : {true, false}) {
        SCOPED_TRACE(testing::Message() << int(a) << int(b) << one);
        EXPECT_EQ(crossings(scene_of(element(a, 0), element(b, 0, 1), element(b, 0, 1), one)), 1u);
        EXPECT_EQ(crossings(scene_of(element(a, 0), element(b, 1, 1), element(b, 1, 1), one)), 0u);
      }
    }
  }
}

TEST(Lines, OneThroughAFaceCrosses) {
  Mesh hair;
  hair.positions = {0, 0, -1, 0, 0, 1, 5, 0, -1, 5, 0, 1, 1, 1, 0.25, 1, 1, 1};
  hair.lines = {{0, 1}, {2, 3}};  // through the face, and beside it
  hair.vertex_count = 6;
  const Mesh face = element(Element::Face, 0);
  for (const bool one : {true, false}) EXPECT_EQ(crossings(scene_of(face, hair, hair, one)), 1u);
  hair.positions[2] = 0;  // ends on the face: closed sets that meet
  EXPECT_EQ(crossings(scene_of(face, hair, hair, true)), 1u);
}

// A polyline may fold onto itself at its joints, and crosses itself elsewhere.
TEST(Lines, NeighborsDoNotCross) {
  Mesh line;
  line.positions = {0, 0, 0, 2, 0, 0, 1, 0, 0, 1, 1, 0, 1, -1, 0};
  line.lines = {{0, 1}, {1, 2}, {2, 3}};
  line.vertex_count = 5;
  const Mesh far = element(Element::Point, 9);
  EXPECT_EQ(crossings(scene_of(far, line, line, true)), 1u);  // the last end lies on the first line's middle
  line.positions[7] = line.positions[10] = 2;                 // lifts the joint
  EXPECT_EQ(crossings(scene_of(far, line, line, true)), 0u);
  line.lines = {{0, 1}, {1, 2}};
  line.positions[7] = 0;
  EXPECT_EQ(crossings(scene_of(far, line, line, true)), 0u);
  const StepResult found = check(scene_of(far, line, line, true), true);
  EXPECT_EQ(found.vertex_face_count + found.edge_edge_count, 0u);
}

TEST(Lines, AHairCrossesOnlyWhereItGoesThroughAnotherPart) {
  Mesh scalp;  // a square, and a parasol above it
  scalp.positions = {-1, -1, 0,  1, -1, 0, 1, 1, 0, -1, 1,   0,   -1, -1,
                     2,  1,  -1, 2, 0,  1, 2, 0, 0, 1,  0.1, 0.2, 3};
  scalp.triangles = {{0, 1, 2}, {0, 2, 3}, {4, 5, 6}};
  scalp.vertex_count = 9;
  scalp.lines = {{0, 7}};
  const Mesh far = element(Element::Point, 9);
  EXPECT_EQ(crossings(scene_of(far, scalp, scalp, true)), 0u);
  scalp.lines.push_back({7, 8});
  EXPECT_EQ(crossings(scene_of(far, scalp, scalp, true)), 1u);
  scalp.positions[23] =
      -1;  // the first segment goes below the square it is rooted at, the second up through it
  EXPECT_EQ(crossings(scene_of(far, scalp, scalp, true)), 2u);
}

// Its vertices have pairs with faces; those with lines would be reported again.
TEST(Lines, TheVertexOfAFaceIsNotTestedAgainstALine) {
  Mesh face = element(Element::Face, 1);
  face.positions = {0, 0, 1, -1, -1, 2, 1, 1, 2};  // a tip that sinks onto the line
  Mesh below = face;
  for (std::size_t k = 2; k < 9; k += 3) below.positions[k] -= 1.5;
  const StepResult found = check(scene_of(element(Element::Line, 0), face, below, true), true);
  EXPECT_EQ(found.vertex_face_count, 0u);
  EXPECT_GT(found.edge_edge_count, 0u);
}

TEST(Lines, CopiesCountAsOftenAsTheyAreListed) {
  Mesh point = element(Element::Point, 1), below = element(Element::Point, -1);
  Mesh line = element(Element::Line, 0);
  line.lines = {{1, 0}, {1, 0}, {0, 1}};
  line.triangles = {{1, 0, 0}};  // a face that is a segment, which is no line's copy
  const StepResult found = check(scene_of(line, point, below, true), true);
  EXPECT_EQ(found.vertex_face_count, 4u);
  EXPECT_EQ(found.vertex_face.size(), 4u);
}

}  // namespace
}  // namespace foldproof::oracle
