// Opens the motions that a command line names: formats by extension, directories, globs, point caches.
#include <fmt/format.h>

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
#include "system/file.h"

namespace foldproof {
namespace io {
namespace {

namespace fs = std::filesystem;

bool is_mesh(const std::string& path) { return is_kind(path, FileKind::Mesh); }
bool is_array(const std::string& path) { return is_kind(path, FileKind::Array); }
bool is_animation(const std::string& path) { return is_kind(path, FileKind::Animation); }
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

Result<std::unique_ptr<Motion>> open_numbered(std::string name, std::vector<std::string> files,
                                              const ReadProgress& progress) {
  for (const std::string& file : files) {
    if (format_of(file) == format_of(files[0])) continue;
    return fail(ErrorCode::InvalidArgument, name, fmt::format("mixes formats: {} and {}", files[0], file),
                "name frames of one format");
  }
  MotionInfo info{.notes = FOLDPROOF_TRY(notes_on_order(files))};
  if (split_by_number(files).size() > 1) {
    for (const std::string& file : files) info.frame_names.push_back(fs::path(file).stem().generic_string());
  }
  if (files.size() > 1) info.taken_as = fmt::format("{} frames of one mesh", files.size());
  return open_sequence(std::move(name), std::move(files), progress, std::move(info));
}

namespace {

tl::unexpected<Error> cannot_list(const std::string& path, const std::error_code& status) {
  return fail(ErrorCode::FileAccess, path, "cannot be listed: " + status.message(), "check the permissions");
}

/// What is in a directory and may be read.
Result<std::vector<std::string>> list_directory(const std::string& path) {
  std::error_code status;
  std::vector<std::string> paths;
  for (fs::directory_iterator at(path, status), end; !status && at != end; at.increment(status)) {
    const std::string name = at->path().filename().generic_string();
    std::error_code ignored;
    if (!name.starts_with('.') && format_of(name) != nullptr && !at->is_directory(ignored))
      paths.push_back(at->path().generic_string());
  }
  if (status) return cannot_list(path, status);
  return paths;
}

bool is_missing(const std::error_code& status) {
  return status == std::errc::no_such_file_or_directory || status == std::errc::not_a_directory;
}

/// What matches a glob, in natural order.
Result<std::vector<std::string>> expand_glob(const std::string& pattern) {
  system::ListError error;
  auto paths = system::glob(pattern, &error);
  if (error.code) return cannot_list(error.directory, error.code);
  std::sort(paths.begin(), paths.end(), natural_less);
  return paths;
}

/// What matches a glob, all of which must be of formats that are read.
Result<std::vector<std::string>> list_glob(const std::string& pattern) {
  auto paths = FOLDPROOF_TRY(expand_glob(pattern));
  if (paths.empty()) return fail(ErrorCode::FileAccess, pattern, "matches no files", "check the pattern");
  const auto other = std::ranges::find(paths, nullptr, format_of);
  if (other != paths.end()) {
    return fail(ErrorCode::UnsupportedFormat, pattern,
                fmt::format("matches {}, which is not a format that is read here", *other),
                "give a pattern that only the frames match, such as 'run/*.obj'");
  }
  return paths;
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
    names.push_back(at->path().filename().generic_string());
  std::ranges::sort(names);
  auto error = does_not_exist(argument);
  const auto near = nearest_name(path.filename().generic_string(), names);
  if (near)
    error.value().remedy = fmt::format("did you mean '{}'?", (path.parent_path() / *near).generic_string());
  return error;
}

/// What matches a name with "%d".
Result<std::vector<std::string>> list_numbered(const std::string& argument, const NumberPattern& pattern) {
  std::error_code listed;
  auto files = numbered_files(pattern, listed);
  if (listed && !is_missing(listed)) return cannot_list(argument, listed);
  if (files.empty()) {
    return fail(ErrorCode::FileAccess, argument, "matches no files", "%d stands for a number in their names");
  }
  const auto negative = numbered_files({pattern.before + '-', pattern.after}, listed);
  if (!negative.empty()) {
    return fail(ErrorCode::InvalidArgument, argument,
                fmt::format("leaves out {}, whose number may be negative", negative.front()),
                "rename the frames by whole numbers from 0 on, or move that file elsewhere");
  }
  return files;
}

/// Sorts what a directory, a glob or a name with "%d" stands for. Error: it is not mesh files of one format.
Result<void> require_meshes(const std::string& name, std::vector<std::string>& paths) {
  std::sort(paths.begin(), paths.end(), natural_less);
  const auto mesh = std::ranges::find_if(paths, is_mesh);
  if (mesh == paths.end()) {
    const auto animation = std::ranges::find_if(paths, is_animation);
    return fail(ErrorCode::InvalidArgument, name,
                fmt::format("holds no {} files", extensions_of(FileKind::Mesh)),
                animation != paths.end() ? fmt::format("name {}, which is in it", *animation)
                                         : "name mesh files, or a directory that holds them");
  }
  for (const std::string& p : paths) {
    if (format_of(p) != format_of(*mesh)) {
      return fail(ErrorCode::InvalidArgument, name, fmt::format("mixes formats: {} and {}", *mesh, p),
                  is_animation(p) ? fmt::format("name {} alone, or keep it elsewhere", p)
                                  : "name one of them, or keep one format in a directory");
    }
  }
  if (paths.size() >= kNoIndex)
    return fail(ErrorCode::LimitExceeded, name, "holds too many files", "name fewer frames");
  return {};
}

/// Of files in their order, at least one.
std::string range_of(std::span<const std::string> files) {
  return fmt::format("{} to {}", files.front(), files.back());
}

class Opener {
 public:
  Opener(const ReadOptions& options, const ReadProgress& progress) : options_(options), progress_(progress) {}

