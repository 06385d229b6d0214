/// What a contact is in one frame: its curves, regions and depth.
#pragma once

#include <limits>

#include "contacts/nearest.h"
#include "contacts/regions.h"
#include "foldproof/contacts.h"

namespace foldproof::inline internal {

/// Measures contacts frame by frame. Keeps scratch.
class FrameMeasurer {
 public:
  explicit FrameMeasurer(const Surfaces& surfaces) : surfaces_(surfaces), regions_(surfaces) {}

  /// Measures the pairs of one contact in the pose `x`. Writes what belongs to this frame into `out`, all but
  /// its time; `folded`: the sides are one, so neither has a region of its own.
  void measure(std::span<const CrossingPair> pairs, bool folded, Positions x, ContactFrame& out);
  /// Of the last measured contact: the triangles of a side that lie entirely inside, ascending.
  std::span<const Index> inside(int side) const { return inside_[side]; }
  /// Writes the last measured frame's triangles, place and curves into `out`.
  void describe(std::span<const CrossingPair> pairs, Positions x, Contact& out) const;

 private:
  // The deepest point found so far, and the nearest one of what is outside.
  struct Deepest {
    std::optional<double> depth;
    Vec3 point, nearest;
  };

  // A point inside, or the middle of a piece of an edge.
  struct InnerPoint {
    Vec3 middle, half = Vec3::Zero();                        // half of the piece
    int splits = 0;                                          // how often it is to be split
    Index nearest = 0;                                       // of known_: the nearest of those that are known
    double bound = std::numeric_limits<double>::infinity();  // the square of its depth is not more
  };

  void begin_marks(Index object);
  void list_triangles(std::span<const CrossingPair> pairs, int side, std::vector<Index>& out);
  void find_regions(bool folded, Positions x);
  int front_of(int side, Positions x) const;
  void find_deepest(int side, Positions x);
  void find_deepest_of_body(Positions x);
  void find_reach(Positions x);
  void find_reach_of_tips(int side, Positions x);
  void split_body();
  void set_touching(ContactFrame& out);
  void list_inner_points(const Region& region, Index object, Positions x);
  void begin_other(int side);
  void add_corners(Index object, Positions x, std::size_t begin);
  template <class Skip>
  void add_near(Index object, Positions x, const Vec3& point, double distance, std::size_t most,
                const Skip& skip);
  void raise_to_farthest(std::vector<InnerPoint>& points, Deepest& most);
  void raise_depth_around(int side, Positions x, bool all);
  template <class Skip>
  void raise_depth_around(Index object, Positions x, std::size_t most, const Skip& skip);
  Vec3 middle_of_curves(std::span<const CrossingPair> pairs, Positions x) const;

  const Surfaces& surfaces_;
  RegionFinder regions_;
  Curves curves_;
  std::array<Index, 2> objects_{};
  std::array<std::vector<Index>, 2> crossing_;  // triangles, per side
  std::array<std::vector<Index>, 2> cut_;       // triangles that the curves go through, per side
  std::array<RegionQuery, 2> query_;
  std::array<std::optional<Region>, 2> region_;
  std::vector<Index> body_cut_;  // of both sides
  RegionQuery body_query_;
  std::optional<Region> body_;                // of a surface that goes into itself: both sides as one
  std::array<std::vector<Index>, 2> inside_;  // the region's triangles that do not cross
  std::vector<InnerPoint> points_, left_;     // of one side, inside; those that may be deepest
  std::vector<Index> other_;
  std::vector<std::array<Vec3, 3>> other_corners_;
  std::vector<Index> places_;          // per vertex: where it is in the body's list, if it is there
  std::vector<std::uint8_t> side_of_;  // per vertex of the body
  std::vector<std::uint32_t> seen_;    // per triangle: the last search that saw it
  std::uint32_t now_ = 0;
  std::size_t outside_ = 0;  // so many first ones of other_corners_ are outside as a whole
  std::vector<Vec3> known_;  // points outside
  NearestTriangles nearest_;
  Deepest deepest_;
};

}  // namespace foldproof::inline internal
