/// Parts of a mesh from an array of a NumPy archive.
#pragma once

#include "io/npz_array.h"
#include "io/parts.h"

namespace foldproof::io {

/// Reads the first array of the archive whose name part_kind() knows and which holds an integer or a string
/// per triangle; other arrays are none. `path` and `file_size`: the archive's. Error: the array is damaged.
Result<ObjectParts> npz_parts(zip_t* archive, const std::string& path, std::uint64_t file_size,
                              std::size_t triangles);

}  // namespace foldproof::io
