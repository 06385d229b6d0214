/// The container of GLB files.
#pragma once

#include "foldproof/io.h"

namespace foldproof::io {

/// Writes a GLB file of a JSON and a binary chunk. Error: a file of 4 GiB or more.
Result<void> write_glb(const std::string& path, std::string json, std::string bytes);

}  // namespace foldproof::io
