/// Vertices that lie exactly where others do: mostly seams that a file does not know to be one surface.
#pragma once

#include "report/report.h"

namespace foldproof::inline internal {

/// Looks for such vertices of faces, lines and points when something collides, and follows them from frame to
/// frame. A mesh with such vertices collides in the first frame or step; so nothing is looked for in others.
class Coincidences {
 public:
  explicit Coincidences(Motions motions) : motions_(motions) {}

  /// The frames that are checked, in order.
  void add(Index frame, Positions x);
  /// A notice for each object that has some.
  std::vector<CheckTotals::Notice> notices() const;

 private:
  struct Pair {
    Index vertex, first;  ///< The first one at its place.
    bool parted;
  };
  struct Found {
    std::vector<Pair> pairs;
    std::uint64_t parted = 0;
    Index parted_frame = 0;  ///< The first in which one has parted.
  };

  Motions motions_;
  std::vector<Found> objects_;  // empty before the first frame
  Index first_frame_ = 0;
  bool several_frames_ = false;
};

}  // namespace foldproof::inline internal
