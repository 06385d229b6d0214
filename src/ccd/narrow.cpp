// Continuous collision of one pair of features: the march on a batch with one lane in use.

#include <algorithm>

#include "base/plain_arithmetic.h"
#include "ccd/bounds.h"
#include "ccd/march.h"
#include "foldproof/ccd.h"

namespace foldproof {
namespace {

CcdResult pair_ccd(const FourPoints& x0, const FourPoints& x1, bool edge_edge, const CcdSettings& settings) {
  const PlainArithmetic plain;
  PairBatch pairs{};
  pairs.set(0, x0, x1);
  March march(edge_edge, settings);
  if (march.take(pairs, 1) == 0) return {Answer::Separated, 1};
  const int lane = march.start(0, settings.latest);
  while (march.look() == 0) {
  }
  return march.result(lane);
}

Closest closest(const FourPoints& x, bool edge_edge) {
  const PlainArithmetic plain;
  PairBatch pairs{};
  pairs.set(0, x, x);
  return closest_of_first(pairs, edge_edge);
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
  return std::max(kResolution * extent, kLeastTolerance);
}

Closest vertex_face_closest(const FourPoints& x) { return closest(x, false); }

Closest edge_edge_closest(const FourPoints& x) { return closest(x, true); }

}  // namespace foldproof
