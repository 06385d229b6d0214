// Which files below a directory make a motion together.
#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>

#include "io/formats.h"
#include "sweep/sweep.h"

namespace foldproof {
namespace {

namespace fs = std::filesystem;
using io::FileKind, io::is_kind;

/// What a directory holds, each in natural order.
struct Folder {
  std::vector<std::string> folders, meshes, caches, animations, buffers;
};

std::error_code list(const std::string& path, Folder& folder) {
  std::error_code status;
  for (fs::directory_iterator at(path, status), end; !status && at != end; at.increment(status)) {
    const std::string file = at->path().string();
    std::error_code ignored;
    if (at->path().filename().string().starts_with('.')) continue;
    if (at->is_directory(ignored)) {
      // A link could lead round in a circle.
      if (!at->is_symlink(ignored)) folder.folders.push_back(file);
    } else if (is_kind(file, FileKind::Mesh)) {
      folder.meshes.push_back(file);
    } else if (is_kind(file, FileKind::PointCache)) {
      folder.caches.push_back(file);
    } else if (is_kind(file, FileKind::Animation)) {
      folder.animations.push_back(file);
    } else if (extension_of(file) == ".bin") {
      folder.buffers.push_back(file);
    }
  }
  for (auto* files : {&folder.folders, &folder.meshes, &folder.caches, &folder.animations, &folder.buffers})
    std::sort(files->begin(), files->end(), io::natural_less);
  return status;
}

/// Size and time go into the results, so that a later sweep knows whether a file is still the same.
void look_at(SweepMotion& motion, std::span<const std::string> files) {
  for (const std::string& file : files) {
    struct ::stat status = {};
    if (::stat(file.c_str(), &status) != 0) continue;  // opening it will say why
    motion.bytes += static_cast<std::uint64_t>(status.st_size);
    motion.modified = std::max(motion.modified,
                               std::int64_t{status.st_mtim.tv_sec} * 1'000'000'000 + status.st_mtim.tv_nsec);
  }
}

/// The name of a frame around its number, which is the last run of digits before the extension; nothing when
/// there is no number.
std::optional<std::string> series_of(const std::string& mesh) {
  const fs::path path(mesh);
  const std::string stem = path.stem().string();
  constexpr const char* kDigits = "0123456789";
  const std::size_t last = stem.find_last_of(kDigits);
  if (last == stem.npos) return std::nullopt;
  const std::size_t before = stem.find_last_not_of(kDigits, last);
  const std::size_t first = before == stem.npos ? 0 : before + 1;
  const std::string name = stem.substr(0, first) + '*' + stem.substr(last + 1) + path.extension().string();
  return (path.parent_path() / name).string();
}

class Finder {
 public:
  explicit Finder(bool poses) : poses_(poses) {}

  void look_below(const std::string& path) {
    Folder folder;
    if (list(path, folder)) add(path, {path});  // opening it will say what is wrong
    for (const std::string& animation : folder.animations) {
      add(animation, {animation}, extension_of(animation) == ".gltf" ? folder.buffers : kNone);
    }
    find_series(path, pair_caches(folder));
    for (const std::string& below : folder.folders) look_below(below);
  }

  SweepInput input;

 private:
  /// `beside`: files that may be part of it.
  void add(std::string path, std::vector<std::string> files, std::span<const std::string> beside = kNone) {
    std::error_code status;
    const fs::path whole = fs::canonical(files.back(), status);
    if (!known_.insert(status ? files.back() : whole.string()).second) return;
    SweepMotion motion{std::move(path), std::move(files)};
    look_at(motion, motion.files);
    look_at(motion, beside);
    input.motions.push_back(std::move(motion));
  }

  /// Each cache moves the mesh of its stem, or the only one there is. Gives the meshes that none moves.
  std::vector<std::string> pair_caches(const Folder& folder) {
    std::map<fs::path, std::string> by_stem;  // the first mesh of each
    for (const std::string& mesh : folder.meshes) by_stem.emplace(fs::path(mesh).stem(), mesh);
    std::set<std::string> moved;
    for (const std::string& cache : folder.caches) {
      const auto mesh = by_stem.find(fs::path(cache).stem());
      if (mesh != by_stem.end()) {
        moved.insert(mesh->second);
        add(cache, {mesh->second, cache});
      } else if (folder.meshes.size() == 1) {
        moved.insert(folder.meshes[0]);
        add(cache, {folder.meshes[0], cache});
      } else {
        add(cache, {cache});  // opening it will say that there is no mesh
      }
    }
    std::vector<std::string> left = folder.meshes;
    std::erase_if(left, [&](const std::string& mesh) { return moved.contains(mesh); });
    return left;
  }

  void find_series(const std::string& path, const std::vector<std::string>& meshes) {
    std::map<std::string, std::vector<std::string>> series;
    for (const std::string& mesh : meshes) series[series_of(mesh).value_or(mesh)].push_back(mesh);
    for (const auto& [name, frames] : series) {
      if (frames.size() > 1) {
        add(frames.size() == meshes.size() ? path : name, frames);
      } else if (poses_) {
        add(frames[0], frames);
      } else {
        ++input.single_meshes;
      }
    }
  }

  static inline const std::vector<std::string> kNone;
  bool poses_;
  std::set<std::string> known_;  // whole paths, for directories that overlap
};

}  // namespace

Result<SweepInput> find_motions(std::span<const std::string> directories, bool poses) {
  Finder finder(poses);
  for (std::string directory : directories) {
    while (directory.size() > 1 && directory.back() == '/') directory.pop_back();
    std::error_code status;
    if (!fs::exists(directory, status)) return fail(directory, "is not there", "check its name");
    if (!fs::is_directory(directory, status)) {
      return fail(directory, "is no directory",
                  "name the directory that it lies in, or check it alone with 'foldproof check'");
    }
    fs::directory_iterator opened(directory, status);
    if (status) return fail(directory, "cannot be listed: " + status.message(), "check the permissions");
    finder.input.directories.push_back(directory);
    finder.look_below(directory);
  }
  auto& motions = finder.input.motions;
  std::stable_sort(motions.begin(), motions.end(),
                   [](const auto& a, const auto& b) { return io::natural_less(a.path, b.path); });
  return std::move(finder.input);
}

}  // namespace foldproof
