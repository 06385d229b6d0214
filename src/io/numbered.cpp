#include "io/numbered.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>

#include "io/formats.h"
#include "io/text.h"

namespace foldproof::io {
namespace {

namespace fs = std::filesystem;

constexpr const char* kDigits = "0123456789";

/// What a path has around a number in its file's name.
struct Around {
  std::string before, after;
  bool operator==(const Around&) const = default;
};

std::size_t file_name_of(const std::string& path) { return path.find_last_of('/') + 1; }

/// Around the last number.
std::optional<Around> around_number(const std::string& path) {
  const std::size_t name = file_name_of(path), last = path.find_last_of(kDigits);
  if (last == path.npos || last < name) return std::nullopt;
  const std::size_t before = path.find_last_not_of(kDigits, last);
  const std::size_t first = before == path.npos ? 0 : before + 1;
  return Around{path.substr(0, first), path.substr(last + 1)};
}

using NumberPair = std::pair<std::uint64_t, std::uint64_t>;

/// The numbers of two paths that differ in one number only.
std::optional<NumberPair> different_numbers(std::string_view a, std::string_view b) {
  auto begin = static_cast<std::size_t>(std::ranges::mismatch(a, b).in1 - a.begin());
  while (begin > 0 && is_digit(a[begin - 1])) --begin;
  const auto take_number = [begin](std::string_view& text, std::uint64_t& number) {
    text.remove_prefix(begin);
    const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), number);
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    return status == std::errc();
  };
  NumberPair numbers;
  const bool both = take_number(a, numbers.first) && take_number(b, numbers.second);
  return both && a == b ? std::optional(numbers) : std::nullopt;
}

}  // namespace

std::string NumberPattern::name(std::uint64_t number) const {
  return fmt::format("{}{:0{}}{}", before, number, width, after);
}

std::optional<NumberPattern> number_pattern(const std::string& path) {
  const std::size_t percent = path.find('%', file_name_of(path));
  if (percent == path.npos || path.find('%', percent + 1) != path.npos) return std::nullopt;
  const std::size_t d = path.find_first_not_of(kDigits, percent + 1);
  if (d == path.npos || path[d] != 'd') return std::nullopt;
  const std::string width = path.substr(percent + 1, d - percent - 1);
  if (width.size() > 3 || (!width.empty() && width[0] != '0')) return std::nullopt;
  NumberPattern pattern{path.substr(0, percent), path.substr(d + 1)};
  std::from_chars(width.data(), width.data() + width.size(), pattern.width);
  return pattern.width > 20 ? std::nullopt : std::optional(pattern);
}

bool is_numbered(std::string_view path, const NumberPattern& pattern) {
  const auto& [before, after, width] = pattern;
  if (path.size() <= before.size() + after.size() || !path.starts_with(before) || !path.ends_with(after))
    return false;
  const auto number = path.substr(before.size(), path.size() - before.size() - after.size());
  return number.find_first_not_of(kDigits) == number.npos;
}

std::vector<std::string> numbered_files(const NumberPattern& pattern, std::error_code& status) {
  const std::string directory = pattern.before.substr(0, file_name_of(pattern.before));
  std::vector<std::string> files;
  for (fs::directory_iterator at(directory.empty() ? "." : directory, status), end; !status && at != end;
       at.increment(status)) {
    std::string file = directory + at->path().filename().string();
    if (is_numbered(file, pattern)) files.push_back(std::move(file));
  }
  return files;
}

std::vector<std::string> notes_on_gaps(std::span<const std::string> paths) {
  std::optional<NumberPair> first;
  std::size_t others = 0;
  for (std::size_t i = 1; i < paths.size(); ++i) {
    const auto numbers = different_numbers(paths[i - 1], paths[i]);
    if (!numbers || numbers->second <= numbers->first || numbers->second - numbers->first == 1) continue;
    if (first) ++others;
    if (!first) first = numbers;
  }
  if (!first) return {};
  const std::string jump = fmt::format("frame numbers jump from {} to {}", first->first, first->second);
  if (others == 0) return {jump + ": the step between them was not in the files"};
  return {
      fmt::format("{}, and at {} more places: the steps between them were not in the files", jump, others)};
}

std::size_t count_numbered(std::span<const std::string> arguments) {
  const auto is_mesh = [](const std::string& path) { return is_kind(path, FileKind::Mesh); };
  const auto first = around_number(arguments[0]);
  if (!first || !is_mesh(arguments[0])) return 1;
  std::size_t count = 1;
  while (count < arguments.size() && around_number(arguments[count]) == first) ++count;
  const bool ends_before_cache = count < arguments.size() && is_kind(arguments[count], FileKind::PointCache);
  return ends_before_cache ? std::max<std::size_t>(1, count - 1) : count;
}

}  // namespace foldproof::io
