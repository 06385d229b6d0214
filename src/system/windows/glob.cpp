#include "system/file.h"

namespace foldproof::system {
namespace {

namespace fs = std::filesystem;

char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

/// The size of the character in UTF-8 that text begins with.
std::size_t character_size(std::string_view text) {
  std::size_t size = 1;
  while (size < text.size() && (static_cast<unsigned char>(text[size]) & 0xc0) == 0x80) ++size;
  return size;
}

/// The size of the set "[...]" that a pattern begins with; 0: it is none.
std::size_t set_size(std::string_view pattern) {
  std::size_t begin = 1;
  if (begin < pattern.size() && (pattern[begin] == '!' || pattern[begin] == '^')) ++begin;
  const std::size_t end = pattern.find(']', begin + 1);  // a "]" right at the beginning belongs to the set
  return end == pattern.npos ? 0 : end + 1;
}

/// `set`: what is between the brackets.
bool is_in_set(std::string_view set, char c) {
  const bool negated = set.starts_with('!') || set.starts_with('^');
  if (negated) set.remove_prefix(1);
  bool found = false;
  for (std::size_t i = 0; i < set.size(); ++i) {
    const bool is_range = i + 2 < set.size() && set[i + 1] == '-';
    const char last = is_range ? set[i + 2] : set[i];
    found |= lower(set[i]) <= lower(c) && lower(c) <= lower(last);
    if (is_range) i += 2;
  }
  return found != negated;
}

/// Case does not matter, as in names of files.
bool name_matches(std::string_view pattern, std::string_view name) {
  std::string_view rest_of_pattern, rest_of_name;  // after the last "*", and where it may go on
  bool has_star = false;
  while (!name.empty() || !pattern.empty()) {
    if (pattern.starts_with('*')) {
      pattern.remove_prefix(1);
      has_star = true;
      rest_of_pattern = pattern;
      rest_of_name = name;
      continue;
    }
    if (!name.empty() && !pattern.empty()) {
      const std::size_t set = pattern[0] == '[' ? set_size(pattern) : 0;
      const bool matches = set > 0             ? is_in_set(pattern.substr(1, set - 2), name[0])
                           : pattern[0] == '?' ? true
                                               : lower(pattern[0]) == lower(name[0]);
      if (matches) {
        name.remove_prefix(set > 0 || pattern[0] == '?' ? character_size(name) : 1);
        pattern.remove_prefix(set > 0 ? set : 1);
        continue;
      }
    }
    if (!has_star || rest_of_name.empty()) return false;
    rest_of_name.remove_prefix(1);
    pattern = rest_of_pattern;
    name = rest_of_name;
  }
  return true;
}

bool is_hidden_from(std::string_view pattern, std::string_view name) {
  return name.starts_with('.') && !pattern.starts_with('.');
}

}  // namespace

std::vector<std::string> glob(const std::string& pattern, ListError* error) {
  const fs::path whole(pattern);
  std::vector<fs::path> found{whole.root_path()};
  for (const fs::path& part : whole.relative_path()) {
    const std::string name = part.string();
    std::vector<fs::path> next;
    for (const fs::path& directory : found) {
      std::error_code code;
      if (name.find_first_of("*?[") == name.npos) {
        if (fs::exists(directory / part, code)) next.push_back(directory / part);
        continue;
      }
      for (fs::directory_iterator at(directory.empty() ? "." : directory, code), end; !code && at != end;
           at.increment(code)) {
        const std::string entry = at->path().filename().string();
        if (!is_hidden_from(name, entry) && name_matches(name, entry)) next.push_back(directory / entry);
      }
      const bool is_missing =
          code == std::errc::no_such_file_or_directory || code == std::errc::not_a_directory;
      if (!code || is_missing || !error) continue;
      *error = {directory.generic_string(), code};
      return {};
    }
    found = std::move(next);
  }
  std::vector<std::string> paths;
  for (const fs::path& path : found) paths.push_back(path.generic_string());
  return paths;
}

bool matches(const std::string& pattern, const std::string& path) {
  const fs::path patterns(pattern), names(path);
  auto name = names.begin();
  for (const fs::path& part : patterns) {
    if (name == names.end() || is_hidden_from(part.string(), name->string()) ||
        !name_matches(part.string(), name->string()))
      return false;
    ++name;
  }
  return name == names.end();
}

}  // namespace foldproof::system
