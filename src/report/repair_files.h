/// The files that a repair writes.
#pragma once

#include "report/repair_motions.h"

namespace foldproof {

/// Where each object that may move is written, in order.
struct RepairOutputs {
  std::vector<std::string> paths;
  ReadOptions read;  ///< How the input was read.
  Index in_betweens = 0;
};

/// "once", "2 times".
std::string how_often_given(std::size_t count);

/// Refuses, before work starts, what cannot be written: an output too many or too few, or one of a format
/// that does not hold this motion.
Result<void> require_outputs_fit(const RepairOutputs& outputs, Motions motions,
                                 std::span<const Index> movable, std::size_t frames);

/// Whether a file holds single precision only, which is proven then.
bool is_single_precision(const std::string& path, std::size_t frames);

/// Writes all. GLB is read again, and checked, before it appears. Precondition: done.report.written.
Result<void> write_outputs(const RepairOutputs& outputs, Motions motions, const RepairRequest& request,
                           const RepairedMotions& done);

}  // namespace foldproof
