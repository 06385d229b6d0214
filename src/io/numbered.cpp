#include "io/numbered.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <map>
#include <numeric>

#include "io/formats.h"
#include "io/text.h"
#include "system/file.h"

namespace foldproof::io {
namespace {

namespace fs = std::filesystem;

constexpr const char* kDigits = "0123456789";

std::size_t file_name_of(std::string_view path) { return path.find_last_of(system::separators()) + 1; }

/// How two paths differ: what they have in common before the first difference, and what each has then. A
/// number that differs is whole.
struct Difference {
  Difference(std::string_view first, std::string_view second) {
    auto begin = static_cast<std::size_t>(std::ranges::mismatch(first, second).in1 - first.begin());
    while (begin > 0 && is_digit(first[begin - 1])) --begin;
    before = first.substr(0, begin);
    a = first.substr(begin);
    b = second.substr(begin);
  }

  static std::string_view number(std::string_view text) {
    return text.substr(0, std::min(text.find_first_not_of(kDigits), text.size()));
  }
  static bool same_but_for_number(std::string_view a, std::string_view b) {
    const std::string_view x = number(a), y = number(b);
    return !x.empty() && !y.empty() && a.substr(x.size()) == b.substr(y.size());
  }
  bool is_number() const { return same_but_for_number(a, b); }
  /// "f-1" and "f0".
  bool is_sign() const { return a.starts_with('-') && same_but_for_number(a.substr(1), b); }

  /// Whether the numbers of the paths are negative if a '-' before them is a sign. It surely is none after a
  /// letter, unless `signs`.
  bool may_be_negative(bool signs) const {
    constexpr std::string_view kBeforeSign = "/ ._-=(";
    const std::size_t whole =
        before.find_last_not_of(kDigits, is_fraction() ? before.size() - 2 : before.npos);
    if (!is_number() || whole == before.npos || before[whole] != '-') return false;
    return signs || whole == 0 || kBeforeSign.find(before[whole - 1]) != kBeforeSign.npos;
  }

  /// Whether the paths are in the other order if the numbers are decimal fractions. They are none where they
  /// count on from 9 to 10.
  bool may_be_reversed_fractions() const {
    const std::string_view x = number(a), y = number(b);
    if (!is_fraction() || x.empty()) return false;
    if (!is_number()) return a.substr(x.size()).starts_with('.') && a.substr(x.size() + 1) == b;  // no number
    const bool counts = y.starts_with('1') && y.size() == x.size() + 1 &&
                        x.find_first_not_of('9') == x.npos && y.find_first_not_of('0', 1) == y.npos;
    return y < x && !counts;
  }

  std::string_view before, a, b;

