// Groups the files below a directory into motions.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <map>
#include <set>

#include "io/array_names.h"
#include "io/formats.h"
#include "io/numbered.h"
#include "sweep/sweep.h"
#include "system/file.h"

namespace foldproof {
namespace {

namespace fs = std::filesystem;
using io::FileKind, io::is_kind;

/// The entries of a directory by kind, each in natural order.
struct Entries {
  std::vector<std::string> folders, meshes, caches, animations, arrays;
};

std::error_code list(const std::string& path, Entries& entries) {
  std::error_code status;
  for (fs::directory_iterator at(path, status), end; !status && at != end; at.increment(status)) {
    const std::string file = at->path().generic_string();
    std::error_code ignored;
    if (at->path().filename().generic_string().starts_with('.')) continue;
    if (at->is_directory(ignored)) {
      // A link could form a cycle.
      if (!at->is_symlink(ignored)) entries.folders.push_back(file);
    } else if (is_kind(file, FileKind::Mesh)) {
      entries.meshes.push_back(file);
    } else if (is_kind(file, FileKind::PointCache)) {
      entries.caches.push_back(file);
    } else if (is_kind(file, FileKind::Animation)) {
      entries.animations.push_back(file);
    } else if (is_kind(file, FileKind::Array)) {
      entries.arrays.push_back(file);
    }
  }
  for (auto* files :
       {&entries.folders, &entries.meshes, &entries.caches, &entries.animations, &entries.arrays})
    std::sort(files->begin(), files->end(), io::natural_less);
  return status;
}

/// Adds the size and modification time of files, by which a later sweep recognizes changes.
void add_status(SweepMotion& motion, Hash& hash, std::span<const std::string> files) {
  for (const std::string& file : files) {
    const auto status = system::status_of(file);
    if (!status) continue;  // opening the file will report why
    motion.bytes += status->size;
    motion.modified = std::max(motion.modified, status->modified);
    hash.add(fmt::format("{}\n{}\n{}\n", fs::path(file).filename().generic_string(), status->size,
                         status->modified));
  }
}

/// The path without links; as it is where there is no such file.
std::string canonical(const std::string& path) {
  std::error_code status;
  const fs::path found = fs::canonical(path, status);
  return status ? path : found.generic_string();
}

/// The path with its directory's links followed, but not one of the file itself.
std::string place(const fs::path& path) {
  return (canonical(path.parent_path().generic_string()) / path.filename()).generic_string();
}

class Finder {
 public:
  Finder(bool poses, bool separate) : poses_(poses), separate_(separate) {}

  void search(const std::string& path) {
    if (!searched_.insert(canonical(path)).second) return;
    Entries entries;
    if (list(path, entries)) add(path, {path});  // opening the directory will report the error
    for (const std::string& animation : entries.animations) {
      const auto frames =
          extension_of(animation) == ".pvd" ? io::pvd_files(animation).value_or(kNone) : kNone;
      for (const std::string& frame : frames) in_collections_.insert(place(frame));
      add(animation, {animation}, extension_of(animation) == ".gltf" ? io::gltf_files(animation) : frames);
    }
    std::erase_if(entries.meshes,
                  [&](const std::string& mesh) { return in_collections_.contains(place(mesh)); });
    pair_arrays(entries.arrays);
    find_series(path, pair_caches(entries));
    for (const std::string& child : entries.folders) search(child);
  }

  SweepInput input;

 private:
  /// `beside`: files that may belong to it.
  void add(std::string path, std::vector<std::string> files, std::span<const std::string> beside = kNone) {
    SweepMotion motion{std::move(path), std::move(files)};
    Hash hash;
    std::vector<std::string> key;
    for (const auto part : {std::span<const std::string>(motion.files), beside}) {
      add_status(motion, hash, part);
      std::ranges::transform(part, std::back_inserter(key), canonical);
    }
    if (!known_.insert(std::move(key)).second) return;
    motion.status = hash.text();
    input.motions.push_back(std::move(motion));
  }

