#include "file_arguments.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <optional>

#include "base/try.h"
#include "io/formats.h"
#include "io/named_files.h"
#include "io/numbered.h"
#include "io/write_error.h"
#include "system/file.h"
#include "terminal.h"

namespace foldproof {
namespace {

namespace fs = std::filesystem;

constexpr const char* kStandardOutput = "-";

using Output = FileArguments::Output;
using Input = FileArguments::Input;

// ---- Names of outputs

Result<void> require_directory_to_write(const std::string& where, const fs::path& directory) {
  std::error_code code;
  const fs::file_status status = fs::status(directory, code);
  if (!fs::exists(status))
    return fail(ErrorCode::FileAccess, where,
                fmt::format("cannot be written: there is no directory '{}'", directory.generic_string()),
                "make it, or name another file");
  if (!fs::is_directory(status))
    return fail(ErrorCode::FileAccess, where,
                fmt::format("cannot be written: '{}' is no directory", directory.generic_string()),
                "name another file");
  if (!system::may_write(directory))
    return fail(
        ErrorCode::FileAccess, where,
        fmt::format("cannot be written: nothing may be written into '{}'", directory.generic_string()),
        "name a file elsewhere, or change the permissions");
  return {};
}

Result<void> require_good_name(const Option& option, const std::string& path, Output output,
                               const std::vector<std::string>& endings) {
  if (path.empty()) {
    return fail(
        ErrorCode::InvalidArgument, option.name(), "names nothing",
        fmt::format("name the file to write{}", option.is_required() ? "" : ", or leave the option out"));
  }
  const std::string where = fmt::format("{} {}", option.name(), path);
  if (io::is_standard_output(path)) {
    if (output == Output::Text) return {};
    return fail(ErrorCode::InvalidArgument, where, "cannot be standard output", "name a file");
  }
  FOLDPROOF_TRY(io::require_possible_name(where, path));
  std::error_code code;
  const fs::file_status status = fs::status(path, code);
  if (code == std::errc::filename_too_long)
    return fail(ErrorCode::FileAccess, where, "cannot be written: the name is too long",
                "give a shorter one");
  if (system::separators().find(path.back()) != std::string_view::npos || fs::is_directory(status))
    return fail(ErrorCode::FileAccess, where, "cannot be written: it is a directory", "name a file in it");
  if (output == Output::Motion) {
    std::vector<std::string> written{".npz", ".obj", ".ply"};
    written.insert(written.end(), endings.begin(), endings.end());
    if (std::ranges::find(written, extension_of(path)) == written.end())
      return fail(ErrorCode::UnsupportedFormat, where, "is not a format that is written here",
                  "name it " + io::any_of(written));
  }
  // A pipe or a terminal is written directly.
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    if (system::may_write(path)) return {};
    return fail(ErrorCode::FileAccess, where, "cannot be written: it is not yours to write",
                "name another file");
  }
  // Of a link, the file that it refers to is replaced.
  return require_directory_to_write(where, io::directory_of(io::write_target(path).file));
}

/// So that no motion is replaced by a table or a picture, and no file is named what it is not.
Result<void> require_good_ending(const Option& option, const std::string& path, Output output,
                                 const std::vector<std::string>& endings) {
  const std::string ending = extension_of(path);
  if (output == Output::Motion || output == Output::Collection || ending.empty()) return {};
  const std::string where = fmt::format("{} {}", option.name(), path);
  if (endings.empty()) {
    if (io::format_of(path) == nullptr) return {};
    return fail(ErrorCode::InvalidArgument, where, fmt::format("has the ending of a motion, {}", ending),
                "name a file that ends otherwise");
  }
  if (std::ranges::find(endings, ending) != endings.end()) return {};
  return fail(ErrorCode::InvalidArgument, where,
              fmt::format("ends in {}, not in {}", ending, io::any_of(endings)), "name another file");
}

// ---- Files that outputs replace

/// What an output takes: no other may have it.
struct Taken {
  std::string where;               ///< The option and its value.
  std::vector<std::string> names;  ///< Canonical.
  std::string directory;           ///< Among the names; all that is in it is replaced. Empty: there is none.
  std::optional<io::NumberPattern> pattern;
};

Taken taken_by(const std::string& where, const fs::path& path, Output output) {
  Taken taken{where, {io::canonical(path.generic_string())}, {}, {}};
  if (output == Output::Motion && extension_of(path.generic_string()) == ".obj") {
    for (const char* cache : {".pc2", ".mdd"})
      taken.names.push_back(io::canonical(fs::path(path).replace_extension(cache).generic_string()));
  }
  if (output == Output::Collection)
    taken.names.push_back(taken.directory =
                              io::canonical(fs::path(path).replace_extension().generic_string()));
  if (output == Output::Numbered || output == Output::Motion)
    taken.pattern = io::number_pattern(taken.names[0]);
  return taken;
}

/// A file that an output writes under a name.
std::string example_of(const Taken& taken, const std::string& name) {
  if (name == taken.directory) return name + "/step000000.vtp";
  return taken.pattern && name == taken.names[0] ? taken.pattern->name(0) : name;
}

/// Whether an output would write what another takes.
bool writes_into(const Taken& output, const Taken& other) {
  return std::ranges::any_of(output.names, [&](const std::string& name) {
    const std::string file = example_of(output, name);
    return std::ranges::find(other.names, name) != other.names.end() ||
           (!other.directory.empty() && file.starts_with(other.directory + "/")) ||
           (other.pattern && io::is_numbered(file, *other.pattern));
  });
}

/// All existing files that an output may replace.
std::vector<fs::path> replaced(const fs::path& path, Output output) {
  std::vector<fs::path> files{path};
  const fs::path stem = fs::path(path).replace_extension();
  if (output == Output::Motion && extension_of(path.generic_string()) == ".obj")
    files.push_back(fs::path(path).replace_extension(".pc2"));
  if (output == Output::Collection) {
    std::error_code code;
    for (fs::directory_iterator at(stem, code), end; !code && at != end; at.increment(code))
      files.push_back(at->path());
  }
  const auto pattern = io::number_pattern(path.generic_string());
  if (pattern && (output == Output::Numbered || output == Output::Motion)) {
    std::error_code ignored;
    const auto numbered = io::numbered_files(*pattern, ignored);
    files.insert(files.end(), numbered.begin(), numbered.end());
  }
  return files;
}

/// The outputs so far.
struct Outputs {
  std::vector<Taken> taken;
  std::map<io::FileId, std::string> replaceable;  ///< Existing files, and the output that would replace them.

