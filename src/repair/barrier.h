/// Pairs of features that are close, and the barrier that keeps them apart.
#pragma once

#include <optional>

#include "foldproof/solver.h"
#include "repair/scene.h"

namespace foldproof::inline internal {

/// The closest points of two features, as a combination of their vertices: the difference of the points is
/// the sum of weight times vertex.
struct Weights {
  std::array<double, 4> w;
  Vec3 difference;
};
Weights closest_weights(bool edges, const FourPoints& x);

/// A pair closer than `range`: its gap and how it changes when vertices move.
struct NearPair {
  FeaturePair pair;
  std::array<double, 4> w;  ///< How much the difference changes with each vertex.
  Vec3 normal;              ///< Unit; from the second feature to the first.
  double gap;               ///< Distance beyond the thickness, mesh units, > 0.
  double range;             ///< The barrier begins at this gap.
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
  double of(const FeaturePair& pair) const;
};

/// Finds the pairs of a pose.
class NearPairs {
 public:
  static Result<NearPairs> make(const RepairScene& scene, std::span<const double> rest);
  void set_filter(std::shared_ptr<const PairFilter> filter) { filter_ = std::move(filter); }
  /// All pairs within range that the filter tests.
  Result<void> find(std::span<const double> x, const BarrierRange& range, std::vector<NearPair>& out);

 private:
  explicit NearPairs(const RepairScene& scene) : scene_(&scene) {}
  void add(const FeaturePair& pair, std::span<const double> x, const BarrierRange& range, Index face,
           std::vector<NearPair>& out) const;
  bool is_tested(const FeaturePair& pair, Index face) const;
  Index triangle_with(const Edge& line) const;

  const RepairScene* scene_;
  std::unique_ptr<ContactChecker> checker_;
  std::shared_ptr<const PairFilter> filter_;
  std::vector<Index> faces_;                   // triangle of the scene, by face of the checker
  std::vector<std::pair<Edge, Index>> lines_;  // sorted; and their triangles
  std::vector<Index> points_;                  // per vertex, its triangle; empty: no points
  Candidates candidates_;
};

/// Evaluates a pair; none where the gap is out of range. `share`: how much of a vertex's change counts.
std::optional<NearPair> near_pair(const FeaturePair& pair, const FourPoints& x, const BarrierRange& range,
                                  double share = 1);

}  // namespace foldproof::inline internal
