#pragma once

#include <string>
#include <system_error>

#include "foldproof/base.h"
#include "system/file.h"

namespace foldproof::io {

/// The error of a file or directory that the system would not write.
inline tl::unexpected<Error> write_error(const std::string& path, const std::error_code& code) {
  return fail(ErrorCode::FileAccess, path, "cannot be written: " + code.message(),
              "check the directory, its permissions and the free space");
}

/// Error, about `where`: the system keeps a name of this path for other things.
inline Result<void> require_possible_name(const std::string& where, const std::string& path) {
  const std::string problem = system::problem_of_name(path);
  if (problem.empty()) return {};
  return fail(ErrorCode::InvalidArgument, where, "cannot be written: " + problem, "give it another name");
}

}  // namespace foldproof::io
