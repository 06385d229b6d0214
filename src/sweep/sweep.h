/// Sweeps: check a whole library of motions, with one line of JSON for each (docs/sweep.md).
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "report/report.h"

namespace foldproof {

/// FNV-1a. Not for adversaries.
class Hash {
 public:
  void add(std::string_view bytes) {
    for (const char c : bytes) value_ = (value_ ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
  }
  std::uint64_t value() const { return value_; }
  /// 16 hexadecimal digits.
  std::string text() const;

 private:
  std::uint64_t value_ = 0xcbf29ce484222325u;
};

/// A motion found below a directory.
struct SweepMotion {
  std::string path;  ///< Its name in results: a file, or the directory of its frames; relative as given.
  /// One file; a mesh and its point cache; faces and vertices; or frames in order.
  std::vector<std::string> files;
  std::uint64_t bytes = 0;    ///< Size of all its files.
  std::int64_t modified = 0;  ///< Modification time of the newest file, nanoseconds since 1970.
  /// A Hash of the names, sizes and modification times of all its files. Another one: something has changed.
  std::string status = {};
};

struct SweepInput {
  std::vector<std::string> directories;  ///< As given, without '/' at their ends.
  std::vector<SweepMotion> motions;      ///< Sorted by path, without duplicates.
  std::uint64_t single_meshes = 0;       ///< Number of mesh files that belong to no motion.
  std::uint64_t single_arrays = 0;       ///< The same of .npy files.
};

/// Finds the motions below directories (docs/sweep.md). Skips hidden files and directories, and links to
/// directories. `poses`: single meshes count as motions. `separate`: numbered meshes are single ones. Motions
/// that cannot be opened are found as well. Error: one of `directories` is not a readable directory.
Result<SweepInput> find_motions(std::span<const std::string> directories, bool poses = false,
                                bool separate = false);

/// How each motion is checked.
struct SweepSettings {
  CheckSettings check;  ///< Without models.
  ReadOptions read;
  std::vector<std::shared_ptr<const Model>> models;  ///< The first one of a motion's mesh is used.
  /// Where motions that collide are written without collisions, under their paths; empty: nowhere.
  std::string repaired = {};
};

/// A hash of the settings that may change answers: 16 hexadecimal digits. It covers the library's version
/// and the revision of its answers, but not models, certificates or the number of threads.
std::string settings_hash(const SweepSettings& settings);

enum class SweepState : std::uint8_t {
  Clean,  ///< With CheckSettings::steps_only: no contact begins in a step.
  Collides,
  Failed,   ///< A frame could not be read.
  Unclear,  ///< Its files may be frames or bodies: ErrorCode::Ambiguous.
  Still,    ///< A single pose with CheckSettings::steps_only: nothing to check.
};

/// "clean", "collides", "failed", "unclear", "still".
const char* name_of(SweepState state);

/// The content of a line of results.
struct SweepRecord {
  std::string path, settings, status, error, model;  ///< Error and model: empty if there is none.
  std::string verdict;                               ///< In a sentence; empty in lines of older versions.
  std::string repair;                                ///< What its repair did, in a sentence; empty: nothing.
  SweepState state = SweepState::Failed;
  std::uint64_t bytes = 0;
  std::int64_t modified = 0;
  double seconds = 0;
  std::vector<std::string> notes;                   ///< Motion::notes().
  std::vector<std::array<std::string, 2>> ignored;  ///< Pairs of names that it has and that were ignored.
  std::uint64_t vertices = 0, triangles = 0, frames = 0;
  std::uint64_t steps = 0, steps_with_collisions = 0, collisions = 0;
  std::optional<std::uint64_t> starts_crossing;  ///< CheckTotals::starts_crossing.
  std::optional<std::uint64_t> contacts;         ///< None if they were not looked for.
  std::optional<double> depth;  ///< Of the deepest contact, mesh units; a lower bound between open surfaces.
  bool contacts_cut = false;    ///< They leave out pairs, which were too many.
  std::string thumbnail;        ///< A data URL; empty: there is none.
  std::optional<std::uint64_t> first_frame, worst_frame;  ///< Of the first and the worst colliding step.
};

/// "leave out pairs in 2 motions: ...", which follows "contacts"; empty where contacts join all pairs.
std::string contacts_cut(std::span<const SweepRecord> records);

/// Error: not a line of results.
Result<SweepRecord> read_sweep_line(const std::string& line);

/// Checks a motion and returns its line of JSON, without the line end; none if `hooks.cancel` ended the
/// check. A motion that cannot be read or does not fit into memory gives a line, too.
std::optional<std::string> sweep_line(const SweepMotion& motion, const SweepSettings& settings,
                                      const CheckHooks& hooks = {});

/// What a sweep looked at, and how: what its summaries say besides its records.
struct SweepScope {
  std::string command;  ///< The command line.
  std::vector<std::string> directories;
  bool poses = false;
  bool steps_only = false;
  std::string frames = {};  ///< The frames that were selected, as text; empty: all.
  std::vector<std::array<std::string, 2>> ignore = {};  ///< CheckSettings::ignore.
  std::uint64_t single_meshes = 0, single_arrays = 0;   ///< As in SweepInput.
};

struct ShardHeader;  // sweep/shard.h

/// The file of results: one line per motion, written as they come. Whenever the program ends, the file has
/// complete lines, and possibly the start of one more, which the next `open` removes.
class SweepFile {
 public:
  /// Opens or creates the file. Of `input`'s motions it keeps lines with the same bytes, time and settings
  /// and removes the others. It also removes lines of motions that no longer exist below the input's
  /// directories; lines of other motions stay. `again`: keeps no line of the input's motions. `header`: that
  /// of the file, which holds a shard; null: it holds none. Error: the file cannot be written, has other
  /// content, such as another shard, or another sweep is writing to it.
  static Result<SweepFile> open(const std::string& path, const SweepInput& input,
                                const std::string& settings_hash, bool again,
                                const ShardHeader* header = nullptr);
  SweepFile(SweepFile&&) noexcept;
  SweepFile& operator=(SweepFile&&) noexcept;
  ~SweepFile();

  /// Indices of the input's motions that have no line yet.
  const std::vector<std::size_t>& remaining() const;
  /// The records of the input's motions: first those kept, then those added.
  const std::vector<SweepRecord>& records() const;
  /// Writes a complete line. Error: it cannot be written; then no part of it is in the file.
  Result<void> add(const std::string& line);

 private:
  struct State;
  explicit SweepFile(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/// Writes a self-contained HTML file: a table of all records, those that collide or failed first, sortable by
/// column. Names are escaped. Error: it cannot be written.
Result<void> write_sweep_page(const std::string& path, std::span<const SweepRecord> records,
                              const SweepScope& scope);

}  // namespace foldproof