  Result<std::vector<std::unique_ptr<Motion>>> open(std::span<const std::string> arguments) {
    for (std::size_t i = 0; i < arguments.size();) i += FOLDPROOF_TRY(add_first(arguments.subspan(i)));
    if (options_.mesh_files == MeshFiles::ByName && options_.still) FOLDPROOF_TRY(separate_misfits());
    FOLDPROOF_TRY(require_clips());
    std::vector<std::unique_ptr<Motion>> motions;
    for (Opened& opened : opened_) {
      if (!opened.frames_by_name.empty())
        FOLDPROOF_TRY(require_frames(*opened.motion, opened.frames_by_name));
      if (options_.weld == Weld::Always) opened.motion = FOLDPROOF_TRY(weld(std::move(opened.motion)));
      motions.push_back(FOLDPROOF_TRY(with_loose_vertices(std::move(opened.motion), options_.points)));
    }
    if (options_.still) stand_still(motions);
    return motions;
  }

 private:
  struct Opened {
    std::unique_ptr<Motion> motion;
    std::vector<std::string> frames_by_name;  // files that only their names make frames; else empty
  };

  /// Opens what the first argument, and maybe others after it, stand for. Returns how many they are.
  Result<std::size_t> add_first(std::span<const std::string> arguments) {
    const std::string& first = arguments[0];
    if (arguments.size() > 1 && is_mesh(first) && is_point_cache(arguments[1])) {
      FOLDPROOF_TRY(add(format_of(arguments[1])->open_cache(first, arguments[1], progress_)));
      return 2;
    }
    if (arguments.size() > 1 && is_array(first) && is_array(arguments[1])) {
      FOLDPROOF_TRY(add(open_npy(first, arguments[1])));
      return 2;
    }
    const std::size_t frames = count_frames(arguments);
    if (frames == 1) {
      FOLDPROOF_TRY(add_one(first));
    } else {
      std::vector<std::string> files(arguments.begin(),
                                     arguments.begin() + static_cast<std::ptrdiff_t>(frames));
      std::ranges::sort(files, natural_less);
      const std::string name = range_of(files);
      FOLDPROOF_TRY(add_frames(name, std::move(files)));
    }
    return frames;
  }

  /// How many arguments, from the first on, are frames of one motion.
  std::size_t count_frames(std::span<const std::string> arguments) const {
    if (options_.mesh_files == MeshFiles::Separate) return 1;
    std::size_t count = count_numbered(arguments);
    if (options_.mesh_files != MeshFiles::Sequence || count > 1) return count;
    // Without a number in common they are one sequence, too, up to those that have one or a cache.
    const auto is_next = [&](std::size_t i) {
      return is_mesh_file(arguments[i]) && count_numbered(arguments.subspan(i)) == 1 &&
             (i + 1 == arguments.size() || !is_point_cache(arguments[i + 1]));
    };
    count = 0;
    while (count < arguments.size() && is_next(count)) ++count;
    return std::max<std::size_t>(1, count);
  }

  static bool is_mesh_file(const std::string& path) {
    std::error_code ignored;
    return is_mesh(path) && fs::is_regular_file(path, ignored);
  }

  Result<void> add(Result<std::unique_ptr<Motion>> motion) {
    opened_.push_back({FOLDPROOF_TRY(std::move(motion)), {}});
    return {};
  }

  Result<void> add_one(const std::string& argument) {
    std::error_code ignored;
    const fs::file_status status = fs::status(argument, ignored);
    if (fs::is_directory(status)) return add_files(argument, FOLDPROOF_TRY(list_directory(argument)));
    if (!fs::exists(status) && argument.find_first_of("*?[") != std::string::npos)
      return add_files(argument, FOLDPROOF_TRY(list_glob(argument)));
    if (const auto pattern = number_pattern(argument); pattern && !fs::exists(status))
      return add_files(argument, FOLDPROOF_TRY(list_numbered(argument, *pattern)));
    if (status.type() == fs::file_type::not_found) return missing(argument);
    return add(open_file(argument));
  }

