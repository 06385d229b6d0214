/// How far files are read, for a progress bar.
#pragma once

#include <functional>

#include "foldproof/io.h"

namespace foldproof::io {

/// Called while a file is read: its name, the bytes read so far, at least one, and all that are to be read.
using ReadProgress = std::function<void(const std::string& file, std::uint64_t done, std::uint64_t all)>;

/// foldproof::open_motions with progress of the files that it reads whole, and of packed frames of an NPZ.
Result<std::vector<std::unique_ptr<Motion>>> open_with_progress(std::span<const std::string> arguments,
                                                                const ReadOptions& options,
                                                                const ReadProgress& progress);

}  // namespace foldproof::io
