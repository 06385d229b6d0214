/// Recognizes files that are not what their names say, whatever the format.
#pragma once

#include <string_view>

#include "foldproof/base.h"

namespace foldproof::io {

/// How many of its first bytes say what a file is.
inline constexpr std::size_t kRecognizedBytes = 512;

/// Error: the file is empty, a pointer of Git LFS, an HTML page or UTF-16 text. `start`: its first bytes.
Result<void> check_is_data(const std::string& path, std::string_view start);

}  // namespace foldproof::io
