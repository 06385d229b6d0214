/// The page that is embedded in the program.
#pragma once

#include "page/page.h"

namespace foldproof {

/// The files of page/dist when the program was built, with hashes (tools/embed.py); may be empty.
std::vector<PageFile> page_files();

/// Error: the program was built without a page.
Result<std::vector<PageFile>> require_page_files();

}  // namespace foldproof
