// No collision is missed where parts of a scene differ much in size, far from the origin, or near the ends of
// double's range, on any instruction set.
#include <gtest/gtest.h>

#include <cmath>

#include "base/rounds.h"
#include "foldproof/check.h"
#include "oracle/one_target.h"

namespace foldproof {
namespace {

using testing::on_each_target;
using Pose = std::vector<double>;

std::shared_ptr<const Hierarchy> object(std::vector<Triangle> triangles, const Pose& pose) {
  const auto topology = Topology::make(static_cast<Index>(pose.size() / 3), std::move(triangles)).value();
  return std::make_shared<const Hierarchy>(Hierarchy::build(topology, pose).value());
}

std::size_t collisions(StepChecker& checker, std::vector<std::span<const double>> x0,
                       std::vector<std::span<const double>> x1, const StepSettings& settings) {
  StepResult result;
  EXPECT_TRUE(checker.check(x0, x1, settings, result));
  return result.vertex_face.size() + result.edge_edge.size();
}

std::size_t crossings(StepChecker& checker, std::vector<std::span<const double>> x) {
  StaticResult result;
  EXPECT_TRUE(checker.check_static(x, StepSettings{}, result));
  return result.crossings.size();
}

// Two triangles, one kHeight above the other: one leaf, whose grid is fine along z and coarse along x and y.
constexpr double kHeight = 1e-3;
const Pose kSheet{0, 0, 0, 1, 0, 0, 0, 1, 0, 2, 2, kHeight, 3, 2, kHeight, 2, 3, kHeight};

// A triangle that extends from below the sheet to `ratio` times its height; at x = 2.2 it pierces the sheet.
Pose spike(double x, double ratio) {
  return {x, 2.2, -0.01, x + 0.1, 2.2, -0.01, x + 0.05, 2.25, ratio * kHeight};
}

// Ratios at which cells on the leaf's grid exceed 16 bits and more.
std::vector<double> ratios() {
  std::vector<double> all;
  for (double r = 100; r < 160; r += 0.125 * testing::kShare) all.push_back(r);
  for (double r = 160; r < 1e9; r *= 1 + 0.37 * testing::kShare) all.push_back(r);
  return all;
}

TEST(Sizes, FindsTallObjectsThroughAFlatLeafInEitherOrder) {
  on_each_target([] {
    for (const double ratio : ratios()) {
      const Pose before = spike(1.2, ratio), after = spike(2.2, ratio);
      const auto sheet = object({{0, 1, 2}, {3, 4, 5}}, kSheet), tall = object({{0, 1, 2}}, before);
      for (const bool certificates : {false, true}) {
        StepSettings settings;
        settings.certificates = certificates;
        StepChecker tall_first({tall, sheet}), sheet_first({sheet, tall});
        EXPECT_EQ(collisions(tall_first, {before, kSheet}, {after, kSheet}, settings), 2u) << ratio;
        EXPECT_EQ(collisions(sheet_first, {kSheet, before}, {kSheet, after}, settings), 2u) << ratio;
        EXPECT_EQ(crossings(tall_first, {after, kSheet}), 1u) << ratio;
        EXPECT_EQ(crossings(sheet_first, {kSheet, after}), 1u) << ratio;
      }
    }
  });
}

// A tip that reaches a wall at the end of its second step. An ulp of the positions is kUnit; the scene's
// extent is about `size` ulps.
TEST(Sizes, LookAheadFarFromTheOriginMissesNothing) {
  constexpr double kFar = 0x1p40, kUnit = 0x1p-13;
  for (double size = 10; size <= 5e5; size *= 2) {
    for (int start = -8; start < 0; ++start) {
      for (const int step_length : {1, 2}) {
        const auto tip = [&](double k) {
          const double x = kFar + k * kUnit, back = kFar + (k - size) * kUnit, w = size * kUnit;
          return Pose{x, 0, 0, back, w * 0.3, w * 0.1, back, -w * 0.3, w * 0.2};
        };
        const double at = kFar + (start + 2 * step_length) * kUnit, w = size * kUnit;
        const Pose wall{at, -w, -w, at, w, -w, at, 0, w};
        StepChecker checker({object({{0, 1, 2}}, tip(0)), object({{0, 1, 2}}, wall)});
        StepSettings settings;
        for (int step = 0; step < 2; ++step) {
          const Pose x0 = tip(start + step * step_length), x1 = tip(start + (step + 1) * step_length);
          const std::size_t found = collisions(checker, {x0, wall}, {x1, wall}, settings);
          if (step == 1) {
            EXPECT_GT(found, 0u) << "size " << size << ", start " << start << ", step_length " << step_length;
          }
        }
      }
    }
  }
}

// The squared area of the face is denormal, so naive normalization would not give a unit normal.
TEST(Sizes, AppliesAThicknessFarAboveTheSizeOfAFace) {
  on_each_target([] {
    for (const double a : {1.2e-81, 1.64e-81, 3e-81, 1e-79, 1e-68, 1e-40}) {
      const Pose x0{0, 0, 0, a, 0, 0, 0, a, 0, 0, 0, 1.3, 1, 0, 2, 0, 1, 2};
      Pose x1 = x0;
      x1[11] = 1.0;
      for (const bool certificates : {false, true}) {
        StepChecker checker({object({{0, 1, 2}, {3, 4, 5}}, x0)});
        StepSettings settings;
        settings.certificates = certificates;
        settings.thickness = 1.1;
        StepResult result;
        const std::span<const double> from[] = {x0}, to[] = {x1};
        ASSERT_TRUE(checker.check(from, to, settings, result));
        // The vertex near the face, and each of the face's beside that vertex.
        EXPECT_EQ(result.vertex_face.size(), 4u) << a;
      }
    }
  });
}

}  // namespace
}  // namespace foldproof
