/// Splits a surface into a binary tree of connected patches.
#pragma once

#include "foldproof/bvh.h"

namespace foldproof::inline internal {

/// The parts of a hierarchy: see Hierarchy::from_parts.
struct SplitSurface {
  std::vector<Index> triangle_ids, leaf_sizes;
};

/// `positions`: finite. The result is the same for any number of threads. Cost: O(n log n), about 0.5
/// microseconds per triangle.
SplitSurface split_surface(const Topology& topology, std::span<const double> positions, Index leaf_triangles);

}  // namespace foldproof::inline internal
