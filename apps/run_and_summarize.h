/// Common to `check` and `report`.
#pragma once

#include "report/report.h"

namespace foldproof {

/// Checks the motions with a progress bar, prints the summary unless `quiet`, and returns the exit code.
/// Ctrl-C ends it before the next step without finishing the writers.
Result<int> run_and_summarize(Motions motions, const CheckSettings& settings, Writers writers, bool quiet);

}  // namespace foldproof
