#include "page_files.h"

namespace foldproof {

Result<std::vector<PageFile>> require_page_files() {
  auto files = page_files();
  if (!files.empty()) return files;
  return fail(ErrorCode::FileAccess, "this build of foldproof", "has no page to show",
              "make it with './dev build'");
}

}  // namespace foldproof
