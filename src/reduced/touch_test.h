/// Whether triangles of two leaves touch in the center's pose.
#pragma once

#include "reduced/pose.h"

namespace foldproof::inline internal {

class TouchTest {
 public:
  TouchTest(const Hierarchy& h, const CenterPose& pose) : h_(h), pose_(pose) {}

  /// Whether triangles of two leaves, or of one with itself, have points in common beyond the vertices and
  /// edges they share. Exact for the computed positions.
  bool leaves_touch(Index leaf_a, Index leaf_b) const;

 private:
  bool triangles_touch(const Triangle& s, const Triangle& t) const;

  const Hierarchy& h_;
  const CenterPose& pose_;
};

}  // namespace foldproof::internal
