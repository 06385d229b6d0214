#include "check/motion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace foldproof::internal {
namespace {

// F2: what a search of a part of a step adds to the distance covers how far two interpolated vertices are
// from where they are relative to each other, whatever all vertices have in common.
TEST(StretchEnds, KeepDistancesUpToRounding) {
  constexpr Index kVertices = 30;
  std::vector<Triangle> triangles;
  for (Index v = 0; v < kVertices; v += 3) triangles.push_back({v, v + 1, v + 2});
  const auto topology = Topology::make(kVertices, triangles).value();
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> number(-1, 1);
  double worst = 0;
  for (int round = 0; round < 400; ++round) {
    const double scale = std::ldexp(1.0, static_cast<int>(random() % 400) - 200), shift = 4 * number(random);
    std::vector<double> x0, x1;
    for (Index k = 0; k < 3 * kVertices; ++k) {
      x0.push_back(scale * number(random));
      x1.push_back(scale * (number(random) + shift));
    }
    double largest = 0;
    for (Index k = 0; k < 3 * kVertices; ++k) largest = std::max({largest, std::abs(x0[k]), std::abs(x1[k])});
    const Object object(Hierarchy::build(topology, x0).value());
    const StepMotion motion(std::span(&object, 1));
    const Vec3 drift = 2 * largest * Vec3(number(random), number(random), number(random));
    const double times[] = {0.5 * (1 + number(random)), 1};
    StretchEnds ends;
    ends.interpolate(motion, {Positions(x0), Positions(x1)}, times, drift);
    for (int end = 0; end < 2; ++end) {
      const Positions at = end == 0 ? ends.start() : ends.end();
      for (Index v = 0; v < kVertices; ++v) {
        const Index w = static_cast<Index>(random() % kVertices);
        long double square = 0;
        for (int axis = 0; axis < 3; ++axis) {
          const auto exact = [&](Index i) {
            const long double from = x0[3 * i + axis], to = x1[3 * i + axis];
            return from + times[end] * (to - from);
          };
          const long double off =
              (static_cast<long double>(at[0][3 * v + axis]) - at[0][3 * w + axis]) - (exact(v) - exact(w));
          square += off * off;
        }
        worst = std::max(worst, static_cast<double>(std::sqrt(square) / largest));
      }
    }
  }
  EXPECT_LT(worst, 52 * 0x1p-53);
  EXPECT_GT(worst, 2 * 0x1p-53);
}

}  // namespace
}  // namespace foldproof::internal
