/// Limits that keep a small file from claiming much memory. Meshes beyond them get no model.
#pragma once

#include "foldproof/bvh.h"

namespace foldproof::inline internal {

/// Error on big-endian processors: arrays of a model file, which is little-endian, are used in place.
Result<void> require_byte_order(const std::string& path);

/// Error when far more vertices than triangles.
Result<void> require_few_loose_vertices(const Topology& topology, const std::string& where);

/// Error when so many leaves share single vertices that a list of all their pairs would fill the memory.
Result<void> require_few_neighbors(const Hierarchy& hierarchy, const std::string& where);

}  // namespace foldproof::inline internal
