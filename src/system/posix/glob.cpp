#include <fmt/format.h>
#include <fnmatch.h>
#include <glob.h>

#include <array>
#include <new>

#include "system/file.h"

namespace foldproof::system {

std::vector<std::string> glob(const std::string& pattern, ListError* error) {
  // ::glob passes no state to its callback, which must not throw either.
  static thread_local std::array<char, 4096> directory;
  static thread_local int code;
  const auto stop_at = [](const char* path, int number) {
    if (number == ENOENT || number == ENOTDIR) return 0;
    *fmt::format_to_n(directory.data(), directory.size() - 1, "{}", path).out = '\0';
    code = number;
    return 1;
  };
  ::glob_t matches{};
  const int status = ::glob(pattern.c_str(), GLOB_NOSORT, error ? +stop_at : nullptr, &matches);
  std::vector<std::string> paths(matches.gl_pathv, matches.gl_pathv + matches.gl_pathc);
  ::globfree(&matches);
  if (status == GLOB_NOSPACE) throw std::bad_alloc();
  if (status == GLOB_ABORTED && error) *error = {directory.data(), {code, std::generic_category()}};
  return paths;
}

bool matches(const std::string& pattern, const std::string& path) {
  return ::fnmatch(pattern.c_str(), path.c_str(), FNM_PATHNAME | FNM_PERIOD) == 0;
}

}  // namespace foldproof::system
