/// The HTML report of a repair.
#pragma once

#include "page/page.h"
#include "report/repair_motions.h"

namespace foldproof {

/// A self-contained HTML file: what `repair --json` writes, in words, and the ten worst contacts before and
/// after. The motions are read again. Of more than 200 contacts the worst are listed. `files`: as
/// page_report() takes them. Error: the file cannot be written, a file of the page is missing, a frame cannot
/// be read again.
Result<void> write_repaired_report(const std::string& path, Motions motions, const RepairRequest& request,
                                   const RepairedMotions& done, const std::string& command,
                                   std::span<const PageFile> files);

}  // namespace foldproof
