/// Contacts in words.
#pragma once

#include "report/report.h"

namespace foldproof {

/// A line per contact, the worst first, at most `count`; and what is not known. Empty: no contacts were
/// looked for.
std::string contact_lines(Motions motions, const CheckSettings& settings, const CheckTotals& totals,
                          std::size_t count);

}  // namespace foldproof
