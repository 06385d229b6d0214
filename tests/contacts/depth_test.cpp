// Depth, frames and number of contacts whose geometry is known.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "contacts/scenes.h"
#include "foldproof/eigen.h"

namespace foldproof {
namespace {

using namespace oracle;

Animation animation_of(std::vector<Mesh> meshes, std::vector<std::vector<Pose>> poses) {
  Animation animation;
  for (const Mesh& mesh : meshes) animation.topologies.push_back(mesh.topology());
  animation.poses = std::move(poses);
  return animation;
}

// The one contact of two meshes in one pose.
Contact contact_of(const Mesh& a, const Pose& at_a, const Mesh& b, const Pose& at_b) {
  auto found = contacts_of(animation_of({a, b}, {{at_a, at_b}}));
  EXPECT_EQ(found.contacts.size(), 1u);
  return found.contacts.empty() ? Contact{} : found.contacts[0];
}

void expect_depth(const Contact& contact, double depth) {
  ASSERT_EQ(contact.frames.size(), 1u);
  EXPECT_TRUE(contact.frames[0].closed);
  ASSERT_TRUE(contact.depth());
  EXPECT_NEAR(*contact.depth(), depth, 0.01 * depth);
}

TEST(Depth, SphereInSphere) {
  const Mesh ball = unit_sphere(80);
  for (const double sunk : {0.05, 0.2, 0.5}) {
    const Contact contact = contact_of(ball, ball.positions, ball,
                                       placed(ball, 0.9, Vec3(1.1, 1.2, 0.7).normalized() * (1.9 - sunk)));
    expect_depth(contact, sunk);
    EXPECT_GT(contact.normal.cwiseAbs().dot(Vec3(1.1, 1.2, 0.7).normalized()), 0.98);
    EXPECT_TRUE(contact.frames[0].area[0] && contact.frames[0].area[1]);
    // A cap of height h of a sphere of radius r has the area 2 pi r h.
    const double d = 1.9 - sunk, h = 1 - (d * d + 1 - 0.81) / (2 * d);
    EXPECT_NEAR(*contact.frames[0].area[0], 2 * std::numbers::pi * h, 0.02 * 2 * std::numbers::pi * h);
  }
}

TEST(Depth, SphereInPlane) {
  const Mesh ball = unit_sphere(30), plane = square(33);
  for (const double sunk : {0.03, 0.11, 0.3}) {
    const Contact contact =
        contact_of(ball, placed(ball, 0.5, {0.013, 0.007, 0.5 - sunk}), plane, plane.positions);
    expect_depth(contact, sunk);
    EXPECT_NEAR(std::abs(contact.normal.z()), 1, 1e-2);
  }
}

TEST(Depth, SphereInTorus) {
  const Mesh ball = unit_sphere(30), ring = torus(1, 0.3, 160, 60);
  for (const double sunk : {0.04, 0.15}) {
    // From above, over the middle of the tube.
    const Contact contact = contact_of(
        ball, placed(ball, 0.4, {1 * std::cos(0.3), std::sin(0.3), 0.7 - sunk}), ring, ring.positions);
    expect_depth(contact, sunk);
  }
}

// Neighbors in a column of the wall have one nearest point in the floor, which rounding moves.
TEST(Depth, SmallPrismThroughALargeFloor) {
  Mesh floor = square(1), prism;
  prism.vertex_count = 42;
  const double spacing = 3e-5;
  const Index around = 6, along = 7;
  for (Index k = 0; k < around; ++k) {
    const double angle = 2 * std::numbers::pi * k / around;
    for (Index r = 0; r < along; ++r)
      prism.positions.insert(
          prism.positions.end(),
          {spacing * std::cos(angle) + 0.3, spacing * std::sin(angle) + 0.2, spacing * (along - r - 2.5)});
  }
  for (Index k = 0; k < around; ++k) {
    const Index a = k * along, b = (k + 1) % around * along;
    for (Index r = 0; r + 1 < along; ++r) {
      prism.triangles.push_back({a + r, b + r, a + r + 1});
      prism.triangles.push_back({b + r, b + r + 1, a + r + 1});
    }
    if (k == 0 || k + 1 == around) continue;
    prism.triangles.push_back({0, b, a});
    prism.triangles.push_back({along - 1, a + along - 1, b + along - 1});
  }
  Rng rng(7);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int round = 0; round < 30; ++round) {
    const Eigen::Quaterniond turn =
        Eigen::Quaterniond(uniform(rng), uniform(rng), uniform(rng), uniform(rng)).normalized();
    const auto turned = [&](Pose x) {
      Eigen::Map<Eigen::Matrix3Xd> points(x.data(), 3, static_cast<Eigen::Index>(x.size() / 3));
      points = (turn.toRotationMatrix() * points).eval();
      return x;
    };
    expect_depth(contact_of(floor, turned(floor.positions), prism, turned(prism.positions)), 1.5 * spacing);
  }
}

// An outward face or an inward one: the smaller region is inside.
TEST(Depth, DoesNotDependOnOrientation) {
  const Mesh ball = unit_sphere(16);
  Mesh inside_out = ball;
  for (Triangle& t : inside_out.triangles) std::swap(t[0], t[1]);
  const Pose at = placed(ball, 1, {1.7, 0.2, 0.1});
  const Contact one = contact_of(ball, ball.positions, ball, at),
                other = contact_of(inside_out, ball.positions, ball, at);
  EXPECT_EQ(one.depth(), other.depth());
  EXPECT_EQ(one.sides[0].inside, other.sides[0].inside);
}

TEST(Depth, NoRegionWhereACurveEndsAtABorder) {
  const Mesh sheet = square(12);
  Pose standing = sheet.positions;
  for (std::size_t v = 0; v < standing.size() / 3; ++v) {
    const Vec3 p(standing[3 * v], standing[3 * v + 1], standing[3 * v + 2]);
    standing[3 * v] = 0.03;
    standing[3 * v + 1] = 0.5 * p.x() + 0.011;
    standing[3 * v + 2] = p.y() + 0.02;
  }
  const Contact contact = contact_of(sheet, sheet.positions, sheet, standing);
  ASSERT_EQ(contact.frames.size(), 1u);
  EXPECT_FALSE(contact.frames[0].closed);
  EXPECT_FALSE(contact.frames[0].area[0]);
  EXPECT_FALSE(contact.frames[0].area[1]);
  for (const Contact::Side& side : contact.sides) EXPECT_TRUE(side.inside.empty());
  EXPECT_NEAR(contact.frames[0].curve_length, 1.0, 1e-6);
  ASSERT_EQ(contact.curves.size(), 1u);
}

TEST(Depth, DoesNotChangeWhenMovedRigidly) {
  const Mesh ball = unit_sphere(14), ring = torus(1, 0.3, 50, 18);
  const Pose at_ball = placed(ball, 0.4, {1 * std::cos(0.3), std::sin(0.3), 0.55});
  const Contact still = contact_of(ball, at_ball, ring, ring.positions);
  ASSERT_TRUE(still.depth());
  Rng rng(3);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int round = 0; round < 20; ++round) {
    const Eigen::Quaterniond turn =
        Eigen::Quaterniond(uniform(rng), uniform(rng), uniform(rng), uniform(rng)).normalized();
    const Vec3 shift = 10 * Vec3(uniform(rng), uniform(rng), uniform(rng));
    const auto moved = [&](Pose x) {
      for (std::size_t v = 0; v < x.size() / 3; ++v) {
        const Vec3 p = to_vec3(turn * to_eigen(Vec3::load(&x[3 * v]))) + shift;
        for (int k = 0; k < 3; ++k) x[3 * v + static_cast<std::size_t>(k)] = p[k];
      }
      return x;
    };
    const Contact contact = contact_of(ball, moved(at_ball), ring, moved(ring.positions));
    ASSERT_TRUE(contact.depth());
    EXPECT_NEAR(*contact.depth(), *still.depth(), 1e-9);
    EXPECT_NEAR(contact.frames[0].curve_length, still.frames[0].curve_length, 1e-8);
    EXPECT_EQ(contact.sides[0].inside, still.sides[0].inside);
    EXPECT_EQ(contact.sides[1].inside, still.sides[1].inside);
    EXPECT_NEAR((contact.normal - to_vec3(turn * to_eigen(still.normal))).norm(), 0, 1e-6);
  }
}

