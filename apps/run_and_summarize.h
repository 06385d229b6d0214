/// Common to `check` and `report`.
#pragma once

#include "report/report.h"

namespace foldproof {

/// How many contacts the summary lists unless all are asked for.
inline constexpr std::size_t kFewContacts = 8;

/// Checks the motions with a progress bar, prints the summary and `contacts` contacts unless `quiet`, and
/// returns the exit code. Ctrl-C ends it before the next step without finishing the writers. `read`: how the
/// motions were read.
Result<int> run_and_summarize(Motions motions, const ReadOptions& read, const CheckSettings& settings,
                              Writers writers, bool quiet, std::size_t contacts = kFewContacts);

}  // namespace foldproof
