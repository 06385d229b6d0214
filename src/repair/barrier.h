/// Pairs of features that are close, and the barrier that keeps them apart.
#pragma once

#include <map>
#include <optional>

#include "foldproof/solver.h"
#include "repair/scene.h"

namespace foldproof::inline internal {

/// Two features that are closer than `range`, as they are nearest to each other.
struct NearPair {
  std::array<Index, 4> vertices;
  std::array<double, 4> w;  ///< How much the difference of their closest points changes with each vertex.
  Vec3 normal;              ///< Unit; from the second feature to the first.
  double gap;               ///< Distance beyond the thickness, mesh units, > 0.
  double range;             ///< The barrier begins at this gap.
};

/// -(y - 1)^2 ln y of y = gap / range < 1, and its derivatives by the gap.
double barrier(double gap, double range);
double barrier_slope(double gap, double range);
double barrier_curvature(double gap, double range);

/// Two features that may come near.
struct Candidate {
  FeaturePair pair;
  double range;  ///< As in NearPair.
  double gap;    ///< Where it was listed.
};

/// How close pairs may come before the barrier acts. A pair that is closer in a pose that is good keeps
/// nearly that distance.
struct BarrierRange {
  double thickness = 0;
  double range = 0;
  std::span<const double> rest = {};           ///< Features are good here; empty: nothing is known.
  std::span<const double> target = {};         ///< The frame as it came in,
  std::span<const std::uint8_t> touched = {};  ///< and per vertex, whether it is bad there.

  /// Sets the ranges of pairs.
  void limit(std::span<Candidate> pairs) const;
  /// That of one.
  double of(const FeaturePair& pair) const {
    Candidate candidate{pair, 0, 0};
    limit({&candidate, 1});
    return candidate.range;
  }
};

/// Evaluates a pair; none where the gap is out of range. `share`: how much of a vertex's change counts.
std::optional<NearPair> near_pair(const FeaturePair& pair, const FourPoints& x, double range,
                                  double thickness, double share);

/// Finds the pairs of poses, from a Verlet list: all pairs that are at most a slack farther apart than the
/// range in one pose, which is complete until a vertex has moved by half of the slack.
class NearPairs {
 public:
  static Result<NearPairs> make(const RepairScene& scene, std::span<const double> rest,
                                const std::shared_ptr<const PairFilter>& filter);
  /// Another frame: all ranges change.
  void start(const BarrierRange& range);
  /// All pairs of a pose within range that are not ignored. `active`: per vertex; pairs without a vertex that
  /// is not 0 are left out; empty: none is.
  Result<void> find(std::span<const double> x, std::span<const std::uint8_t> active,
                    std::vector<NearPair>& out);
  /// Whether all pairs are listed that may touch between the pose where the list was made and x.
  bool knows_touching(std::span<const double> x) const;
  /// Those, where it knows them.
  void may_touch(std::span<const double> x, std::vector<FeaturePair>& out) const;

 private:
  explicit NearPairs(const RepairScene& scene) : scene_(&scene) {}
  Result<void> list(std::span<const double> x, std::span<const std::uint8_t> active);
  bool is_near(std::span<const double> x, double length) const;
  bool was_moved(std::span<const double> x, Index v) const;
  bool is_ignored(const FeaturePair& pair) const;

  const RepairScene* scene_;
  std::unique_ptr<ContactChecker> checker_;
  std::shared_ptr<const PairFilter> filter_;  // null: the checker's mesh ignores what is ignored
  std::map<Triangle, Index> triangles_;       // of the scene, by key_of; with a filter
  BarrierRange range_;
  Candidates found_;
  std::vector<Candidate> list_;
  std::vector<double> listed_at_;
  std::vector<std::uint8_t> may_move_;  // per vertex; other pairs are as in the frame, and not listed
};

}  // namespace foldproof::inline internal
