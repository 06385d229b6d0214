/// Loop subdivision of poses, for scenes whose mesh was subdivided from another's.
#pragma once

#include "foldproof/io.h"

namespace foldproof::bench {

/// The frames of `coarse` subdivided once (Loop 1987), with the triangles and vertex numbers of `fine`, which
/// was made from the same mesh by the same rule: old vertices keep their numbers, every edge got one. Closed
/// meshes only. Error: `fine` is no such mesh.
Result<std::unique_ptr<Motion>> subdivide_like(const Topology& fine, Motion& coarse);

/// A motion three times as fine, smoothed: Kobbelt's square-root-of-three subdivision (2000). Borders stay
/// where they are. Error: an edge with more than two triangles, a frame that cannot be read.
Result<std::unique_ptr<Motion>> refine(Motion& coarse);

}  // namespace foldproof::bench
