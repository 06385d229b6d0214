/// What keeps a small file from asking for much memory. Meshes beyond these limits get no model.
#pragma once

#include "foldproof/bvh.h"

namespace foldproof {

/// Error when most vertices belong to no triangle.
Result<void> require_few_loose_vertices(const Topology& topology, const std::string& where);

/// Error when so many leaves meet in single vertices that listing all pairs of them would fill the memory.
Result<void> require_few_neighbours(const Hierarchy& hierarchy, const std::string& where);

}  // namespace foldproof
