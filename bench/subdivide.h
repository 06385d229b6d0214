/// Loop subdivision of poses, for scenes whose mesh was subdivided from another's.
#pragma once

#include "foldproof/io.h"

namespace foldproof::bench {

/// The frames of `coarse` subdivided once (Loop 1987), with the triangles and vertex numbers of `fine`, which
/// was made from the same mesh by the same rule: old vertices keep their numbers, every edge got one. Closed
/// meshes only. Error: `fine` is no such mesh.
Result<std::unique_ptr<Motion>> subdivide_like(const Topology& fine, Motion& coarse);

}  // namespace foldproof::bench