TEST(Depth, ScalesWithCoordinatesOfAnySize) {
  const Mesh ball = unit_sphere(14), ring = torus(1, 0.3, 50, 18);
  const Pose at_ball = placed(ball, 0.4, {1 * std::cos(0.3), std::sin(0.3), 0.55});
  const Contact one = contact_of(ball, at_ball, ring, ring.positions);
  ASSERT_TRUE(one.depth());
  for (const int exponent : {-960, -520, -201, -199, 199, 201, 520, 960}) {
    SCOPED_TRACE(exponent);
    const auto scaled = [&](Pose x) {
      for (double& c : x) c = std::ldexp(c, exponent);
      return x;
    };
    const Contact contact = contact_of(ball, scaled(at_ball), ring, scaled(ring.positions));
    ASSERT_TRUE(contact.depth());
    EXPECT_NEAR(std::ldexp(*contact.depth(), -exponent), *one.depth(), 1e-9);
    EXPECT_NEAR(std::ldexp(contact.frames[0].curve_length, -exponent), one.frames[0].curve_length, 1e-9);
    EXPECT_NEAR(std::ldexp(contact.point.x(), -exponent), one.point.x(), 1e-9);
    EXPECT_EQ(contact.sides[0].inside, one.sides[0].inside);
  }
}