 private:
  bool is_fraction() const {
    return before.size() >= 2 && before.back() == '.' && is_digit(before[before.size() - 2]);
  }
};

/// Nothing where it does not fit.
std::optional<std::uint64_t> value_of(std::string_view number) {
  std::uint64_t value = 0;
  const auto status = std::from_chars(number.data(), number.data() + number.size(), value).ec;
  return status == std::errc() ? std::optional(value) : std::nullopt;
}

/// Around the number that `place` others follow in the file's name; none: there is no such number.
std::optional<AroundNumber> around_number(const std::string& path, std::size_t place) {
  const std::size_t name = file_name_of(path);
  std::size_t first = path.size(), last = 0;
  for (std::size_t found = 0; found <= place; ++found) {
    last = first == 0 ? path.npos : path.find_last_of(kDigits, first - 1);
    if (last == path.npos || last < name) return std::nullopt;
    first = path.find_last_not_of(kDigits, last) + 1;
  }
  first = std::max(first, name);
  if (first > name && path[first - 1] == '-') --first;
  std::string after = path.substr(last + 1);
  const std::string extension = extension_of(path);  // in lower case
  if (after.size() >= extension.size())
    after.replace(after.size() - extension.size(), extension.size(), extension);
  return AroundNumber{path.substr(0, first), std::move(after)};
}

/// The number, counted from the end, that is all in which the names of two files differ; none: they differ
/// otherwise.
std::optional<std::size_t> place_of_difference(const std::string& a, const std::string& b) {
  for (std::size_t place = 0;; ++place) {
    const auto around = around_number(a, place);
    if (!around) return std::nullopt;
    if (around == around_number(b, place)) return place;
  }
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
    std::string file = directory + at->path().filename().generic_string();
    if (is_numbered(file, pattern)) files.push_back(std::move(file));
  }
  return files;
}

std::vector<NumberedFiles> split_by_number(std::span<const std::string> paths) {
  std::vector<std::size_t> single(paths.size());
  std::iota(single.begin(), single.end(), std::size_t{0});
  std::vector<bool> is_single(paths.size(), true);
  std::map<std::size_t, NumberedFiles> sets;  // by their first files
  for (std::size_t place = 0;; ++place) {
    std::map<AroundNumber, std::vector<std::size_t>> alike;
    for (const std::size_t i : single) {
      if (const auto around = around_number(paths[i], place)) alike[*around].push_back(i);
    }
    if (alike.empty()) break;
    for (const auto& [around, members] : alike) {
      if (members.size() < 2) continue;
      NumberedFiles& set = sets[members[0]];
      set.around = around;
      for (const std::size_t i : members) {
        set.files.push_back(paths[i]);
        is_single[i] = false;
      }
    }
    std::erase_if(single, [&](std::size_t i) { return !is_single[i]; });
  }
  for (const std::size_t i : single) sets[i].files = {paths[i]};
  std::vector<NumberedFiles> all;
  for (auto& [first, set] : sets) all.push_back(std::move(set));
  return all;
}

Result<std::vector<std::string>> notes_on_order(std::span<const std::string> paths) {
  bool signs = false;
  for (std::size_t i = 1; i < paths.size(); ++i) signs |= Difference(paths[i - 1], paths[i]).is_sign();
  std::string jump, break_off;  // the first of each
  std::size_t jumps = 0, breaks = 0;
  for (std::size_t i = 1; i < paths.size(); ++i) {
    const Difference differ(paths[i - 1], paths[i]);
    const std::size_t name = file_name_of(differ.before);
    const std::string a = paths[i - 1].substr(name), b = paths[i].substr(name);
    const bool negative = differ.may_be_negative(signs);
    if (negative || differ.may_be_reversed_fractions()) {
      return fail(ErrorCode::InvalidArgument, paths[i - 1],
                  fmt::format("is sorted before {}, but comes after it if its number is {}", b,
                              negative ? "negative" : "a decimal fraction"),
                  "rename the frames by whole numbers from 0 on");
    }
    const auto x = value_of(differ.a), y = value_of(differ.b);
    if (!differ.is_number() || (x && x == y)) {
      const bool numbered = (a + b).find_first_of(kDigits) != a.npos;
      if (numbered && breaks++ == 0)
        break_off = fmt::format("{} is followed by {}, which does not continue its numbering", a, b);
    } else if (x && y && *y - *x != 1 && jumps++ == 0) {
      jump = fmt::format("frame numbers jump from {} to {}", *x, *y);
    }
  }
  std::vector<std::string> notes;
  const auto add = [&](std::string note, std::size_t count, const char* one, const char* several) {
    if (count == 1) notes.push_back(note + one);
    if (count > 1) notes.push_back(fmt::format("{}, and at {} more places{}", note, count - 1, several));
  };
  add(jump, jumps, ": the step between them was not in the files",
      ": the steps between them were not in the files");
  add(break_off, breaks, ": these may be two motions", ": these may be several motions");
  return notes;
}

std::size_t count_numbered(std::span<const std::string> arguments) {
  const auto is_mesh = [](const std::string& path) { return is_kind(path, FileKind::Mesh); };
  if (arguments.size() < 2 || !is_mesh(arguments[0])) return 1;
  const auto place = place_of_difference(arguments[0], arguments[1]);
  if (!place) return 1;
  const auto first = around_number(arguments[0], *place);
  std::size_t count = 2;
  while (count < arguments.size() && around_number(arguments[count], *place) == first) ++count;
  const bool ends_before_cache = count < arguments.size() && is_kind(arguments[count], FileKind::PointCache);
  return ends_before_cache ? std::max<std::size_t>(1, count - 1) : count;
}

}  // namespace foldproof::io
