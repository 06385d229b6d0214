/// Sweeps: a whole library of motions is checked, with one line of JSON for each (docs/sweep.md).
#pragma once

#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "report/report.h"

namespace foldproof {

/// A motion that lies below a directory.
struct SweepMotion {
  std::string path;  ///< Its name in results: a file, or the directory of its frames, as far as it was typed.
  std::vector<std::string> files;  ///< One file; a mesh and its point cache; or frames in order.
  std::uint64_t bytes = 0;         ///< Of all its files.
  std::int64_t modified = 0;       ///< When the newest of them was, nanoseconds since 1970.
};

struct SweepInput {
  std::vector<std::string> directories;  ///< As given, without '/' at their ends.
  std::vector<SweepMotion> motions;      ///< By path, ascending; none twice.
  std::uint64_t single_meshes = 0;       ///< Mesh files that are left over, as nothing moves them.
};

/// Finds the motions below directories, in the way that docs/sweep.md says. Hidden files and directories, and
/// links to directories, are passed over. `poses`: single meshes count as motions. What cannot be opened is
/// found as well. Error: one of `directories` is none.
Result<SweepInput> find_motions(std::span<const std::string> directories, bool poses = false);

/// How each motion is checked.
struct SweepSettings {
  CheckSettings check;  ///< Without models.
  ReadOptions read;
  std::vector<std::shared_ptr<const Model>> models;  ///< The first of a motion's mesh is used.
};

/// Tells settings apart that may give other answers: 16 hexadecimal digits. Models, certificates and the
/// number of threads do not count; the library's version does.
std::string settings_hash(const SweepSettings& settings);

enum class SweepState : std::uint8_t {
  Clean,  ///< With CheckSettings::steps_only: no contact begins in a step.
  Collides,
  Failed,  ///< Could not be read to its end.
  Still,   ///< A single pose, and CheckSettings::steps_only: nothing was asked.
};

/// "clean", "collides", "failed", "still".
const char* name_of(SweepState state);

/// What a line of results says.
struct SweepRecord {
  std::string path, settings, error, model;  ///< Error and model: empty without.
  SweepState state = SweepState::Failed;
  std::uint64_t bytes = 0;
  std::int64_t modified = 0;
  double seconds = 0;
  std::uint64_t vertices = 0, triangles = 0, frames = 0;
  std::uint64_t steps = 0, steps_with_collisions = 0, collisions = 0;
  std::optional<std::uint64_t> starts_crossing;           ///< CheckTotals::starts_crossing.
  std::optional<std::uint64_t> first_frame, worst_frame;  ///< Where the first and the worst step begin.
};

/// Error: not a line of ours.
Result<SweepRecord> read_sweep_line(const std::string& line);

/// Checks a motion: its line of JSON, without the line's end; none when `hooks.cancel` ended the check. A
/// motion that cannot be read or does not fit into memory is a line, too.
std::optional<std::string> sweep_line(const SweepMotion& motion, const SweepSettings& settings,
                                      const CheckHooks& hooks = {});

/// The line of a motion that cannot be checked for a reason outside of it.
std::string failed_sweep_line(const SweepMotion& motion, const SweepSettings& settings, const Error& error);

/// The file of results: one line per motion, written as they come. Whenever the program ends, what stands
/// there are whole lines, and maybe the begin of one, which the next `open` takes away.
class SweepFile {
 public:
  /// Keeps the lines of `input`'s motions that stand for the same bytes, time and settings, and takes away
  /// the others of these motions, and those below the input's directories that are not there any more. Lines
  /// of motions elsewhere stay. `again`: keeps none of the input's. Error: the file cannot be written,
  /// has other things in it, or another sweep is writing to it.
  static Result<SweepFile> open(const std::string& path, const SweepInput& input,
                                const std::string& settings_hash, bool again);
  SweepFile(SweepFile&&) noexcept;
  SweepFile& operator=(SweepFile&&) noexcept;
  ~SweepFile();

  /// Numbers of the input's motions that have no line yet.
  const std::vector<std::size_t>& left() const;
  /// Of the input's motions: those kept first, then those added.
  const std::vector<SweepRecord>& records() const;
  /// The line has been given to the system whole when this returns. Error: it cannot be written, and then no
  /// part of it stands there.
  Result<void> add(const std::string& line);

 private:
  struct State;
  explicit SweepFile(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/// Hands work out to several workers, the largest first.
class SweepQueue {
 public:
  /// `todo`: numbers of `motions`.
  SweepQueue(std::span<const SweepMotion> motions, std::vector<std::size_t> todo);

  /// What a worker is to do next; none when nothing is left to hand out.
  std::optional<std::size_t> take(int worker);
  /// A worker's answer has come. False when another gave it before.
  bool finish(int worker, std::size_t motion);
  /// A worker is gone. Its motion goes to another, unless it is the second worker that was lost over it: then
  /// this gives the motion, which counts as finished.
  std::optional<std::size_t> lose(int worker);
  bool finished() const { return open_.empty(); }

 private:
  std::deque<std::size_t> waiting_;
  std::map<std::size_t, int> open_;  ///< Unfinished ones, and how many workers were lost over each.
  std::map<int, std::size_t> taken_;
};

/// What the summary page says besides the records.
struct SweepPageInfo {
  std::string command;  ///< What was typed.
  std::vector<std::string> directories;
  bool poses = false;
  bool steps_only = false;
};

/// One HTML file that opens anywhere: a table of all records, those that collide or failed first, sorted by a
/// click on a column. Names are text in it, whatever they hold. Error: it cannot be written.
Result<void> write_sweep_page(const std::string& path, std::span<const SweepRecord> records,
                              const SweepPageInfo& info);

}  // namespace foldproof
