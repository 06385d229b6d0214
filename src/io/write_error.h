#pragma once

#include <string>
#include <system_error>

#include "foldproof/base.h"

namespace foldproof::io {

/// The error of a file or directory that the system would not write.
inline tl::unexpected<Error> write_error(const std::string& path, const std::error_code& code) {
  return fail(ErrorCode::FileAccess, path, "cannot be written: " + code.message(),
              "check the directory, its permissions and the free space");
}

}  // namespace foldproof::io
