#include "io/named_files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fnmatch.h>
#include <glob.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cctype>
#include <fstream>
#include <nlohmann/json.hpp>

#include "base/c_locale.h"
#include "foldproof/io.h"
#include "io/formats.h"
#include "io/numbered.h"

namespace foldproof::io {
namespace {

namespace fs = std::filesystem;

/// The number of a path like /proc/self/fd/1 or /dev/fd/1; -1: it is none.
int number_of_descriptor(const fs::path& path) {
  const std::string name = path.filename().string();
  std::error_code code;
  if (name.empty() || name.size() > 6 || name.find_first_not_of("0123456789") != name.npos) return -1;
  const fs::path open = fmt::format("/proc/{}/fd", ::getpid());
  return fs::canonical(directory_of(path), code) == open ? std::stoi(name) : -1;
}

/// Whether a descriptor is open on the regular file of this path.
bool is_open_on(int descriptor, const fs::path& path) {
  struct ::stat file = {}, open = {};
  return ::stat(path.c_str(), &file) == 0 && ::fstat(descriptor, &open) == 0 && S_ISREG(file.st_mode) &&
         file.st_dev == open.st_dev && file.st_ino == open.st_ino;
}

/// Whether a file may hold frames or motions.
bool may_be_read(const fs::path& path) { return format_of(path.string()) != nullptr; }

/// Whether an argument stands for what it matches.
bool is_glob(const std::string& name) {
  std::error_code code;
  return !fs::exists(name, code) && name.find_first_of("*?[") != name.npos;
}

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
    for (const std::string& file : pvd_files(path.string()).value_or(std::vector<std::string>()))
      files.emplace_back(file);
  }
  if (extension != ".gltf") return;
  std::ifstream text(path, std::ios::binary);
  Uris uris;
  const CLocale numbers;
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

}  // namespace

fs::path directory_of(const fs::path& path) {
  return path.parent_path().empty() ? fs::path(".") : path.parent_path();
}

WriteTarget write_target(const std::string& path) {
  constexpr int kMostLinks = 40;  // as many as Linux follows
  WriteTarget target{path};
  std::error_code code;
  for (int links = 0; links < kMostLinks; ++links) {
    target.descriptor = number_of_descriptor(target.file);
    if (target.descriptor >= 0 || !fs::is_symlink(target.file, code)) break;
    target.file = directory_of(target.file) / fs::read_symlink(target.file, code);
  }
  for (const int descriptor : {STDOUT_FILENO, STDERR_FILENO}) {
    if (target.descriptor < 0 && is_open_on(descriptor, target.file)) target.descriptor = descriptor;
  }
  return target;
}

bool is_standard_output(const std::string& path) {
  return path == "-" || write_target(path).descriptor == STDOUT_FILENO;
}

std::string canonical(const std::string& path) {
  std::error_code code;
  const fs::path full = fs::weakly_canonical(fs::absolute(write_target(path).file, code), code);
  return code ? fs::path(path).lexically_normal().string() : full.string();
}

std::optional<FileId> file_id(const fs::path& path) {
  struct ::stat status = {};
  if (::stat(path.c_str(), &status) != 0) return std::nullopt;
  if (!S_ISREG(status.st_mode) && !S_ISDIR(status.st_mode)) return std::nullopt;
  return FileId{status.st_dev, status.st_ino};
}

std::vector<fs::path> files_of(const std::string& name, bool recursive) {
  std::vector<fs::path> files;
  std::error_code code;
  if (fs::is_directory(name, code)) {
    files.emplace_back(name);
    if (recursive) {
      add_members<fs::recursive_directory_iterator>(name, files);
    } else {
      add_members<fs::directory_iterator>(name, files);
    }
  } else if (is_glob(name)) {
    ::glob_t matches{};
    if (::glob(name.c_str(), GLOB_NOSORT, nullptr, &matches) == 0) {
      for (std::size_t k = 0; k < matches.gl_pathc; ++k) add_file(matches.gl_pathv[k], files);
    }
    ::globfree(&matches);
  } else if (const auto pattern = number_pattern(name); pattern && !fs::exists(name, code)) {
    for (const std::string& file : numbered_files(*pattern, code)) add_file(file, files);
  } else {
    add_file(name, files);
  }
  return files;
}

bool will_read(const std::string& name, const std::string& file) {
  std::error_code code;
  const fs::path full = canonical(file), input = canonical(name);
  if (!may_be_read(full)) return false;
  if (fs::is_directory(name, code))
    return full.parent_path() == input && !full.filename().string().starts_with('.');
  if (is_glob(name)) return ::fnmatch(input.c_str(), full.c_str(), FNM_PATHNAME | FNM_PERIOD) == 0;
  const auto pattern = number_pattern(input.string());
  return pattern && !fs::exists(name, code) && is_numbered(full.string(), *pattern);
}

}  // namespace foldproof::io