  Result<std::unique_ptr<Motion>> open_file(const std::string& path) const {
    const FileFormat* format = format_of(path);
    if (format == nullptr) {
      return fail(ErrorCode::UnsupportedFormat, path, "is not a format that is read here",
                  remedy_for(extension_of(path)));
    }
    switch (format->kind) {
      case FileKind::Mesh:
        return open_sequence(path, {path}, progress_);
      case FileKind::Animation:
        return format->open_animation(path, options_, progress_);
      case FileKind::Array:
        return fail(ErrorCode::InvalidArgument, path, "is one array",
                    "name two .npy files, one after the other: vertices and faces");
      case FileKind::PointCache:
        break;
    }
    return fail(ErrorCode::InvalidArgument, path, "is a point cache without a mesh",
                "name its mesh file right before it");
  }

  /// The files that one argument stands for.
  Result<void> add_files(const std::string& name, std::vector<std::string> paths) {
    FOLDPROOF_TRY(require_meshes(name, paths));
    if (options_.mesh_files == MeshFiles::Separate) return add_bodies(paths, {});
    FOLDPROOF_TRY(notes_on_order(paths));  // also of files whose names make them bodies
    if (options_.mesh_files != MeshFiles::ByName) return add_frames(name, std::move(paths));
    auto sets = split_by_number(paths);
    for (NumberedFiles& set : sets) {
      const std::string set_name = sets.size() == 1        ? name
                                   : set.files.size() == 1 ? set.files[0]
                                                           : range_of(set.files);
      FOLDPROOF_TRY(add_frames(set_name, std::move(set.files)));
    }
    return {};
  }

  /// Mesh files in natural order as the frames of one motion.
  Result<void> add_frames(const std::string& name, std::vector<std::string> files) {
    auto motion = FOLDPROOF_TRY(open_numbered(name, files, progress_));
    if (options_.mesh_files != MeshFiles::ByName || files.size() == 1) files.clear();
    opened_.push_back({std::move(motion), std::move(files)});
    return {};
  }

  /// `note`: the first one's; empty: there is none.
  Result<void> add_bodies(std::span<const std::string> files, std::string note) {
    for (const std::string& file : files) {
      MotionInfo info;
      if (!note.empty()) info.notes.push_back(std::exchange(note, {}));
      FOLDPROOF_TRY(add(open_sequence(file, {file}, progress_, std::move(info))));
    }
    return {};
  }

  Result<void> require_clips() const {
    const auto has_clips = [](const Opened& opened) { return !opened.motion->info().clips.empty(); };
    if (options_.clip.empty() || std::ranges::any_of(opened_, has_clips)) return {};
    return fail(ErrorCode::InvalidArgument, "--clip", "is given, but no file has animations",
                "leave it out; only .gltf and .glb have them");
  }

  /// Files that are frames by their names, but not as many as other motions have, are bodies.
  Result<void> separate_misfits() {
    const Motion* longest = nullptr;
    const auto consider = [&](const Opened& opened) {
      if (longest == nullptr || opened.motion->frame_count() > longest->frame_count())
        longest = opened.motion.get();
    };
    for (const Opened& opened : opened_) {
      if (opened.frames_by_name.empty() && opened.motion->frame_count() > 1) consider(opened);
    }
    // Without another motion, the longest of these is one.
    if (longest == nullptr) {
      for (const Opened& opened : opened_) consider(opened);
    }
    if (longest == nullptr) return {};
    const std::string longest_name = longest->name();
    const Index frames = longest->frame_count();
    for (Opened& opened : std::exchange(opened_, {})) {
      const auto& files = opened.frames_by_name;
      if (files.empty() || opened.motion->frame_count() == frames) {
        opened_.push_back(std::move(opened));
        continue;
      }
      FOLDPROOF_TRY(
          add_bodies(files, fmt::format("{} are bodies, not {} frames: {} has {} (--sequence)",
                                        opened.motion->name(), files.size(), longest_name, frames)));
    }
    return {};
  }

  const ReadOptions& options_;
  const ReadProgress& progress_;
  std::vector<Opened> opened_;
};

}  // namespace

Result<std::vector<std::unique_ptr<Motion>>> open_with_progress(std::span<const std::string> arguments,
                                                                const ReadOptions& options,
                                                                const ReadProgress& progress) {
  if (arguments.empty())
    return fail(ErrorCode::InvalidArgument, "arguments", "no motion is named",
                "name a mesh file or a directory");
  try {
    return Opener(options, progress).open(arguments);
  } catch (const std::bad_alloc&) {
    return fail(ErrorCode::LimitExceeded, arguments.front(), "does not fit into memory",
                "use a smaller mesh or a larger machine");
  }
}

}  // namespace io

std::string extension_of(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().generic_string();
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
