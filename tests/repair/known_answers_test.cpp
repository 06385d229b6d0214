// Repair: a hundred generated motions whose corrections are known.
#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <random>

#include "base/rounds.h"
#include "foldproof/eigen.h"
#include "repair/motions.h"

namespace foldproof::oracle {
namespace {

using testing::rounds;

/// A turn and a shift, with which a whole motion is seen from elsewhere, and larger or smaller.
struct Elsewhere {
  Eigen::Matrix3d turn;
  Eigen::Vector3d shift;
  double scale = 1;

  explicit Elsewhere(std::mt19937_64& rng)
      : turn((Eigen::AngleAxisd(uniform(rng, -3, 3), Eigen::Vector3d::UnitX()) *
              Eigen::AngleAxisd(uniform(rng, -3, 3), Eigen::Vector3d::UnitZ()))
                 .toRotationMatrix()),
        shift(uniform(rng, -3, 3), uniform(rng, -3, 3), uniform(rng, -3, 3)) {}
  Pose pose(const Pose& x) const {
    Pose out(x.size());
    for (std::size_t i = 0; i < x.size(); i += 3)
      to_vec3(scale * (turn * to_eigen(Vec3::load(&x[i])) + shift)).store(&out[i]);
    return out;
  }
  TestMotion motion(TestMotion motion) const {
    for (Pose& x : motion.frames) x = pose(x);
    return motion;
  }
};

constexpr int kSteps = 3;  // the frame in which balls are deepest

/// Balls that meet at a vertex of each, where they are as deep as is said. `meet`: these vertices.
TestMotion balls_that_meet(double depth, Index divisions, std::mt19937_64& rng, std::array<Index, 2>& meet) {
  const Mesh ball = unit_sphere(divisions);
  meet[0] = static_cast<Index>(rng() % ball.vertex_count);
  const Vec3 axis = Vec3::load(&ball.positions[3 * std::size_t{meet[0]}]);
  TestMotion motion = pressed_balls(depth, divisions, kSteps, false, axis);
  meet[1] = ball.vertex_count + farthest(motion, -axis);
  return motion;
}

/// Surfaces are kept apart by up to the clearance in addition.
void expect_moved(double moved, double depth, double clearance) {
  EXPECT_GT(moved, 0.95 * depth);
  EXPECT_LT(moved, 1.05 * (depth + clearance));
}

TEST(RepairOfKnownAnswer, TwoBallsMoveByHalfOfTheirDepthEach) {
  std::mt19937_64 rng(1);
  for (int round = 0; round < rounds(30); ++round) {
    SCOPED_TRACE(round);
    const double depth = uniform(rng, 0.2, 0.4);
    Elsewhere elsewhere(rng);
    elsewhere.scale = std::pow(10, uniform(rng, -6, 6));
    std::array<Index, 2> meet;
    const TestMotion motion = elsewhere.motion(balls_that_meet(depth, 8, rng, meet));
    ASSERT_GT(touching(motion, motion.frames), 0u);
    const Repaired done = repaired(motion, {.accuracy = 0.1});
    expect_proven(motion, done);
    for (const Index v : meet)
      expect_moved(done.correction(motion, kSteps, v).norm(), elsewhere.scale * depth / 2,
                   done.report.clearance / 2);
  }
}

TEST(RepairOfKnownAnswer, OneBallMovesByAllOfItWhereTheOtherIsFixed) {
  std::mt19937_64 rng(2);
  for (int round = 0; round < rounds(30); ++round) {
    SCOPED_TRACE(round);
    const double depth = uniform(rng, 0.2, 0.4);
    std::array<Index, 2> meet;
    TestMotion motion = Elsewhere(rng).motion(balls_that_meet(depth, 8, rng, meet));
    const std::size_t fixed = rng() % 2;
    motion.fix(fixed);
    const Repaired done = repaired(motion);
    expect_proven(motion, done);
    expect_moved(done.correction(motion, kSteps, meet[1 - fixed]).norm(), depth, done.report.clearance);
    const Index n = motion.meshes[0].vertex_count, stays = fixed == 0 ? 0 : n;
    for (std::size_t k = 0; k < done.frames.size(); ++k)
      EXPECT_EQ(done.largest(motion, k, stays, stays + n), 0) << k;
  }
}

TEST(RepairOfKnownAnswer, ARigidMotionOfTheWholeMovesIt) {
  std::mt19937_64 rng(3);
  const RepairSettings settings{.accuracy = 1e-3};
  for (int round = 0; round < rounds(20); ++round) {
    SCOPED_TRACE(round);
    const TestMotion motion = pressed_balls(uniform(rng, 0.1, 0.3), 5, 2, true);
    const Elsewhere elsewhere(rng);
    const TestMotion moved = elsewhere.motion(motion);
    const Repaired done = repaired(motion, settings), of_moved = repaired(moved, settings);
    expect_proven(motion, done);
    ASSERT_EQ(of_moved.frames.size(), done.frames.size());
    for (std::size_t k = 0; k < done.frames.size(); ++k) {
      const Pose expected = elsewhere.pose(done.frames[k]);
      for (std::size_t i = 0; i < expected.size(); ++i)
        ASSERT_NEAR(of_moved.frames[k][i], expected[i], 1e-6) << "frame " << k;
    }
  }
}

TEST(RepairOfKnownAnswer, ThicknessIsKept) {
  std::mt19937_64 rng(4);
  for (int round = 0; round < rounds(20); ++round) {
    SCOPED_TRACE(round);
    const double thickness = uniform(rng, 0.005, 0.05), depth = uniform(rng, -thickness / 2, 0.2);
    std::array<Index, 2> meet;
    const TestMotion motion = Elsewhere(rng).motion(balls_that_meet(depth, 6, rng, meet));
    ASSERT_GT(touching(motion, motion.frames, thickness), 0u);
    const Repaired done = repaired(motion, {.thickness = thickness});
    expect_proven(motion, done, thickness);
    double moved = 0;
    for (const Index v : meet) moved += done.correction(motion, kSteps, v).norm();
    EXPECT_GT(moved, depth + thickness);
  }
}

}  // namespace
}  // namespace foldproof::oracle
