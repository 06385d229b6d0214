#include "io/named_files.h"

#include <fmt/format.h>

#include <cctype>
#include <fstream>
#include <nlohmann/json.hpp>

#include "foldproof/io.h"
#include "io/formats.h"
#include "io/numbered.h"
#include "system/c_locale.h"

namespace foldproof::io {
namespace {

namespace fs = std::filesystem;

/// Whether a file may hold frames or motions.
bool may_be_read(const fs::path& path) { return format_of(path.generic_string()) != nullptr; }

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
  const std::string extension = extension_of(path.generic_string());
  if (extension == ".pvd") {
    for (const std::string& file : pvd_files(path.generic_string()).value_or(std::vector<std::string>()))
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
    target.descriptor = system::descriptor_named(target.file);
    if (target.descriptor >= 0 || !fs::is_symlink(target.file, code)) break;
    target.file = directory_of(target.file) / fs::read_symlink(target.file, code);
  }
  for (const int descriptor : {system::kStandardOutput, system::kStandardError}) {
    if (target.descriptor < 0 && system::is_open_on(descriptor, target.file)) target.descriptor = descriptor;
  }
  return target;
}

bool is_standard_output(const std::string& path) {
  return path == "-" || write_target(path).descriptor == system::kStandardOutput;
}

std::string canonical(const std::string& path) {
  std::error_code code;
  const fs::path full = fs::weakly_canonical(fs::absolute(write_target(path).file, code), code);
  return code ? fs::path(path).lexically_normal().generic_string() : full.generic_string();
}

std::optional<FileId> file_id(const fs::path& path) {
  const auto status = system::status_of(path);
  if (!status || status->kind == system::FileKind::Other) return std::nullopt;
  return status->id;
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
    for (const std::string& file : system::glob(name)) add_file(file, files);
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
    return full.parent_path() == input && !full.filename().generic_string().starts_with('.');
  if (is_glob(name)) return system::matches(input.generic_string(), full.generic_string());
  const auto pattern = number_pattern(input.generic_string());
  return pattern && !fs::exists(name, code) && is_numbered(full.generic_string(), *pattern);
}

}  // namespace foldproof::io
