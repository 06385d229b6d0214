// Continuous collision of one pair of features: conservative advancement in one lane of a batch.

#include <algorithm>
#include <limits>

#include "base/plain_arithmetic.h"
#include "ccd/bounds.h"
#include "ccd/conservative_advancement.h"
#include "ccd/nearest_points.h"
#include "foldproof/ccd.h"

namespace foldproof {
namespace {

CcdResult pair_ccd(const FourPoints& x0, const FourPoints& x1, bool edge_edge, const CcdSettings& settings) {
  const PlainArithmetic plain;
  PairBatch pairs{};
  pairs.set(0, x0, x1);
  ConservativeAdvancement advancement(edge_edge, settings);
  if (advancement.load(pairs, 1) == 0) return {Answer::Separated, 1};
  const int lane = advancement.start(0, settings.latest);
  while (advancement.iterate() == 0) {
  }
  return advancement.result(lane);
}

Closest closest(const FourPoints& x, bool edge_edge) {
  const PlainArithmetic plain;
  PairBatch pairs{};
  pairs.set(0, x, x);
  NearestBatch nearest;
  nearest_points(pairs, 1, edge_edge, std::numeric_limits<double>::infinity(), nearest);
  const auto& d = nearest.difference;
  return {nearest.distance[0], Vec3(d[0][0], d[1][0], d[2][0])};
}

}  // namespace

CcdResult vertex_face_ccd(const FourPoints& x0, const FourPoints& x1, const CcdSettings& settings) {
  return pair_ccd(x0, x1, false, settings);
}

CcdResult edge_edge_ccd(const FourPoints& x0, const FourPoints& x1, const CcdSettings& settings) {
  return pair_ccd(x0, x1, true, settings);
}

double ccd_resolution(double extent) {
  const PlainArithmetic plain;
  return std::max(kResolution * extent, kMinTolerance);
}

Closest vertex_face_closest(const FourPoints& x) { return closest(x, false); }

Closest edge_edge_closest(const FourPoints& x) { return closest(x, true); }

}  // namespace foldproof
