#include "ccd/batch.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace foldproof {
namespace {

// Pairs around a common plane, of many sizes and nearly coplanar, so that both answers and the rounding bound
// occur.
FourPoints points(std::mt19937& random, double size, double off_plane) {
  std::uniform_real_distribution<double> u(-1, 1);
  FourPoints x;
  for (Vec3& p : x) p = size * Vec3(u(random), u(random), off_plane * u(random));
  return x;
}

struct Counts {
  int proven = 0, left = 0;
};

Counts expect_proven_pairs_separated(bool edge_edge, double size) {
  std::mt19937 random(edge_edge ? 5 : 6);
  Counts counts;
  for (int round = 0; round < 2000; ++round) {
    PairBatch batch;
    std::array<FourPoints, 8> x0, x1;
    for (int lane = 0; lane < 8; ++lane) {
      const double off_plane = std::pow(10.0, -(round % 18));
      x0[lane] = points(random, size, off_plane);
      x1[lane] = points(random, size, off_plane);
      // The first feature above, the second below, by about as much as they are uneven.
      for (FourPoints* x : {&x0[lane], &x1[lane]}) {
        for (int k = 0; k < (edge_edge ? 2 : 1); ++k) (*x)[k].z() += size * off_plane * (lane % 4);
      }
      batch.set(lane, x0[lane], x1[lane]);
    }
    const unsigned proven = never_coplanar(batch, edge_edge);
    for (int lane = 0; lane < 8; ++lane) {
      if ((proven >> lane & 1) == 0) {
        ++counts.left;
        continue;
      }
      ++counts.proven;
      const auto ccd = edge_edge ? edge_edge_ccd : vertex_face_ccd;
      EXPECT_EQ(ccd(x0[lane], x1[lane], {}).answer, Answer::Separated);
      CcdSettings wide;
      wide.tolerance = size;  // whatever the tolerance: what is proven first stays proven
      EXPECT_EQ(ccd(x0[lane], x1[lane], wide).answer, Answer::Separated);
    }
  }
  return counts;
}

TEST(NeverCoplanar, ProvesOnlyWhatTheWholeNarrowPhaseCallsSeparated) {
  for (const bool edge_edge : {false, true}) {
    for (const double size : {1.0, 1e-8, 1e12}) {
      const Counts counts = expect_proven_pairs_separated(edge_edge, size);
      EXPECT_GT(counts.proven, 2000);
      EXPECT_GT(counts.left, 2000);
    }
  }
}

TEST(NeverCoplanar, LeavesExtremeSizesToTheRescaledTest) {
  for (const double size : {1e-200, 1e200}) {
    PairBatch batch;
    FourPoints x{Vec3(0, 0, size), Vec3(0, 0, 0), Vec3(size, 0, 0), Vec3(0, size, 0)};
    for (int lane = 0; lane < 8; ++lane) batch.set(lane, x, x);
    EXPECT_EQ(never_coplanar(batch, false), 0u);
    EXPECT_EQ(vertex_face_ccd(x, x, {}).answer, Answer::Separated);
  }
}

}  // namespace
}  // namespace foldproof
