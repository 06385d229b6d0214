/// NPZ with the times of its frames.
#pragma once

#include "foldproof/io.h"

namespace foldproof::io {

/// As foldproof::write_npz, and `times` (frames, float64) unless there are none.
Result<void> write_npz(const std::string& path, Motion& motion, std::span<const double> times);

}  // namespace foldproof::io
