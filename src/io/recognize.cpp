#include "io/recognize.h"

#include <algorithm>

namespace foldproof::io {
namespace {

bool is_html(std::string_view start) {
  std::string text(start);
  for (char& c : text) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  const std::size_t first = text.find_first_not_of(" \t\r\n\xef\xbb\xbf");  // blanks, the mark of UTF-8
  return first != text.npos && text[first] == '<' &&
         (text.find("<!doctype html") != text.npos || text.find("<html") != text.npos);
}

/// Text with the mark of UTF-16, of which at least the first characters are ASCII: binary files may begin
/// with any two bytes.
bool is_utf16(std::string_view start) {
  constexpr std::size_t kCharacters = 4;
  if (start.size() < 2 + 2 * kCharacters) return false;
  const bool little = start.starts_with("\xff\xfe"), big = start.starts_with("\xfe\xff");
  for (std::size_t i = 2; i < 2 + 2 * kCharacters; i += 2) {
    const char low = start[i + (little ? 0 : 1)], high = start[i + (little ? 1 : 0)];
    if (high != 0 || low <= 0) return false;
  }
  return little || big;
}

}  // namespace

Result<void> check_is_data(const std::string& path, std::string_view start) {
  if (start.empty()) return fail(ErrorCode::InvalidFile, path, "is empty", "copy or export it again");
  if (start.starts_with("version https://git-lfs.github.com/spec/"))
    return fail(ErrorCode::InvalidFile, path, "is a pointer of Git LFS, not the file itself",
                "run 'git lfs pull'");
  if (is_html(start))
    return fail(ErrorCode::InvalidFile, path, "is an HTML page, not the file itself", "download it again");
  if (is_utf16(start)) return fail(ErrorCode::UnsupportedFormat, path, "is UTF-16 text", "save it as UTF-8");
  return {};
}

}  // namespace foldproof::io
