/// Mesh files that are numbered: the frames of one motion.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "foldproof/base.h"

namespace foldproof::io {

/// A path in whose file name "%d" or "%04d" stands for a number.
struct NumberPattern {
  std::string before, after;
  int width = 0;  ///< Of the number, filled with zeros.

  std::string name(std::uint64_t number) const;
};

/// None: the file's name has not exactly one '%', or one that is neither "%d" nor "%0", at most 20, "d".
std::optional<NumberPattern> number_pattern(const std::string& path);

/// Whether a path has a number of any width where the pattern has it.
bool is_numbered(std::string_view path, const NumberPattern& pattern);

/// The existing files whose names have a number of any width where the pattern has it, unsorted. `status`:
/// why their directory could not be listed to its end.
std::vector<std::string> numbered_files(const NumberPattern& pattern, std::error_code& status);

/// What a path has before and after a number in its file's name. A '-' before the number, which may be its
/// sign, is in neither. The file's extension is in lower case.
using AroundNumber = std::pair<std::string, std::string>;

/// Mesh files of one motion, in the order in which they were given.
struct NumberedFiles {
  std::vector<std::string> files;  ///< At least one.
  AroundNumber around;             ///< What all have in common, if there are several.
};

/// Puts together the files of a directory whose names differ in nothing but one number: the last one if files
/// differ there, else the one before, and so on. Sorted by their first files.
std::vector<NumberedFiles> split_by_number(std::span<const std::string> paths);

/// The notes for the user on frames, which are in natural order: numbers that their names leave out, and
/// names that do not continue the numbering. Error: their order is another one if their numbers are negative
/// or decimal fractions, as in "f.-1" and "f.-2", or "f1.5" and "f1.25".
Result<std::vector<std::string>> notes_on_order(std::span<const std::string> paths);

/// How many arguments, from the first on, are mesh files whose names differ in nothing but one number. A mesh
/// that a point cache follows is not among them. At least 1. Precondition: there is an argument.
std::size_t count_numbered(std::span<const std::string> arguments);

}  // namespace foldproof::io
