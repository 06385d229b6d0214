/// The page that the program carries.
#pragma once

#include "page/page.h"

namespace foldproof {

/// The files of page/dist when the program was built, with sums (tools/embed.py); none when there were none.
std::vector<PageFile> page_files();

/// The same, or why there are none.
Result<std::vector<PageFile>> require_page_files();

}  // namespace foldproof
