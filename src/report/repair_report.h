/// What a repair did, in a sentence for people and in JSON: the same in the terminal, the page and the
/// add-on.
#pragma once

#include <functional>

#include "report/json_values.h"
#include "report/repair_motions.h"

namespace foldproof {

/// Whether the motion touches nothing now, or where it still does, and what was not tested.
CheckVerdict repair_verdict(Motions motions, const RepairRequest& request, const RepairReport& report);

/// Frames were given up, and something may not move: letting it move may help.
bool no_way(const RepairRequest& request, const RepairReport& report);

/// "frame 3", "frames 3, 5-9 and 7 more"; empty: none is meant.
Sentence frames_named(const std::vector<RepairedFrame>& frames,
                      const std::function<bool(const RepairedFrame&)>& is_meant);

/// Contacts as lists show them, the worst first.
CheckTotals contact_totals(std::vector<Contact> contacts, const RepairReport& report);

/// The verdict, how far each frame was moved, and all contacts (docs/repair.md).
Json repair_json(Motions motions, const RepairRequest& request, const RepairReport& report);
/// The same as a file.
Result<void> write_repair_json(const std::string& path, Motions motions, const RepairRequest& request,
                               const RepairReport& report);

}  // namespace foldproof
