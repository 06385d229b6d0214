// What the single-precision tests of candidates drop, held against exact arithmetic (docs/soundness.md, B5):
// pairs of every family, of sizes from that of the frame down to its resolution.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "bvh/traverse.h"
#include "oracle/families.h"
#include "oracle/judge.h"

namespace foldproof {
namespace {

using oracle::Case;
using oracle::Kind;

// One feature: points `begin` to `end` of a case.
KineticBvh feature(const Frame& frame, const Case& c, int begin, int end) {
  const auto count = static_cast<Index>(end - begin);
  const auto coordinates = [&](const FourPoints& x) {
    std::vector<double> all;
    for (int k = begin; k < end; ++k)
      for (int axis = 0; axis < 3; ++axis) all.push_back(x[k][axis]);
    return all;
  };
  std::vector<Triangle> faces;
  std::vector<Edge> lines;
  std::vector<Index> points;
  if (count == 3) faces.push_back({0, 1, 2});
  if (count == 2) lines.push_back({0, 1});
  if (count == 1) points.push_back(0);
  const auto x0 = coordinates(c.x0), x1 = coordinates(c.x1);
  auto hierarchy = Hierarchy::build(*Topology::make(count, faces, lines, points), x0);
  KineticBvh bvh(std::make_shared<Hierarchy>(std::move(*hierarchy)));
  bvh.refit(frame, x0, x1);
  bvh.fill_features(LeafIndex(0));
  return bvh;
}

struct Tally {
  int kept = 0, dropped = 0;  // of pairs whose boxes are near
};

// Tests a case in a frame that is `zoom` times as large as it.
void test(Kind kind, const Case& c, double zoom, double distance, oracle::Rng& rng, Tally& tally) {
  std::vector<double> all;
  for (const FourPoints* x : {&c.x0, &c.x1})
    for (const Vec3& p : *x) all.insert(all.end(), {p.x(), p.y(), p.z()});
  Frame frame = frame_around(all);
  frame.scale /= zoom;
  for (int axis = 0; axis < 3; ++axis)
    frame.center[axis] += oracle::uniform(rng, -0.4, 0.4) * (1 - 1 / zoom) / frame.scale;
  const int cut = kind == Kind::EdgeEdge ? 2 : 1;
  const KineticBvh a = feature(frame, c, 0, cut), b = feature(frame, c, cut, 4);
  const Traversal traversal{&a, &b, separation_margin(frame, distance)};
  const LeafPair leaves{LeafIndex(0), LeafIndex(0)};
  std::vector<std::uint8_t> separated;
  test_leaf_boxes(traversal, {&leaves, 1}, separated);
  if (separated[0]) return;
  CandidateBuffer found;
  find_candidates(traversal, leaves, found);
  const bool kept = !found[kind == Kind::EdgeEdge ? FeaturePair::EdgeEdge : FeaturePair::VertexFace].empty();
  ++(kept ? tally.kept : tally.dropped);
  if (kept) return;
  const CcdSettings settings{.thickness = distance};
  EXPECT_EQ(oracle::judge(kind, c.x0, c.x1, settings, CcdResult{}).complaint, "")
      << describe(kind, c.x0, c.x1, settings) << "\nzoom " << zoom;
}

class Touch : public ::testing::TestWithParam<oracle::Family> {};

TEST_P(Touch, WhatIsDroppedIsFartherThanTheDistance) {
  for (const Kind kind : {Kind::VertexFace, Kind::EdgeEdge}) {
    oracle::Rng rng(21);
    Tally tally;
    for (int i = 0; i < 2000 && !HasFailure(); ++i) {
      const Case c = GetParam().make(kind, rng);
      double size = 0;
      for (int k = 0; k < 4; ++k)
        size = std::max(
            {size, (c.x0[k] - c.x0[0]).cwiseAbs().maxCoeff(), (c.x1[k] - c.x0[0]).cwiseAbs().maxCoeff()});
      const double distance = i % 4 == 0 ? size * std::ldexp(1.0, -static_cast<int>(rng() % 24)) : 0;
      test(kind, c, std::ldexp(1.0, static_cast<int>(rng() % 25)), distance, rng, tally);
    }
    EXPECT_GT(tally.kept, 100);
  }
}

INSTANTIATE_TEST_SUITE_P(Families, Touch,
                         ::testing::ValuesIn(oracle::families().begin(), oracle::families().end()),
                         [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace foldproof
