#include "file_arguments.h"

#include <fmt/format.h>
#include <glob.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "base/try.h"
#include "io/formats.h"
#include "io/numbered.h"
#include "terminal.h"

namespace foldproof {
namespace {

namespace fs = std::filesystem;

constexpr const char* kStandardOutput = "-";

using Output = FileArguments::Output;
using Input = FileArguments::Input;

/// Identifies a file on a disk, independent of its name.
using FileId = std::pair<::dev_t, ::ino_t>;

/// Nothing if there is no file or directory that writing could overwrite.
std::optional<FileId> id_of(const fs::path& path) {
  struct ::stat status = {};
  if (::stat(path.c_str(), &status) != 0) return std::nullopt;
  if (!S_ISREG(status.st_mode) && !S_ISDIR(status.st_mode)) return std::nullopt;
  return FileId{status.st_dev, status.st_ino};
}

/// The same for all spellings of a path, whether or not the file exists.
std::string canonical(const fs::path& path) {
  std::error_code code;
  const fs::path full = fs::weakly_canonical(fs::absolute(path, code), code);
  return code ? path.lexically_normal().string() : full.string();
}

/// The directory that contains a path's file.
fs::path directory_of(const fs::path& path) {
  return path.parent_path().empty() ? fs::path(".") : path.parent_path();
}

// ---- Names of outputs

Result<void> require_directory_to_write(const std::string& where, const fs::path& directory) {
  std::error_code code;
  const fs::file_status status = fs::status(directory, code);
  if (!fs::exists(status))
    return fail(ErrorCode::FileAccess, where,
                fmt::format("cannot be written: there is no directory '{}'", directory.string()),
                "make it, or name another file");
  if (!fs::is_directory(status))
    return fail(ErrorCode::FileAccess, where,
                fmt::format("cannot be written: '{}' is no directory", directory.string()),
                "name another file");
  if (::access(directory.c_str(), W_OK | X_OK) != 0)
    return fail(ErrorCode::FileAccess, where,
                fmt::format("cannot be written: nothing may be written into '{}'", directory.string()),
                "name a file elsewhere, or change the permissions");
  return {};
}

Result<void> require_good_name(const Option& option, const std::string& path, Output output) {
  if (path.empty()) {
    return fail(
        ErrorCode::InvalidArgument, option.name(), "names nothing",
        fmt::format("name the file to write{}", option.is_required() ? "" : ", or leave the option out"));
  }
  const std::string where = fmt::format("{} {}", option.name(), path);
  if (path == kStandardOutput && output == Output::Text) return {};
  if (path == kStandardOutput)
    return fail(ErrorCode::InvalidArgument, where, "cannot be standard output", "name a file");
  std::error_code code;
  const fs::file_status status = fs::status(path, code);
  if (code == std::errc::filename_too_long)
    return fail(ErrorCode::FileAccess, where, "cannot be written: the name is too long",
                "give a shorter one");
  if (path.back() == '/' || fs::is_directory(status))
    return fail(ErrorCode::FileAccess, where, "cannot be written: it is a directory", "name a file in it");
  if (output == Output::Motion) {
    const std::string extension = extension_of(path);
    if (extension != ".npz" && extension != ".obj" && extension != ".ply")
      return fail(ErrorCode::UnsupportedFormat, where, "is not a format that is written here",
                  "name it .npz, .obj or .ply");
  }
  // A pipe or a terminal is written directly.
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    if (::access(path.c_str(), W_OK) == 0) return {};
    return fail(ErrorCode::FileAccess, where, "cannot be written: it is not yours to write",
                "name another file");
  }
  // Of a link, the file that it refers to is replaced.
  const fs::path target = fs::canonical(path, code);
  return require_directory_to_write(where, directory_of(code ? fs::path(path) : target));
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

/// All existing files that an output may replace.
std::vector<fs::path> replaced(const fs::path& path, Output output) {
  std::vector<fs::path> files{path};
  const fs::path stem = fs::path(path).replace_extension();
  if (output == Output::Motion && extension_of(path.string()) == ".obj")
    files.push_back(fs::path(path).replace_extension(".pc2"));
  if (output == Output::Collection) {
    std::error_code code;
    for (fs::directory_iterator at(stem, code), end; !code && at != end; at.increment(code))
      files.push_back(at->path());
  }
  const auto pattern = io::number_pattern(path.string());
  if (pattern && (output == Output::Numbered || output == Output::Motion)) {
    std::error_code ignored;
    const auto numbered = io::numbered_files(*pattern, ignored);
    files.insert(files.end(), numbered.begin(), numbered.end());
  }
  return files;
}

// ---- Files that inputs read

/// Whether a file may hold frames or motions.
bool may_be_read(const fs::path& path) { return io::format_of(path.string()) != nullptr; }

/// "a%20b.bin" -> "a b.bin"
std::string without_escapes(const std::string& uri) {
  std::string text;
  const auto digit = [](char c) { return std::isxdigit(static_cast<unsigned char>(c)) != 0; };
  for (std::size_t i = 0; i < uri.size(); ++i) {
    if (uri[i] == '%' && i + 2 < uri.size() && digit(uri[i + 1]) && digit(uri[i + 2])) {
      text += static_cast<char>(std::stoi(uri.substr(i + 1, 2), nullptr, 16));
      i += 2;
    } else {
      text += uri[i];
    }
  }
  return text;
}

/// Collects the values of "uri" without keeping the rest of a possibly large file.
class Uris : public nlohmann::json::json_sax_t {
 public:
  std::vector<std::string> all;

