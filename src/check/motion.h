/// The pipeline's first stage: where all objects are during a step.
#pragma once

#include "check/leaf_pairs.h"
#include "foldproof/check.h"

namespace foldproof {

/// The largest side of the box around everything; finite.
double largest_extent(const Bounds& bounds);

inline Vec3 position(std::span<const double> x, Index vertex) {
  return Eigen::Map<const Vec3>(&x[3 * std::size_t{vertex}]);
}

/// Positions, validated and read into the scene's frame, and boxes around them.
class StepMotion {
 public:
  explicit StepMotion(std::span<const Object> objects);

  Index size() const { return static_cast<Index>(trees_.size()); }
  const Hierarchy& hierarchy(Index object) const { return *trees_[object].hierarchy; }
  std::span<const KineticTree> trees() const { return trees_; }
  /// Of all objects.
  std::size_t leaf_count() const { return leaf_count_; }

  /// Checks sizes and numbers, then refits every object.
  /// `ahead`: for so many steps, of which this is the first and all others go on as it does.
  Result<void> update(Positions x0, Positions x1, Index ahead = 1);
  /// Error: not as many numbers as there are vertices, or one that is not finite.
  Result<void> check(Positions x0, Positions x1) const;
  /// Error: a vertex of no triangle has coordinates that are not finite. All others are looked at when they
  /// are used. Precondition: fits.
  Result<void> check_isolated_vertices(Positions x0, Positions x1) const;
  /// Whether there are as many numbers as the objects have.
  bool fits(Positions x0, Positions x1) const;

  /// Boxes around the features of these leaves.
  void fill_features(std::span<const TraversalTask> tasks, std::span<const LeafPairRef> pairs);

  // Of the last update:

  const Frame& frame() const { return frame_; }
  /// The largest side of the box around everything during the step, in mesh units.
  double largest_side() const { return largest_side_; }
  /// How many steps it looked ahead: as many as were asked for; 1 where the extrapolation would overflow.
  Index ahead() const { return ahead_; }
  /// The largest side during all of them.
  double reach() const { return reach_; }
  /// The mean length of an edge of the object whose edges are the shortest, at the begin; mesh units, from a
  /// sample.
  double mean_edge() const;

  /// How much longer the sides of leaves' boxes are when they hold the whole step instead of its begin: the
  /// sum of these by the sum of those.
  double sweep_growth() const;

  /// Where a step lies in the motion of the last update, which went from 0 to 1: the times that fit its ends
  /// best, and how far, in the frame, vertices are from where they should be then. `way`: how far the motion
  /// took them; `stride`: how far the step does. All along any axis. Looks at few vertices.
  struct Course {
    float times[2];
    float off, way, stride;
  };
  Course course_of(Positions x0, Positions x1) const;
  /// KineticTree::stray of all objects.
  KineticTree::Strayed stray(Positions x0, Positions x1, const float (&times)[2]) const;

 private:
  Result<void> check_sizes(Positions x0, Positions x1) const;
  Result<void> read(Positions x0, Positions x1);

  std::vector<KineticTree> trees_;
  std::vector<std::shared_ptr<const std::vector<Index>>> isolated_;  // vertices of no triangle, per object
  Frame frame_;
  double largest_side_ = 0, reach_ = 0;
  Index ahead_ = 1;
  std::size_t leaf_count_ = 0;
  std::vector<std::vector<std::uint8_t>> leaf_needed_;
  std::vector<std::pair<Index, Index>> leaves_to_fill_;
};

}  // namespace foldproof
