/// Stage 1 of the pipeline, motion: positions of all objects during a step.
#pragma once

#include <atomic>

#include "check/leaf_pairs.h"
#include "foldproof/check.h"

namespace foldproof::inline internal {

/// The largest side of a box; finite.
double largest_extent(const Bounds& bounds);

inline Vec3 position(std::span<const double> x, Index vertex) {
  return Vec3::load(&x[3 * std::size_t{vertex}]);
}

/// Validated positions in the scene's frame, and kinetic BVHs over them. Either of a step, or of a motion of
/// several steps that extrapolates the first one.
class StepMotion {
 public:
  explicit StepMotion(std::span<const Object> objects);

  Index size() const { return static_cast<Index>(bvhs_.size()); }
  const Hierarchy& hierarchy(Index object) const { return *bvhs_[object].hierarchy; }
  std::span<const KineticBvh> bvhs() const { return bvhs_; }
  /// Of all objects.
  std::size_t leaf_count() const { return leaf_count_; }
  /// An object's hierarchy in parts, of which a single large one has some hundred.
  const Subtrees& subtrees(Index object) const { return *subtrees_[object]; }

  /// Checks sizes and numbers, then refits every object. `steps`: the number of steps of the motion, the
  /// given one included.
  Result<void> update(Positions x0, Positions x1, Index steps = 1);
  /// Error: there are not three numbers per vertex, one is not finite, or x1 - x0 overflows.
  Result<void> check(Positions x0, Positions x1) const;
  /// The same of the numbers of vertices of no triangle; all others are checked when they are used.
  /// Precondition: fits.
  Result<void> check_isolated_vertices(Positions x0, Positions x1) const;
  /// Whether there are three numbers per vertex of each object.
  bool fits(Positions x0, Positions x1) const;

  /// Computes the boxes of the features of these leaves.
  void fill_features(std::span<const TraversalTask> tasks, std::span<const TaskLeaves> pairs);

  // Of the last update:

  const Frame& frame() const { return frame_; }
  /// The number of steps of the motion: as requested, or 1 where the extrapolation would overflow.
  Index steps() const { return steps_; }
  /// The largest side of the scene's bounding box, mesh units: during the first step, and during all of them.
  double step_extent() const { return step_extent_; }
  double motion_extent() const { return motion_extent_; }
  /// The mean edge length of the object with the shortest edges at the start, mesh units. From a sample. At
  /// most eight times what a quarter of the edges do not exceed: every second edge of a fan is short.
  double mean_edge_length() const;
  /// By how much the leaves' boxes grow when they bound the whole motion instead of its start: the ratio of
  /// the sums of their sides.
  double swept_extent_ratio() const;

  /// The part of the motion, which goes from time 0 to 1, that fits a step best. Distances are the maximum
  /// along any axis, in the frame, over a sample of the vertices.
  struct StepLocation {
    float times[2];             ///< Of the step's start and end.
    float deviation;            ///< Of the step's ends from the motion at these times.
    float motion_displacement;  ///< During the motion.
    float step_displacement;    ///< During the step.
  };
  StepLocation locate(Positions x0, Positions x1) const;
  /// KineticBvh::deviation of all objects.
  KineticBvh::Deviation deviation(Positions x0, Positions x1, const float (&times)[2]) const;

 private:
  Result<void> check_sizes(Positions x0, Positions x1) const;
  Result<void> read(Positions x0, Positions x1);

  std::vector<KineticBvh> bvhs_;
  std::vector<std::shared_ptr<const std::vector<Index>>> isolated_;  // vertices of no triangle, per object
  Frame frame_;
  double step_extent_ = 0, motion_extent_ = 0;
  Index steps_ = 1;
  std::size_t leaf_count_ = 0;
  std::vector<std::shared_ptr<const Subtrees>> subtrees_;
  std::vector<std::size_t> first_leaf_;  // per object, in a row with the leaves of all of them
  std::vector<std::atomic<std::uint8_t>> leaf_needed_;
};

/// Positions at both ends of a stretch of a step. Kept, so that a second long step allocates nothing.
class StretchEnds {
 public:
  /// Interpolates at two times between the positions at both ends of the step, of vertices of triangles only.
  /// At time t all are taken back by t * drift, so that what they have in common does not count as motion.
  void interpolate(const StepMotion& motion, const std::array<Positions, 2>& x, const double (&times)[2],
                   const Vec3& drift);
  Positions start() const { return starts_; }
  Positions end() const { return ends_; }

 private:
  std::vector<std::vector<double>> x_[2];
  std::vector<std::span<const double>> starts_, ends_;
};

}  // namespace foldproof::inline internal
