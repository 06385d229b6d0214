/// Cuts a surface into a binary tree of patches that hang together.
#pragma once

#include "foldproof/bvh.h"

namespace foldproof {

/// What tells a hierarchy, see Hierarchy::from_parts.
struct SplitSurface {
  std::vector<Index> triangle_ids, leaf_sizes;
};

/// The same for any number of threads. `positions`: finite. Cost: O(n log n), some 0.5 microseconds per
/// triangle.
SplitSurface split_surface(const Topology& topology, std::span<const double> positions, Index leaf_triangles);

}  // namespace foldproof