// A contact that crosses in one frame.
Contact crossing(Index number, std::optional<double> depth, double curve_length, std::uint64_t pairs = 1) {
  Contact contact;
  contact.number = number;
  contact.pairs = pairs;
  contact.frames.resize(1);
  contact.frames[0].depth = depth;
  contact.frames[0].curve_length = curve_length;
  return contact;
}

TEST(Order, ALongCurveWithoutDepthIsWorseThanAShallowContact) {
  Contact touching;
  touching.number = 1;
  touching.pairs = 99;
  const std::vector<Contact> worst_first{
      crossing(7, 0.5, 1),    crossing(6, std::nullopt, 6), crossing(5, 0.2, 1),      crossing(3, 0.1, 9, 5),
      crossing(2, 0.1, 1, 4), crossing(4, 0.1, 1, 4),       crossing(8, 6e-6, 0.001), touching};
  for (std::size_t i = 0; i < worst_first.size(); ++i) {
    for (std::size_t k = 0; k < worst_first.size(); ++k)
      EXPECT_EQ(is_worse(worst_first[i], worst_first[k]), i < k) << i << " " << k;
  }
}

// A ball sinks through the middle of a sheet, then over its border, where the ball has no region.
TEST(Order, TheWorstFrameMayHaveOneRegion) {
  const Mesh ball = unit_sphere(10), sheet = square(20);
  const Animation animation =
      animation_of({ball, sheet}, {{placed(ball, 0.4, {0.013, 0.007, 0.39}), sheet.positions},
                                   {placed(ball, 0.4, {0.9, 0.007, 0.1}), sheet.positions}});
  const auto found = contacts_of(animation);
  ASSERT_EQ(found.contacts.size(), 1u);
  const Contact& contact = found.contacts[0];
  ASSERT_EQ(contact.frames.size(), 2u);
  EXPECT_LT(contact.frames[0].depth.value_or(1), 0.02);
  EXPECT_EQ(contact.worst, 1u);
  // The sheet is 0.1 below the ball's middle.
  EXPECT_NEAR(contact.depth().value_or(0), 0.3, 0.01);
  EXPECT_FALSE(contact.at_least());
  EXPECT_FALSE(contact.frames[1].area[0]);
  EXPECT_TRUE(contact.frames[1].area[1]);
}

TEST(Frames, TwoSpheresThatPassThroughEachOther) {
  const Mesh ball = unit_sphere(12);
  std::vector<std::vector<Pose>> poses;
  std::vector<bool> crosses;
  for (int k = 0; k <= 30; ++k) {
    const double x = 3 - 0.19 * k;  // from 3 to -2.7
    poses.push_back({ball.positions, placed(ball, 0.7, {x, 0.1, 0.05})});
    const double distance = Vec3(x, 0.1, 0.05).norm();
    // Whole inside: nothing crosses, and the contact goes on when the spheres' surfaces meet again.
    crosses.push_back(distance < 1.69 && distance > 0.31);
  }
  const Found found = contacts_of(animation_of({ball, ball}, poses));
  std::vector<double> frames;
  for (const Contact& contact : found.contacts) {
    for (const ContactFrame& frame : contact.frames) frames.push_back(frame.time);
    EXPECT_FALSE(contact.from_start);
    EXPECT_TRUE(contact.healed);
  }
  std::vector<double> expected;
  for (std::size_t k = 0; k < crosses.size(); ++k) {
    if (crosses[k]) expected.push_back(double(k));
  }
  EXPECT_EQ(frames, expected);
}

}  // namespace
}  // namespace foldproof
