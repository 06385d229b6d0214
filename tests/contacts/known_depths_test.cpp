// Depths that are known, where curves enclose no region of a side: bent arms, open sheets, what only touches.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <random>

#include "contacts/nearest.h"
#include "contacts/scenes.h"

namespace foldproof {
namespace {

using namespace oracle;

constexpr double kScales[] = {1e-6, 1, 1e6};

Contact contact_of(const std::vector<Mesh>& meshes, double scale = 1) {
  Animation animation;
  animation.poses.emplace_back();
  for (const Mesh& mesh : meshes) {
    animation.topologies.push_back(mesh.topology());
    animation.poses[0].push_back(placed(mesh, scale, {}));
  }
  const Found found = contacts_of(animation);
  EXPECT_EQ(found.contacts.size(), 1u);
  return found.contacts.empty() ? Contact{} : found.contacts[0];
}

std::array<Vec3, 3> corners_of(const Mesh& mesh, Index triangle) {
  std::array<Vec3, 3> corners;
  for (std::size_t k = 0; k < 3; ++k)
    corners[k] = Vec3::load(&mesh.positions[3 * mesh.triangles[triangle][k]]);
  return corners;
}

double distance_to_surfaces(const std::vector<Mesh>& meshes, const Vec3& p) {
  double least = std::numeric_limits<double>::infinity();
  for (const Mesh& mesh : meshes) {
    for (Index t = 0; t < mesh.triangles.size(); ++t)
      least = std::min(least, (nearest_on_triangle(p, corners_of(mesh, t)) - p).norm());
  }
  return least;
}

void expect_depth(const std::vector<Mesh>& meshes, double depth, bool at_least = false) {
  for (const double scale : kScales) {
    SCOPED_TRACE(scale);
    const Contact contact = contact_of(meshes, scale);
    ASSERT_EQ(contact.frames.size(), 1u);
    EXPECT_FALSE(contact.touching());
    EXPECT_EQ(contact.at_least(), at_least);
    ASSERT_TRUE(contact.depth());
    EXPECT_NEAR(*contact.depth() / scale, depth, 0.05 * depth);
    EXPECT_LT(distance_to_surfaces(meshes, contact.point / scale), 1e-9);
  }
}

// A square of side 2 at u, v in [-1,1], by the place of each of its points.
Mesh sheet(Index size, const std::function<Vec3(double, double)>& place) {
  Mesh mesh = square(size);
  for (std::size_t i = 0; i < mesh.positions.size(); i += 3)
    place(mesh.positions[i], mesh.positions[i + 1]).store(&mesh.positions[i]);
  return mesh;
}

// A closed tube of radius 0.3 along x, from -1.5 to 1.5, whose rings nearest to the middle are at -gap and
// gap. What is right of the middle is turned by an angle, up.
Mesh bent_arm(double gap, double degrees, int around, int rings) {
  constexpr double kRadius = 0.3;
  const double angle = degrees * std::numbers::pi / 180;
  std::vector<Vec3> vertices;
  std::vector<Triangle> triangles;
  const auto add = [&](double x, double y, double z) {
    vertices.push_back(x < 0 ? Vec3(x, y, z)
                             : Vec3(x * std::cos(angle) - y * std::sin(angle),
                                    x * std::sin(angle) + y * std::cos(angle), z));
  };
  std::vector<double> places;
  for (int i = 0; i < rings; ++i) places.push_back(-1.5 + (1.5 - gap) * i / (rings - 1));
  for (int i = rings; i-- > 0;) places.push_back(-places[static_cast<std::size_t>(i)]);
  for (const double x : places) {
    for (int k = 0; k < around; ++k) {
      const double at = 2 * std::numbers::pi * k / around;
      add(x, kRadius * std::cos(at), kRadius * std::sin(at));
    }
  }
  const auto id = [&](std::size_t ring, int k) {
    return static_cast<Index>(ring * std::size_t(around) + std::size_t(k % around));
  };
  for (std::size_t i = 0; i + 1 < places.size(); ++i) {
    for (int k = 0; k < around; ++k) {
      triangles.push_back({id(i, k), id(i, k + 1), id(i + 1, k + 1)});
      triangles.push_back({id(i, k), id(i + 1, k + 1), id(i + 1, k)});
    }
  }
  for (const std::size_t ring : {std::size_t{0}, places.size() - 1}) {
    add(places[ring], 0, 0);
    const auto tip = static_cast<Index>(vertices.size() - 1);
    for (int k = 0; k < around; ++k) {
      Triangle t{tip, id(ring, k + 1), id(ring, k)};
      if (ring != 0) std::swap(t[1], t[2]);
      triangles.push_back(t);
    }
  }
  return scene_mesh(vertices, triangles);
}

// The inner corners of the two halves are deepest in the other half. Its inner line is nearest to them.
TEST(KnownDepth, ElbowOfABentArm) {
  for (const double degrees : {45.0, 60.0, 75.0, 90.0}) {
    const double angle = degrees * std::numbers::pi / 180;
    for (const double gap : {0.01, 0.05, 0.1}) {
      for (const int rings : {4, 12, 40}) {
        SCOPED_TRACE(::testing::Message() << degrees << " degrees, gap " << gap << ", rings " << rings);
        const double beyond = 0.3 * std::tan(angle / 2) - gap;
        expect_depth({bent_arm(gap, degrees, 64, rings)}, beyond * std::sin(angle));
      }
    }
  }
}

TEST(KnownDepth, ElbowIsInsideWhereItIsRed) {
  const Mesh arm = bent_arm(0.02, 80, 64, 60);
  const Contact contact = contact_of({arm});
  for (int side = 0; side < 2; ++side) {
    EXPECT_GT(contact.sides[side].inside.size(), 20u);
    for (const Index t : contact.sides[side].inside) {
      for (const Index v : arm.triangles[t]) {
        const Vec3 p = Vec3::load(&arm.positions[3 * v]);
        // Within the straight half that it does not belong to.
        const double c = std::cos(80 * std::numbers::pi / 180), s = std::sin(80 * std::numbers::pi / 180);
        const double to_left = std::hypot(p.y(), p.z()), to_right = std::hypot(-p.x() * s + p.y() * c, p.z());
        EXPECT_LT(std::min(to_left, to_right), 0.3);
      }
    }
  }
}

// How often the surface surrounds a point of a triangle's inner side (van Oosterom and Strackee 1983).
int winding_number(const Mesh& mesh, Index triangle, const Vec3& p) {
  double sum = 2 * std::numbers::pi;  // its own half
  for (Index t = 0; t < mesh.triangles.size(); ++t) {
    if (t == triangle) continue;
    const auto [a, b, c] = corners_of(mesh, t);
    const Vec3 u = a - p, v = b - p, w = c - p;
    const double r = u.norm(), s = v.norm(), q = w.norm();
    sum += 2 * std::atan2(u.dot(v.cross(w)), r * s * q + u.dot(v) * q + v.dot(w) * r + w.dot(u) * s);
  }
  return static_cast<int>(std::lround(sum / (4 * std::numbers::pi)));
}

// What of a surface is inside it and around that, as points: surrounded more than once, or not at all.
struct Sampled {
  std::vector<Vec3> inside, outside;
  double distance(const Vec3& p) const {
    double least = std::numeric_limits<double>::infinity();
    for (const Vec3& q : outside) least = std::min(least, (q - p).norm());
    return least;
  }
};

Sampled sample(const Mesh& mesh, const std::vector<Contact>& all, const Contact& contact) {
  constexpr int kSteps = 32;
  std::vector<bool> crosses(mesh.triangles.size()), near(mesh.vertex_count);
  for (const auto& side : contact.sides) {
    for (const Index t : side.triangles) {
      crosses[t] = true;
      for (const Index v : mesh.triangles[t]) near[v] = true;
    }
  }
  // What is inside there may be another contact's.
  for (const Contact& other : all) {
    for (const auto& side : other.sides) {
      for (const Index t : side.triangles) crosses[t] = crosses[t] && other.number == contact.number;
    }
  }
  Sampled out;
  for (Index t = 0; t < mesh.triangles.size(); ++t) {
    const auto& [u, v, w] = mesh.triangles[t];
    const auto [a, b, c] = corners_of(mesh, t);
    for (int i = 0; i < kSteps && (near[u] || near[v] || near[w]); ++i) {
      for (int k = 0; i + k < kSteps; ++k) {
        const Vec3 p = a + (i + 1 / 3.0) / kSteps * (b - a) + (k + 1 / 3.0) / kSteps * (c - a);
        if (winding_number(mesh, t, p) == 1) {
          out.outside.push_back(p);
        } else if (crosses[t]) {
          out.inside.push_back(p);
        }
      }
    }
  }
  for (const auto& curve : contact.curves) {
    for (std::size_t i = 1; i < curve.size(); ++i) {
      for (int k = 0; k <= kSteps; ++k)
        out.outside.push_back(curve[i - 1] + double(k) / kSteps * (curve[i] - curve[i - 1]));
    }
  }
  return out;
}

// Folds of crumpled balls, in most of which no vertex is inside.
TEST(KnownDepth, FoldsOfFewTriangles) {
  int few = 0;
  for (const unsigned seed : {0u, 1u, 2u, 3u}) {
    std::mt19937 random(seed);
    Mesh ball = unit_sphere(8);
    for (double& c : ball.positions) c += 0.24 * (random() * 0x1p-32 - 0.5);
    std::array<std::vector<Contact>, 3> found;
    for (std::size_t i = 0; i < 3; ++i) {
      Animation animation;
      animation.topologies.push_back(ball.topology());
      animation.poses = {{placed(ball, kScales[i], {})}};
      found[i] = contacts_of(animation).contacts;
      ASSERT_EQ(found[i].size(), found[0].size());
    }
    for (std::size_t i = 0; i < found[1].size(); ++i) {
      SCOPED_TRACE(::testing::Message() << "ball " << seed << ", contact " << i + 1);
      const Contact& contact = found[1][i];
      ASSERT_TRUE(contact.depth());
      EXPECT_FALSE(contact.at_least());
      for (const std::size_t other : {0, 2})
        EXPECT_NEAR(found[other][i].depth().value_or(-1), kScales[other] * *contact.depth(),
                    1e-6 * kScales[other] * *contact.depth());
      const Sampled sampled = sample(ball, found[1], contact);
      double deepest = 0;
      for (const Vec3& p : sampled.inside) deepest = std::max(deepest, sampled.distance(p));
      constexpr double kSpacing = 0.002;
      EXPECT_GE(*contact.depth(), 0.95 * deepest - kSpacing);
      EXPECT_NEAR(sampled.distance(contact.point), *contact.depth(), 0.05 * *contact.depth() + kSpacing);
      few += contact.frames[0].triangles <= 6;
    }
  }
  EXPECT_GE(few, 6);
}

TEST(KnownDepth, SphereInSphereOfOneMesh) {
  const Mesh ball = unit_sphere(40);
  for (const double sunk : {0.05, 0.2, 0.5}) {
    Mesh other = ball;
    other.positions = placed(ball, 0.9, Vec3(1.1, 1.2, 0.7).normalized() * (1.9 - sunk));
    expect_depth({together(ball, other)}, sunk);
    expect_depth({ball, other}, sunk);
  }
}

TEST(KnownDepth, CornerOfABoxInASheet) {
  // The tip is the corner at (-1, -1, -1), turned down.
  Mesh cube = box({}, Vec3::Constant(0.5), 3);
  for (const double sunk : {0.02, 0.1, 0.3}) {
    Mesh turned = cube;
    for (std::size_t i = 0; i < turned.positions.size(); i += 3) {
      const Vec3 p = Vec3::load(&cube.positions[i]);
      const double r2 = std::sqrt(2.0), r3 = std::sqrt(3.0), r6 = std::sqrt(6.0);
      Vec3((p.x() - p.y()) / r2 + 0.013, (p.x() + p.y() - 2 * p.z()) / r6 + 0.017,
           (p.x() + p.y() + p.z()) / r3 + r3 / 2 - sunk)
          .store(&turned.positions[i]);
    }
    expect_depth({turned, square(31)}, sunk);
  }
}

// The sheet's border is in the box: the curve ends there.
TEST(KnownDepth, BorderOfASheetInABox) {
  for (const double sunk : {0.05, 0.2, 0.4}) {
    for (const double half_width : {0.5, 3.0}) {
      SCOPED_TRACE(::testing::Message() << sunk << " " << half_width);
      const Mesh cube = box({-0.7 + sunk + 1 + 0.5, 0.011, 0.013}, {0.7, half_width, 0.5}, 5);
      // The box begins at x = 0.3 + sunk + 0.5, the sheet ends there plus sunk.
      const double begin = -0.7 + sunk + 1 + 0.5 - 0.7;
      const Mesh flat = sheet(40, [&](double u, double v) { return Vec3(u - 1 + begin + sunk, v, 0); });
      expect_depth({cube, flat}, sunk);
      expect_depth({flat, cube}, sunk);
    }
  }
}

// A bowl, open at the top, is nearly closed where the sheet goes in.
TEST(KnownDepth, BorderOfASheetInABallWithAHole) {
  Mesh ball = unit_sphere(40);
  std::erase_if(ball.triangles, [&](const Triangle& t) { return ball.positions[3 * t[0] + 2] > 0.9; });
  const Mesh flat =
      sheet(40, [&](double u, double v) { return Vec3(0.3 * u - 1.1, 0.3 * v + 0.003, 0.007); });
  const Contact contact = contact_of({ball, flat});
  ASSERT_TRUE(contact.depth());
  EXPECT_FALSE(contact.at_least());
  // Of the two corners inside the box of the sheet, 0.8 from the middle along x.
  EXPECT_NEAR(*contact.depth(), 0.2, 0.01);
}

TEST(KnownDepth, SheetsThatPassThroughEachOther) {
  const Mesh lying = square(12);
  const Mesh standing = sheet(12, [](double u, double v) { return Vec3(0.03, 0.5 * u + 0.011, v + 0.02); });
  expect_depth({lying, standing}, 0.98, true);
  // Two cards, each in a slot of the other.
  const Mesh card = sheet(12, [](double u, double v) { return Vec3(u + 1.613, 0.011, v + 0.02); });
  const Contact contact = contact_of({lying, card});
  EXPECT_TRUE(contact.at_least());
  ASSERT_TRUE(contact.depth());
  EXPECT_NEAR(contact.frames[0].curve_length, 0.387, 1e-3);
  EXPECT_NEAR(*contact.depth(), 0.387, 1e-3);
}

// Where the curve ends on the border of one of them, by rounding on this side of it or that.
TEST(KnownDepth, TriangleWhoseTipReachesThroughATriangle) {
  for (const double tip : {0.2, double{0.2f}, 0.1, 0.3}) {
    const Mesh floor{3, {{0, 1, 2}}, {}, {}, {0, 0, 0, 1, 0, 0, 0, 1, 0}};
    const Mesh triangle{3, {{0, 1, 2}}, {}, {}, {tip, tip, -1, tip + 0.1, tip, 1, tip, tip + 0.1, 1}};
    for (const double scale : kScales) {
      const Contact contact = contact_of({floor, triangle}, scale);
      ASSERT_TRUE(contact.depth()) << tip << ", " << scale;
      EXPECT_NEAR(*contact.depth() / scale, 1, 1e-6);
      EXPECT_TRUE(contact.at_least());
    }
  }
}

// One stands on the other, or is in it by rounding; they may have vertices at the same places.
TEST(Touching, BoxesThatStandOnEachOther) {
  for (const double scale : kScales) {
    for (const Vec3& at : {Vec3(0.1, 0.2, 1), Vec3(0, 0, 1), Vec3(0.5, 0, 1)}) {
      for (const int sunk : {0, 1, 2, 3}) {
        SCOPED_TRACE(::testing::Message() << scale << ", " << at.x() << ", " << sunk);
        std::vector<Mesh> boxes{box({}, Vec3::Constant(0.5), 3), box(at, Vec3::Constant(0.5), 4)};
        for (std::size_t i = 2; i < boxes[1].positions.size(); i += 3) {
          double& z = boxes[1].positions[i];
          if (z == 0.5 && (sunk != 3 || i % 2 == 0)) z -= sunk * 0x1p-54;
        }
        for (const auto& scene : {boxes, {together(boxes[0], boxes[1])}}) {
          const Contact contact = contact_of(scene, scale);
          ASSERT_EQ(contact.frames.size(), 1u);
          EXPECT_TRUE(contact.touching());
          EXPECT_FALSE(contact.at_least());
          EXPECT_FALSE(contact.depth()) << *contact.depth();
          EXPECT_EQ(contact.frames[0].severity(), 0);
          EXPECT_LT(distance_to_surfaces(scene, contact.point / scale), 1e-9);
        }
      }
    }
  }
}

// A cube whose sides have vertices of their own touches itself along its edges.
TEST(Touching, SidesOfACubeWithSeams) {
  const Mesh cube = box({0.5, 0.5, 0.5}, Vec3::Constant(0.5), 1);
  Mesh seams;
  for (std::size_t i = 0; i < cube.triangles.size(); i += 2) {
    Mesh side;
    std::map<Index, Index> known;
    for (const Triangle& t : {cube.triangles[i], cube.triangles[i + 1]}) {
      Triangle own{};
      for (std::size_t k = 0; k < 3; ++k) {
        const auto [at, is_new] = known.try_emplace(t[k], side.vertex_count);
        if (is_new) {
          side.positions.insert(side.positions.end(), &cube.positions[3 * t[k]],
                                &cube.positions[3 * t[k]] + 3);
          ++side.vertex_count;
        }
        own[k] = at->second;
      }
      side.triangles.push_back(own);
    }
    seams = together(seams, side);
  }
  Animation animation;
  animation.topologies.push_back(seams.topology());
  animation.poses = {{seams.positions}};
  const Found found = contacts_of(animation);
  EXPECT_GT(found.contacts.size(), 0u);
  for (const Contact& contact : found.contacts) {
    EXPECT_TRUE(contact.touching());
    EXPECT_FALSE(contact.depth());
    EXPECT_LT(distance_to_surfaces({seams}, contact.point), 1e-12);
  }
}

}  // namespace
}  // namespace foldproof
