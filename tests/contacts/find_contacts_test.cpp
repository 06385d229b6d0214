#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "contacts/scenes.h"
#include "foldproof/eigen.h"

namespace foldproof {
namespace {

using namespace oracle;

// Hands out the frames of an animation, each in the same memory.
class Frames {
 public:
  explicit Frames(const Animation& animation) : animation_(animation) {}
  Result<std::optional<MotionFrame>> operator()() {
    if (next_ == animation_.poses.size()) return std::nullopt;
    pose_ = animation_.poses[next_];
    spans_ = spans(pose_);
    return MotionFrame{static_cast<double>(next_++), spans_};
  }

 private:
  const Animation& animation_;
  std::size_t next_ = 0;
  std::vector<Pose> pose_;
  std::vector<std::span<const double>> spans_;
};

Animation passing_balls() {
  const Mesh ball = unit_sphere(8);
  Animation animation;
  animation.topologies = {ball.topology(), ball.topology()};
  for (int k = 0; k <= 12; ++k)
    animation.poses.push_back({ball.positions, placed(ball, 1, {-3 + 0.5 * k, 1.4, 0.1})});
  return animation;
}

Result<std::vector<Contact>> found_in(const Animation& animation, const StepSettings& settings = {}) {
  std::vector<Contact> contacts;
  Frames frames(animation);
  const auto done = find_contacts(
      hierarchies(animation, 16), std::ref(frames),
      [&](Contact contact) { contacts.push_back(std::move(contact)); }, settings);
  if (!done) return tl::unexpected(done.error());
  return contacts;
}

TEST(FindContacts, FindsWhatTheFinderFinds) {
  const Animation animation = passing_balls();
  const auto found = found_in(animation).value();
  const auto expected = contacts_of(animation).contacts;
  ASSERT_EQ(found.size(), 1u);
  ASSERT_EQ(expected.size(), 1u);
  EXPECT_EQ(found[0].first_time, expected[0].first_time);
  EXPECT_EQ(found[0].frames.size(), expected[0].frames.size());
  EXPECT_EQ(found[0].depth(), expected[0].depth());
  EXPECT_TRUE(found[0].healed);
}

// So that one frame and the whole motion name them alike.
TEST(FindContacts, SidesOfOneObjectAreInTheOrderOfTheirParts) {
  const Mesh ball = unit_sphere(6);
  Mesh other = ball;
  other.positions = placed(ball, 1, {1.6, 0.1, 0.2});
  const Mesh both = together(ball, other);
  const Topology topology = both.topology();
  StepChecker checker({Object(Hierarchy::build(topology, both.positions).value())});
  const std::span<const double> x[] = {both.positions};
  StaticResult crossings;
  ASSERT_TRUE(checker.check_static(x, {}, crossings));
  for (const Index first : {0u, 1u}) {
    std::vector<Index> parts(both.triangles.size(), first);
    std::fill(parts.begin() + static_cast<std::ptrdiff_t>(ball.triangles.size()), parts.end(), 1 - first);
    auto finder = ContactFinder::make({&topology}, {parts}).value();
    finder.start(0, x, crossings);
    const std::vector<Contact> found = finder.finish();
    ASSERT_EQ(found.size(), 1u);
    for (Index side = 0; side < 2; ++side) {
      EXPECT_EQ(found[0].sides[side].part, side);
      EXPECT_EQ(parts[found[0].sides[side].triangles[0]], side);
    }
    // From the other surface to the deepest point, which is on either.
    EXPECT_GT(std::abs(found[0].normal.x()), 0.9);
  }
}

/// The edge of a standing triangle in which a hanging one, that sinks from z = 1.2 to `height`, lands first.
std::vector<Contact> sinking_triangle(double height, double scale) {
  Animation animation;
  animation.topologies = {*Topology::make(3, {{0, 1, 2}}), *Topology::make(3, {{0, 1, 2}})};
  for (const double z : {1.2, height}) {
    animation.poses.push_back(
        {{1, 0.1, 1, 1.2, 0.1, 1, 1.1, 0.1, 0.5}, {1.1, 0, z, 1.1, 0.2, z, 1.1, 0.1, z + 0.3}});
    for (Pose& pose : animation.poses.back()) {
      for (double& x : pose) x *= scale;
    }
  }
  return found_in(animation).value();
}

TEST(FindContacts, WithoutFramesTheContactIsWhereItBegins) {
  for (const double scale : {1.0, 1e308}) {
    const auto found = sinking_triangle(-0.2, scale);
    ASSERT_EQ(found.size(), 1u);
    EXPECT_TRUE(found[0].frames.empty());
    EXPECT_GT(found[0].pairs, 1u);
    EXPECT_NEAR(found[0].first_time, 1.0 / 7, 1e-6);
    EXPECT_LT((found[0].point / scale - Vec3(1.1, 0.1, 1)).norm(), 1e-6)
        << to_eigen(found[0].point).transpose();
    EXPECT_EQ(found[0].low, found[0].point);
  }
}

// Lists that are cut lose pairs, not what crosses in frames of which all crossings are listed.
TEST(FindContacts, AsksForPosesWhereListsAreCut) {
  const Animation animation = passing_balls();
  const auto all = found_in(animation).value();
  StepSettings few;
  few.max_listed = 60;
  const auto found = found_in(animation, few).value();
  ASSERT_EQ(found.size(), 1u);
  EXPECT_LT(found[0].pairs, all[0].pairs);
  EXPECT_GT(found[0].frames.size(), 0u);
}

TEST(FindContacts, RefusesAnswersThatAreNotComplete) {
  StepSettings first;
  first.earliest_only = true;
  EXPECT_FALSE(found_in(passing_balls(), first));
  StepSettings paper;
  const std::vector<std::vector<std::uint8_t>> free;
  paper.declared_free = &free;
  EXPECT_FALSE(found_in(passing_balls(), paper));
}

TEST(FindContacts, PassesOnAnErrorOfTheFrames) {
  const Animation animation = passing_balls();
  int calls = 0;
  const auto done = find_contacts(
      hierarchies(animation, 16),
      [&]() -> Result<std::optional<MotionFrame>> {
        if (++calls == 2) return tl::unexpected(Error{"frame 1", "is missing", "find it"});
        return MotionFrame{0, Positions()};
      },
      [](const Contact&) {});
  EXPECT_FALSE(done);
}

// A sphere, a hair that goes in and out of it, and a hair that sweeps through it between frames.
TEST(FindContacts, ALinePiercesFaces) {
  const Mesh ball = unit_sphere(8);
  Mesh hair;
  hair.positions = {-3, 0.01, 0.02, 3, 0.03, 0.01};
  hair.lines = {{0, 1}};
  hair.vertex_count = 2;
  Animation animation;
  animation.topologies = {ball.topology(), hair.topology()};
  for (const double y : {3.0, 0.0, -3.0})
    animation.poses.push_back({ball.positions, placed(hair, 1, {0, y, 0})});
  auto found = found_in(animation).value();
  ASSERT_EQ(found.size(), 1u);
  EXPECT_TRUE(found[0].pierces);
  ASSERT_EQ(found[0].frames.size(), 1u);
  EXPECT_EQ(found[0].frames[0].crossings, 2u);  // in and out
  EXPECT_FALSE(found[0].depth());
  EXPECT_FALSE(found[0].frames[0].area[0]);
  EXPECT_TRUE(found[0].curves.empty());
  EXPECT_NEAR(found[0].point.norm(), 1, 0.05);  // one of both holes
  EXPECT_LT(std::hypot(found[0].point.y(), found[0].point.z()), 0.1);
  animation.poses.erase(animation.poses.begin() + 1);
  found = found_in(animation).value();
  ASSERT_EQ(found.size(), 1u);
  EXPECT_TRUE(found[0].pierces);
  EXPECT_TRUE(found[0].frames.empty());
}

// A box stands on another; then it is lifted, and only its hair goes into the one below.
TEST(FindContacts, WhatOnlyTouchesNeverGoesThrough) {
  const Mesh below = box({}, Vec3::Constant(0.5), 3);
  Mesh above = box({0.125, 0.125, 0.75}, Vec3::Constant(0.25), 2);
  // Above the corner that stands next to where the hair goes in: what is joined has neighboring vertices.
  const Vec3 root(-0.125, -0.125, 0.75);
  const auto at_root = [&](Index v) { return Vec3::load(&above.positions[3 * v]) == root; };
  Index first = 0;
  while (!at_root(first)) ++first;
  above.lines = {{first, above.vertex_count++}};
  Animation animation = {{below.topology(), above.topology()}, {}};
  for (const double lift : {0.0, 0.1}) {
    Pose pose = placed(above, 1, {0, 0, lift});
    const Vec3 tip = root + (lift == 0 ? Vec3(-0.1, -0.11, 0.2) : Vec3(-0.02, -0.03, -0.4));
    pose.insert(pose.end(), {tip.x(), tip.y(), tip.z()});
    animation.poses.push_back({below.positions, pose});
  }
  const auto found = found_in(animation).value();
  ASSERT_EQ(found.size(), 1u);
  ASSERT_EQ(found[0].frames.size(), 2u);
  EXPECT_TRUE(found[0].frames[0].touching);
  EXPECT_GT(found[0].frames[0].curve_length, 0);
  EXPECT_EQ(found[0].frames[1].severity(), 0);
  EXPECT_EQ(found[0].worst, 1u);
  EXPECT_FALSE(found[0].touching());
}

// Hairs change nothing about the depth of the surfaces that they are on.
TEST(FindContacts, HairsDoNotChangeADepth) {
  Animation animation = passing_balls();
  const auto bald = found_in(animation).value();
  Mesh hairy = unit_sphere(8);
  const Index n = hairy.vertex_count;
  for (Index v = 0; v < n; ++v) {
    hairy.lines.push_back({v, n + v});
    for (int k = 0; k < 3; ++k) hairy.positions.push_back(1.3 * hairy.positions[3 * v + k]);
  }
  hairy.vertex_count *= 2;
  for (Index v = 0; v + 1 < n; ++v) hairy.lines.push_back({n + v, n + v + 1});  // joins all, inside or not
  animation.topologies[0] = hairy.topology();
  for (auto& pose : animation.poses) pose[0] = hairy.positions;
  const auto found = found_in(animation).value();
  ASSERT_EQ(bald.size(), 1u);
  const auto deepest =
      std::ranges::max_element(found, {}, [](const Contact& c) { return c.depth().value_or(-1); });
  ASSERT_NE(deepest, found.end());
  EXPECT_FALSE(deepest->pierces);
  EXPECT_NEAR(deepest->depth().value_or(0), bald[0].depth().value(), 1e-12);
}

}  // namespace
}  // namespace foldproof