  /// Pairs each cache with the mesh of the same stem, or with the only mesh. Returns the unpaired meshes.
  std::vector<std::string> pair_caches(const Entries& entries) {
    std::map<fs::path, std::string> by_stem;  // the first mesh of each stem
    for (const std::string& mesh : entries.meshes) by_stem.emplace(fs::path(mesh).stem(), mesh);
    std::set<std::string> paired;
    for (const std::string& cache : entries.caches) {
      const auto mesh = by_stem.find(fs::path(cache).stem());
      if (mesh != by_stem.end()) {
        paired.insert(mesh->second);
        add(cache, {mesh->second, cache});
      } else if (entries.meshes.size() == 1) {
        paired.insert(entries.meshes[0]);
        add(cache, {entries.meshes[0], cache});
      } else {
        add(cache, {cache});  // opening it will report the missing mesh
      }
    }
    std::vector<std::string> unpaired = entries.meshes;
    std::erase_if(unpaired, [&](const std::string& mesh) { return paired.contains(mesh); });
    return unpaired;
  }

  /// Pairs arrays of faces and of vertices whose names differ in that word only, at their end.
  void pair_arrays(const std::vector<std::string>& arrays) {
    struct Pair {
      std::vector<std::string> faces, vertices;
    };
    std::map<std::string, Pair> pairs;  // by what precedes the word
    for (const std::string& array : arrays) {
      std::string word = fs::path(array).stem().generic_string();
      const std::size_t begin = word.find_last_of("_-. ") + 1;
      Pair& pair = pairs[word.substr(0, begin)];
      word.erase(0, begin);
      std::ranges::transform(word, word.begin(), [](unsigned char c) { return std::tolower(c); });
      const auto is_one_of = [&](const auto& names) { return std::ranges::find(names, word) != names.end(); };
      if (is_one_of(io::kFaceNames)) {
        pair.faces.push_back(array);
      } else if (is_one_of(io::kVertexNames)) {
        pair.vertices.push_back(array);
      } else {
        ++input.single_arrays;
      }
    }
    for (const auto& [start, pair] : pairs) {
      const auto& [faces, vertices] = pair;
      if (faces.size() == 1 && vertices.size() == 1) {
        add(vertices[0], {faces[0], vertices[0]});
      } else {
        input.single_arrays += faces.size() + vertices.size();
      }
    }
  }

  void find_series(const std::string& path, const std::vector<std::string>& meshes) {
    std::vector<io::NumberedFiles> series;
    if (separate_) {
      for (const std::string& mesh : meshes) series.push_back({{mesh}, {}});
    } else {
      series = io::split_by_number(meshes);
    }
    for (const auto& [frames, around] : series) {
      if (frames.size() > 1) {
        const auto& [before, after] = around;
        const char* number = frames[0][before.size()] == '-' ? "-*" : "*";
        add(frames.size() == meshes.size() ? path : fmt::format("{}{}{}", before, number, after), frames);
      } else if (poses_) {
        add(frames[0], frames);
      } else {
        ++input.single_meshes;
      }
    }
  }

  static inline const std::vector<std::string> kNone;
  bool poses_, separate_;
  // Canonical paths, since directories may overlap. A motion is known by all its files: it may share some.
  std::set<std::string> searched_;
  std::set<std::vector<std::string>> known_;
  std::set<std::string> in_collections_;  // places of meshes that are frames of a collection
};

}  // namespace

Result<SweepInput> find_motions(std::span<const std::string> directories, bool poses, bool separate) {
  Finder finder(poses, separate);
  for (std::string directory : directories) {
    directory = fs::path(directory).generic_string();
    while (directory.size() > 1 && directory.back() == '/') directory.pop_back();
    std::error_code status;
    if (!fs::exists(directory, status))
      return fail(ErrorCode::FileAccess, directory, "does not exist", "check the name");
    if (!fs::is_directory(directory, status)) {
      return fail(ErrorCode::FileAccess, directory, "is no directory",
                  "name the directory that it lies in, or check it alone with 'foldproof check'");
    }
    fs::directory_iterator opened(directory, status);
    if (status)
      return fail(ErrorCode::FileAccess, directory, "cannot be listed: " + status.message(),
                  "check the permissions");
    finder.input.directories.push_back(directory);
    finder.search(directory);
  }
  auto& motions = finder.input.motions;
  std::stable_sort(motions.begin(), motions.end(),
                   [](const auto& a, const auto& b) { return io::natural_less(a.path, b.path); });
  return std::move(finder.input);
}

}  // namespace foldproof
