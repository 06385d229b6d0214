/// Closest points of eight pairs of features at rest, one per lane. A lane's answer depends neither on the
/// other lanes nor on the instruction set.
#pragma once

namespace foldproof::inline internal {

struct PairBatch;

inline constexpr int kInside = 4;

/// Closest points of the features of eight pairs.
struct alignas(64) NearestBatch {
  double distance[8];
  double difference[3][8];  ///< [axis][lane]: the first feature's point minus the second's.
  double normal[3][8];      ///< Of length one, along the difference; also where that is zero.
  /// Where the difference is in the patch of MinkowskiBatch. kInside: u along the side from corner 0 to 1, v
  /// along that from 0 to 2. 0 to 3: on the side from corner 0 to 1, 0 to 2, 1 to 2 (1 to 3 of a
  /// parallelogram), 2 to 3, at the share u of it.
  double side[8], u[8], v[8];
};

/// These read positions at t=0 only, and look at the first `count` pairs of a batch, at most eight. Bit k is
/// set unless pair k is proven farther apart than `distance` (docs/soundness.md, V5), which may be infinite.
/// maybe_near is quick and tests one plane; nearest_points tests the best one and fills `out`.
unsigned maybe_near(const PairBatch& pairs, int count, bool edge_edge, double distance);
unsigned nearest_points(const PairBatch& pairs, int count, bool edge_edge, double distance,
                        NearestBatch& out);

}  // namespace foldproof::inline internal
