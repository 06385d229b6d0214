/// Pairs of features that are close, and the barrier that keeps them apart.
#pragma once

#include <optional>

#include "foldproof/solver.h"
#include "repair/scene.h"

namespace foldproof::inline internal {

/// Two features that are nearest to each other, as in ClosePair, closer than `range`.
struct NearPair {
  std::array<Index, 4> vertices;
  std::array<double, 4> w;  ///< How much the difference of their closest points changes with each vertex.
  Vec3 normal;              ///< Unit; from the second feature to the first.
  double gap;               ///< Distance beyond the thickness, mesh units, > 0.
  double range;             ///< The barrier begins at this gap.
  double count;             ///< How many pairs they are the closest features of.
  bool edges;               ///< They are two edges.
};

/// -(y - 1)^2 ln y of y = gap / range < 1, and its derivatives by the gap.
double barrier(double gap, double range);
double barrier_slope(double gap, double range);
double barrier_curvature(double gap, double range);

/// How close pairs may come before the barrier acts. A pair that is closer in a pose that is good keeps
/// nearly that distance.
struct BarrierRange {
  double thickness = 0;
  double range = 0;
  std::span<const double> rest = {};           ///< Features are good here; empty: nothing is known.
  std::span<const double> target = {};         ///< The frame as it came in,
  std::span<const std::uint8_t> touched = {};  ///< and per vertex, whether it is bad there.

  /// Sets the ranges of pairs, and removes those that are not closer.
  void limit(std::vector<NearPair>& pairs) const;
};

/// Finds the pairs of a pose.
class NearPairs {
 public:
  /// `zones`: as RepairScene::filter_with has them.
  static Result<NearPairs> make(const RepairScene& scene, std::span<const double> rest,
                                const std::vector<Index>& zones);
  /// All pairs within range that are not ignored. `active`: as ContactChecker::close_pairs has it.
  Result<void> find(std::span<const double> x, const BarrierRange& range,
                    std::span<const std::uint8_t> active, std::vector<NearPair>& out);

 private:
  std::unique_ptr<ContactChecker> checker_;
  std::vector<ClosePair> close_;
};

/// Evaluates a pair; none where the gap is out of range. `share`: how much of a vertex's change counts.
std::optional<NearPair> near_pair(const FeaturePair& pair, const FourPoints& x, const BarrierRange& range,
                                  double share);

}  // namespace foldproof::inline internal
