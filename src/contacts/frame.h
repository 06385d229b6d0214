/// What a contact is in one frame: its curves, regions and depth.
#pragma once

#include "contacts/nearest.h"
#include "contacts/regions.h"
#include "foldproof/contacts.h"

namespace foldproof::inline internal {

/// Measures contacts frame by frame. Keeps scratch.
class FrameMeasurer {
 public:
  explicit FrameMeasurer(const Surfaces& surfaces) : surfaces_(surfaces), regions_(surfaces) {}

  /// Measures the pairs of one contact in the pose `x`. Writes what belongs to this frame into `out`, all but
  /// its time; `folded`: no regions.
  void measure(std::span<const CrossingPair> pairs, bool folded, Positions x, ContactFrame& out);
  /// Of the last measured contact: the triangles of a side that lie entirely inside, ascending.
  std::span<const Index> inside(int side) const { return inside_[side]; }
  /// Writes the last measured frame's triangles, place and curves into `out`.
  void describe(std::span<const CrossingPair> pairs, Positions x, Contact& out) const;

 private:
  void find_deepest(int side, Positions x);
  void list_inner_points(int side, Positions x);
  void list_other_surface(int side, Positions x);

  const Surfaces& surfaces_;
  RegionFinder regions_;
  Curves curves_;
  std::array<Index, 2> objects_{};
  std::array<std::vector<Index>, 2> crossing_;  // triangles, per side
  std::array<std::optional<Region>, 2> region_;
  std::array<std::vector<Index>, 2> inside_;  // the region's triangles that do not cross
  std::vector<Vec3> points_;                  // of one side, inside
  std::vector<Index> other_;
  std::vector<std::array<Vec3, 3>> other_corners_;
  std::vector<std::uint32_t> seen_;  // per triangle: the last search that saw it
  std::uint32_t now_ = 0;
  NearestTriangles tree_;
  std::optional<double> depth_;
  Vec3 deepest_, nearest_;
};

}  // namespace foldproof::inline internal
