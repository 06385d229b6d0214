// Opens the motions that a command line names: formats by extension, directories, globs, point caches.
#include <fmt/format.h>
#include <glob.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <new>
#include <optional>
#include <system_error>

#include "base/nearest_name.h"
#include "base/try.h"
#include "io/bytes.h"
#include "io/formats.h"
#include "io/numbered.h"
#include "io/text.h"

namespace foldproof {
namespace io {
namespace {

namespace fs = std::filesystem;

bool is_mesh(const std::string& path) { return is_kind(path, FileKind::Mesh); }
bool is_array(const std::string& path) { return is_kind(path, FileKind::Array); }
bool is_point_cache(const std::string& path) { return is_kind(path, FileKind::PointCache); }

/// The run of digits that starts at `i`, without leading zeros; advances `i` past it.
std::string_view digit_run(std::string_view text, std::size_t& i) {
  while (i < text.size() && text[i] == '0') ++i;
  const std::size_t begin = i;
  while (i < text.size() && is_digit(text[i])) ++i;
  return text.substr(begin, i - begin);
}

}  // namespace

bool natural_less(const std::string& a, const std::string& b) {
  std::size_t i = 0, j = 0;
  while (i < a.size() && j < b.size()) {
    if (is_digit(a[i]) && is_digit(b[j])) {
      const std::string_view x = digit_run(a, i), y = digit_run(b, j);
      if (x.size() != y.size()) return x.size() < y.size();
      if (x != y) return x < y;
    } else {
      if (a[i] != b[j]) return static_cast<unsigned char>(a[i]) < static_cast<unsigned char>(b[j]);
      ++i;
      ++j;
    }
  }
  if (a.size() - i != b.size() - j) return a.size() - i < b.size() - j;
  return a < b;  // only leading zeros differ
}

namespace {

/// Opens mesh files as the frames of one motion.
Result<std::unique_ptr<Motion>> open_frames(const std::string& name, std::vector<std::string> paths,
                                            const ReadProgress& progress) {
  std::sort(paths.begin(), paths.end(), natural_less);
  const auto mesh = std::find_if(paths.begin(), paths.end(), is_mesh);
  if (mesh == paths.end()) {
    return fail(ErrorCode::InvalidArgument, name,
                fmt::format("holds no {} files", extensions_of(FileKind::Mesh)),
                "name mesh files, or a directory that holds them");
  }
  for (const std::string& p : paths) {
    if (format_of(p) != format_of(*mesh)) {
      return fail(ErrorCode::InvalidArgument, name, fmt::format("mixes formats: {} and {}", *mesh, p),
                  "name one of them, or keep one format in a directory");
    }
  }
  if (paths.size() >= kNoIndex)
    return fail(ErrorCode::LimitExceeded, name, "holds too many files", "name fewer frames");
  auto notes = FOLDPROOF_TRY(notes_on_order(paths));
  return open_sequence(name, std::move(paths), progress, std::move(notes));
}

tl::unexpected<Error> cannot_list(const std::string& path, const std::error_code& status) {
  return fail(ErrorCode::FileAccess, path, "cannot be listed: " + status.message(), "check the permissions");
}

Result<std::unique_ptr<Motion>> open_directory(const std::string& path, const ReadProgress& progress) {
  std::error_code status;
  std::vector<std::string> paths;
  for (fs::directory_iterator at(path, status), end; !status && at != end; at.increment(status)) {
    const std::string name = at->path().filename().string();
    std::error_code ignored;
    if (!name.starts_with('.') && format_of(name) != nullptr && !at->is_directory(ignored))
      paths.push_back(at->path().string());
  }
  if (status) return cannot_list(path, status);
  return open_frames(path, std::move(paths), progress);
}

bool is_missing(const std::error_code& status) {
  return status == std::errc::no_such_file_or_directory || status == std::errc::not_a_directory;
}

/// What matches a glob, in natural order.
Result<std::vector<std::string>> expand_glob(const std::string& pattern) {
  // ::glob passes no state to its callback, which must not throw either.
  static thread_local std::array<char, 4096> directory;
  static thread_local int code;
  const auto stop_at = [](const char* path, int error) {
    if (is_missing({error, std::generic_category()})) return 0;
    *fmt::format_to_n(directory.data(), directory.size() - 1, "{}", path).out = '\0';
    code = error;
    return 1;
  };
  ::glob_t matches{};
  const int status = ::glob(pattern.c_str(), GLOB_NOSORT, stop_at, &matches);
  std::vector<std::string> paths(matches.gl_pathv, matches.gl_pathv + matches.gl_pathc);
  ::globfree(&matches);
  if (status == GLOB_ABORTED) return cannot_list(directory.data(), {code, std::generic_category()});
  if (status == GLOB_NOSPACE) throw std::bad_alloc();
  std::sort(paths.begin(), paths.end(), natural_less);
  return paths;
}

Result<std::unique_ptr<Motion>> open_glob(const std::string& pattern, const ReadProgress& progress) {
  auto paths = FOLDPROOF_TRY(expand_glob(pattern));
  if (paths.empty()) return fail(ErrorCode::FileAccess, pattern, "matches no files", "check the pattern");
  const auto other = std::ranges::find(paths, nullptr, format_of);
  if (other != paths.end()) {
    return fail(ErrorCode::UnsupportedFormat, pattern,
                fmt::format("matches {}, which is not a format that is read here", *other),
                "give a pattern that only the frames match, such as 'run/*.obj'");
  }
  return open_frames(pattern, std::move(paths), progress);
}

/// What to do about a format that is not read.
std::string remedy_for(std::string_view extension) {
  for (const char* scene : {".abc", ".blend", ".dae", ".fbx", ".usd", ".usda", ".usdc", ".usdz"}) {
    if (extension == scene) return "open it in Blender, and export it as .glb or .obj";
  }
  return fmt::format("give {}, {}, or a mesh followed by its {}", extensions_of(FileKind::Mesh),
                     extensions_of(FileKind::Animation), extensions_of(FileKind::PointCache));
}

/// The error for a name at which there is nothing; says which name beside it is like it.
tl::unexpected<Error> missing(const std::string& argument) {
  constexpr std::size_t kCompared = 1000;
  const fs::path path(argument);
  std::vector<std::string> names;
  std::error_code status;
  fs::directory_iterator at(path.has_parent_path() ? path.parent_path() : ".", status);
  for (const fs::directory_iterator end; !status && at != end && names.size() < kCompared;
       at.increment(status))
    names.push_back(at->path().filename().string());
  std::ranges::sort(names);
  auto error = does_not_exist(argument);
  const auto near = nearest_name(path.filename().string(), names);
  if (near) error.value().remedy = fmt::format("did you mean '{}'?", (path.parent_path() / *near).string());
  return error;
}

Result<std::unique_ptr<Motion>> open_one(const std::string& argument, const ReadOptions& options,
                                         const ReadProgress& progress) {
  std::error_code ignored;
  const fs::file_status status = fs::status(argument, ignored);
  if (fs::is_directory(status)) return open_directory(argument, progress);
  if (!fs::exists(status) && argument.find_first_of("*?[") != std::string::npos)
    return open_glob(argument, progress);
  if (const auto pattern = number_pattern(argument); pattern && !fs::exists(status)) {
    std::error_code listed;
    auto files = numbered_files(*pattern, listed);
    if (listed && !is_missing(listed)) return cannot_list(argument, listed);
    if (files.empty())
      return fail(ErrorCode::FileAccess, argument, "matches no files",
                  "%d stands for a number in their names");
    const auto negative = numbered_files({pattern->before + '-', pattern->after}, listed);
    if (!negative.empty()) {
      return fail(ErrorCode::InvalidArgument, argument,
                  fmt::format("leaves out {}, whose number may be negative", negative.front()),
                  "rename the frames by whole numbers from 0 on, or move that file elsewhere");
    }
    return open_frames(argument, std::move(files), progress);
  }
  if (status.type() == fs::file_type::not_found) return missing(argument);
  const FileFormat* format = format_of(argument);
  if (format == nullptr)
    return fail(ErrorCode::UnsupportedFormat, argument, "is not a format that is read here",
                remedy_for(extension_of(argument)));
  switch (format->kind) {
    case FileKind::Mesh:
      return open_sequence(argument, {argument}, progress);
    case FileKind::Animation:
      return format->open_animation(argument, options, progress);
    case FileKind::Array:
      return fail(ErrorCode::InvalidArgument, argument, "is one array",
                  "name two .npy files, one after the other: vertices and faces");
    case FileKind::PointCache:
      break;
  }
  return fail(ErrorCode::InvalidArgument, argument, "is a point cache without a mesh",
              "name its mesh file right before it");
}

Result<std::vector<std::unique_ptr<Motion>>> open_all(std::span<const std::string> arguments,
                                                      const ReadOptions& options,
                                                      const ReadProgress& progress) {
  std::vector<std::unique_ptr<Motion>> motions;
  for (std::size_t i = 0; i < arguments.size();) {
    const auto rest = arguments.subspan(i);
    const std::size_t numbered = options.mesh_files == MeshFiles::Separate ? 1 : count_numbered(rest);
    Result<std::unique_ptr<Motion>> motion;
    if (is_mesh(rest[0]) && rest.size() > 1 && is_point_cache(rest[1])) {
      motion = format_of(rest[1])->open_cache(rest[0], rest[1], progress);
      i += 2;
    } else if (numbered > 1) {
      const auto files = rest.first(numbered);
      motion = open_frames(fmt::format("{} to {}", *std::ranges::min_element(files, natural_less),
                                       *std::ranges::max_element(files, natural_less)),
                           {files.begin(), files.end()}, progress);
      i += numbered;
    } else if (is_array(rest[0]) && rest.size() > 1 && is_array(rest[1])) {
      motion = open_npy(rest[0], rest[1]);
      i += 2;
    } else {
      motion = open_one(rest[0], options, progress);
      ++i;
    }
    if (motion && options.weld == Weld::Always) motion = weld(std::move(*motion));
    if (!motion) return tl::unexpected(motion.error());
    motions.push_back(std::move(*motion));
  }
  if (options.still) stand_still(motions);
  return motions;
}

}  // namespace

Result<std::vector<std::unique_ptr<Motion>>> open_with_progress(std::span<const std::string> arguments,
                                                                const ReadOptions& options,
                                                                const ReadProgress& progress) {
  if (arguments.empty())
    return fail(ErrorCode::InvalidArgument, "arguments", "no motion is named",
                "name a mesh file or a directory");
  try {
    return open_all(arguments, options, progress);
  } catch (const std::bad_alloc&) {
    return fail(ErrorCode::LimitExceeded, arguments.front(), "does not fit into memory",
                "use a smaller mesh or a larger machine");
  }
}

}  // namespace io

std::string extension_of(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  for (char& c : extension) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return extension;
}

Result<std::vector<std::unique_ptr<Motion>>> open_motions(std::span<const std::string> arguments,
                                                          const ReadOptions& options) {
  return io::open_with_progress(arguments, options, {});
}

}  // namespace foldproof
