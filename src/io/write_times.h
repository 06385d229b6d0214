/// Motions with the times of their frames.
#pragma once

#include "foldproof/io.h"

namespace foldproof::io {

/// As foldproof::write_npz, and `times` (frames, float64) unless there are none.
Result<void> write_npz(const std::string& path, Motion& motion, std::span<const double> times);

/// As write_obj_pc2, but an MDD, which has the time of each frame. Both files hold 32-bit floats.
Result<void> write_obj_mdd(const std::string& obj_path, const std::string& mdd_path, Motion& motion,
                           std::span<const double> seconds);

}  // namespace foldproof::io
