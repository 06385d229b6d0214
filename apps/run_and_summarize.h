/// What `check` and `report` do once motions are open.
#pragma once

#include "report/report.h"

namespace foldproof {

/// Checks the motions behind a progress bar, prints the summary unless `quiet`, and gives the exit code.
/// Ctrl-C ends it before the next step, and no writer is finished.
Result<int> run_and_summarize(Motions motions, const CheckSettings& settings, Writers writers, bool quiet);

}  // namespace foldproof