  /// Error: a bad name, or what another output takes.
  Result<void> add(const Option& option, const std::string& path, Output output,
                   const std::vector<std::string>& endings);
};

Result<void> Outputs::add(const Option& option, const std::string& path, Output output,
                          const std::vector<std::string>& endings) {
  FOLDPROOF_TRY(require_good_name(option, path, output, endings));
  const std::string where = fmt::format("{} {}", option.name(), path);
  const bool is_file = !io::is_standard_output(path);
  const Taken here = is_file ? taken_by(where, path, output) : Taken{where, {kStandardOutput}, {}, {}};
  bool twice = std::ranges::any_of(
      taken, [&](const Taken& other) { return writes_into(here, other) || writes_into(other, here); });
  taken.push_back(here);
  if (!is_file) print_to_standard_error();
  for (const fs::path& file : is_file ? replaced(path, output) : std::vector<fs::path>()) {
    const auto id = io::file_id(file);
    twice = twice || (id && !replaceable.emplace(*id, where).second && replaceable[*id] != where);
  }
  if (!twice) return {};
  return fail(ErrorCode::InvalidArgument, where, "is named for two outputs", "give each its own file");
}

std::vector<fs::path> read_under(const std::string& name, Input input) {
  return io::files_of(name, input == Input::Library);
}

/// Error: an output would replace what an input reads, or be read as a part of it the next time.
Result<void> require_apart(const Option& option, const std::string& name, Input input,
                           const Outputs& outputs) {
  for (const fs::path& file : read_under(name, input)) {
    const auto id = io::file_id(file);
    const auto clash = id ? outputs.replaceable.find(*id) : outputs.replaceable.end();
    if (clash == outputs.replaceable.end()) continue;
    return fail(ErrorCode::InvalidArgument, clash->second,
                fmt::format("would write over '{}', which is read ({} {})", file.generic_string(),
                            option.name(), name),
                "name another file to write");
  }
  for (const Taken& output : outputs.taken) {
    const auto becomes_frame = [&](const std::string& taken) {
      return input == Input::Motion && io::will_read(name, example_of(output, taken));
    };
    if (std::ranges::any_of(output.names, becomes_frame))
      return fail(ErrorCode::InvalidArgument, output.where,
                  fmt::format("would be a frame of what is read ({} {})", option.name(), name),
                  "name a file elsewhere");
  }
  return {};
}

}  // namespace

Option FileArguments::reads(Option option, Input input) {
  inputs_.push_back({option, input});
  return option;
}

Option FileArguments::writes(Option option, Output output, std::vector<std::string> endings) {
  outputs_.push_back({option, output, std::move(endings)});
  return option;
}

std::vector<fs::path> FileArguments::files_read() const {
  std::vector<fs::path> files;
  for (const auto& [option, input] : inputs_) {
    for (const std::string& name : option.values()) {
      const auto under = read_under(name, input);
      files.insert(files.end(), under.begin(), under.end());
    }
  }
  return files;
}

Result<void> FileArguments::check() const {
  for (const auto& [option, input] : inputs_) {
    const auto given = option.values();
    if (std::find(given.begin(), given.end(), "") != given.end())
      return fail(ErrorCode::InvalidArgument, option.name(), "names nothing", "name what is to be read");
  }
  Outputs outputs;
  for (const auto& [option, output, endings] : outputs_) {
    for (const std::string& path : option.values()) FOLDPROOF_TRY(outputs.add(option, path, output, endings));
  }
  for (const auto& [option, input] : inputs_) {
    for (const std::string& name : option.values()) {
      if (!outputs.taken.empty()) FOLDPROOF_TRY(require_apart(option, name, input, outputs));
    }
  }
  for (const auto& [option, output, endings] : outputs_) {
    for (const std::string& path : option.values())
      FOLDPROOF_TRY(require_good_ending(option, path, output, endings));
  }
  return {};
}

}  // namespace foldproof
