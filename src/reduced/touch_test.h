/// Whether triangles of two leaves meet in the centre's pose.
#pragma once

#include "reduced/pose.h"

namespace foldproof {

class TouchTest {
 public:
  TouchTest(const Hierarchy& h, const CentrePose& pose) : h_(h), pose_(pose) {}

  /// Whether triangles of two leaves, or of one with itself, meet beyond the vertices and edges they share.
  /// Exact for the computed positions.
  bool leaves_touch(Index leaf_a, Index leaf_b) const;

 private:
  bool triangles_touch(const Triangle& s, const Triangle& t) const;
  bool folds(const Triangle& s, const Triangle& t) const;

  const Hierarchy& h_;
  const CentrePose& pose_;
};

}  // namespace foldproof