  bool key(string_t& name) override {
    is_uri_ = name == "uri";
    return true;
  }
  bool string(string_t& value) override {
    if (std::exchange(is_uri_, false) && !value.starts_with("data:")) all.push_back(value);
    return true;
  }
  bool null() override { return true; }
  bool boolean(bool) override { return true; }
  bool number_integer(number_integer_t) override { return true; }
  bool number_unsigned(number_unsigned_t) override { return true; }
  bool number_float(number_float_t, const string_t&) override { return true; }
  bool binary(binary_t&) override { return true; }
  bool start_object(std::size_t) override { return true; }
  bool end_object() override { return true; }
  bool start_array(std::size_t) override { return true; }
  bool end_array() override { return true; }
  bool parse_error(std::size_t, const std::string&, const nlohmann::json::exception&) override {
    return false;
  }

 private:
  bool is_uri_ = false;
};

void add_file(const fs::path& path, std::vector<fs::path>& files) {
  files.push_back(path);
  const std::string extension = extension_of(path.string());
  if (extension == ".pvd") {
    for (const std::string& file : io::pvd_files(path.string()).value_or(std::vector<std::string>()))
      files.emplace_back(file);
  }
  if (extension != ".gltf") return;
  std::ifstream text(path, std::ios::binary);
  Uris uris;
  nlohmann::json::sax_parse(text, &uris);
  for (const std::string& uri : uris.all) files.push_back(path.parent_path() / without_escapes(uri));
}

template <class Directory>
void add_members(const fs::path& directory, std::vector<fs::path>& files) {
  std::error_code code;
  for (Directory at(directory, fs::directory_options::skip_permission_denied, code), end; !code && at != end;
       at.increment(code)) {
    if (may_be_read(at->path())) add_file(at->path(), files);
  }
}

/// All files that an input refers to.
std::vector<fs::path> read_under(const std::string& name, Input input) {
  std::vector<fs::path> files;
  std::error_code code;
  if (fs::is_directory(name, code)) {
    files.emplace_back(name);
    if (input == Input::Library) {
      add_members<fs::recursive_directory_iterator>(name, files);
    } else {
      add_members<fs::directory_iterator>(name, files);
    }
  } else if (!fs::exists(name, code) && name.find_first_of("*?[") != name.npos) {
    ::glob_t matches{};
    if (::glob(name.c_str(), GLOB_NOSORT, nullptr, &matches) == 0) {
      for (std::size_t k = 0; k < matches.gl_pathc; ++k) add_file(matches.gl_pathv[k], files);
    }
    ::globfree(&matches);
  } else if (const auto pattern = io::number_pattern(name); pattern && !fs::exists(name, code)) {
    for (const std::string& file : io::numbered_files(*pattern, code)) add_file(file, files);
  } else {
    add_file(name, files);
  }
  return files;
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
  std::set<std::string> names;
  std::map<FileId, std::string> replaceable;  // existing files, and the output that would replace them
  for (const auto& [option, output, endings] : outputs_) {
    const auto given = option.values();
    if (given.empty()) continue;
    const std::string& path = given.back();
    FOLDPROOF_TRY(require_good_name(option, path, output));
    const std::string where = fmt::format("{} {}", option.name(), path);
    const auto twice = [&] {
      return fail(ErrorCode::InvalidArgument, where, "is named for two outputs", "give each its own file");
    };
    const bool is_file = path != kStandardOutput;
    if (!names.insert(is_file ? canonical(path) : path).second) return twice();
    if (!is_file) {
      print_to_standard_error();
      continue;
    }
    for (const fs::path& file : replaced(path, output)) {
      const auto id = id_of(file);
      if (id && !replaceable.emplace(*id, where).second && replaceable[*id] != where) return twice();
    }
  }
  for (const auto& [option, input] : inputs_) {
    if (replaceable.empty()) break;
    for (const std::string& name : option.values()) {
      for (const fs::path& file : read_under(name, input)) {
        const auto id = id_of(file);
        const auto clash = id ? replaceable.find(*id) : replaceable.end();
        if (clash == replaceable.end()) continue;
        return fail(
            ErrorCode::InvalidArgument, clash->second,
            fmt::format("would write over '{}', which is read ({} {})", file.string(), option.name(), name),
            "name another file to write");
      }
    }
  }
  for (const auto& [option, output, endings] : outputs_) {
    const auto given = option.values();
    if (!given.empty()) FOLDPROOF_TRY(require_good_ending(option, given.back(), output, endings));
  }
  return {};
}

}  // namespace foldproof
