// What planes and axes separate, held against exact arithmetic (docs/soundness.md, E4): triangles with and
// without common vertices, on a small grid where things touch, and off it by a few roundings.
#include "check/separated_triangles.h"

#include <gtest/gtest.h>

#include <cmath>

#include "oracle/brute_force.h"
#include "oracle/families.h"

namespace foldproof {
namespace {

constexpr int kVertices = 6;

struct Soup {
  std::vector<double> x = std::vector<double>(3 * kVertices);
  Triangle s{}, t{};
};

Soup soup(oracle::Rng& rng, int sides, double noise, double scale) {
  const auto below = [&](int n) { return static_cast<Index>(oracle::uniform(rng, 0, 0.999) * n); };
  Soup out;
  for (double& c : out.x) c = scale * (below(sides) + noise * oracle::uniform(rng, -1, 1));
  for (Index& v : out.s) v = below(kVertices);
  for (Index& v : out.t) v = below(kVertices);
  return out;
}

struct Tally {
  int separated = 0, crossing = 0;
};

// Eight pairs at once: lanes do not know of each other.
Tally test(oracle::Rng& rng, int sides, double noise, double scale, bool two_objects) {
  Tally tally;
  for (int round = 0; round < 100; ++round) {
    TrianglePairs pairs;
    std::array<Soup, 8> soups;
    for (int lane = 0; lane < 8; ++lane) {
      Soup& p = soups[lane] = soup(rng, sides, noise, scale);
      for (int k = 0; k < 3; ++k) {
        if (two_objects) {  // the same shape, with vertices of its own
          p.t[k] += kVertices;
        }
        const auto at = [&](Index v) { return Vec3::load(&p.x[3 * (v % kVertices)]); };
        pairs.set(lane, 0, k, at(p.s[k]), p.s[k]);
        pairs.set(lane, 1, k, at(p.t[k]), p.t[k]);
      }
      if (two_objects) p.x.insert(p.x.end(), p.x.begin(), p.x.begin() + 3 * kVertices);
    }
    const unsigned separated = separated_triangles(pairs);
    for (int lane = 0; lane < 8; ++lane) {
      const Soup& p = soups[lane];
      const bool cross = oracle::triangles_cross(p.s, p.t, p.x), is_separated = (separated >> lane & 1) != 0;
      tally.crossing += cross;
      tally.separated += is_separated;
      EXPECT_FALSE(cross && is_separated)
          << ::testing::PrintToString(p.x) << ::testing::PrintToString(p.s) << ::testing::PrintToString(p.t);
    }
  }
  return tally;
}

TEST(SeparatedTriangles, NothingThatCrosses) {
  oracle::Rng rng(1);
  for (const bool two_objects : {false, true}) {
    // Below 1e-97 and above 1e97 the filter of E1 must not be asked.
    for (const double scale : {0x1p-352, 0x1p-330, 0x1p-30, 1.0, 0x1p300, 0x1p341}) {
      for (const int sides : {2, 3, 5}) {
        for (const double noise : {0.0, 0x1p-52, 0x1p-45, 0.1}) {
          const Tally tally = test(rng, sides, noise, scale, two_objects);
          EXPECT_GT(tally.crossing, 10);
          EXPECT_GT(tally.separated, 10) << scale << " " << sides << " " << noise;
        }
      }
    }
  }
}

// Neighbors on a smooth surface hardly ever need exact arithmetic.
TEST(SeparatedTriangles, NeighborsOnASurface) {
  oracle::Rng rng(2);
  int separated = 0, all = 0;
  for (int round = 0; round < 500; ++round) {
    TrianglePairs pairs;
    for (int lane = 0; lane < 8; ++lane) {
      const double begin = oracle::uniform(rng, 0, 6);
      const auto around = [&](int k) {  // a fan of five around vertex 0
        const double angle = begin + 1.2566 * k;
        return Vec3(std::cos(angle), std::sin(angle), oracle::uniform(rng, -0.1, 0.1));
      };
      const int first = static_cast<int>(oracle::uniform(rng, 0, 4.99));
      const Vec3 corners[2][3] = {{Vec3::Zero(), around(first), around(first + 1)},
                                  {Vec3::Zero(), around(first + 2), around(first + 3)}};
      const double numbers[2][3] = {{0, 1, 2}, {0, 3, 4}};
      for (int side = 0; side < 2; ++side)
        for (int k = 0; k < 3; ++k) pairs.set(lane, side, k, corners[side][k], numbers[side][k]);
    }
    separated += __builtin_popcount(separated_triangles(pairs));
    all += 8;
  }
  EXPECT_GT(separated, 0.9 * all);
}

}  // namespace
}  // namespace foldproof
