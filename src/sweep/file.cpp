// The file of results, which must be valid whenever the program ends.
#include <fmt/format.h>

#include <map>
#include <set>
#include <system_error>

#include "base/try.h"
#include "sweep/shard.h"
#include "system/file.h"

namespace foldproof {
namespace {

tl::unexpected<Error> file_error(const std::string& path, const char* what, const std::error_code& code) {
  return fail(ErrorCode::FileAccess, path, what + (": " + code.message()),
              "check the directory, its permissions and the free space");
}

bool lies_below(const std::string& path, std::span<const std::string> directories) {
  for (const std::string& directory : directories) {
    const std::string prefix = directory.ends_with('/') ? directory : directory + '/';
    if (path == directory || path.starts_with(prefix)) return true;
  }
  return false;
}

/// Whether a truncated last line may be the start of a line of results. Other text must not be removed.
bool is_start_of_line(std::string_view text) {
  constexpr std::string_view kStart = "{\"path\":\"";
  return text.starts_with(kStart) || kStart.starts_with(text);
}

/// Removes the first line of a file of results from `text` where it is the header of a shard, and returns it.
std::optional<ShardHeader> take_header(std::string_view& text) {
  const std::size_t end = text.find('\n');
  auto header = read_shard_header(std::string(text.substr(0, end)));
  if (header) text.remove_prefix(end == text.npos ? text.size() : end + 1);
  return header;
}

/// Error: a file that begins with `found` does not hold the shard `wanted`. Null: no shard.
Result<void> require_same_shard(const std::string& path, const ShardHeader* found,
                                const ShardHeader* wanted) {
  const auto refused = [&](const std::string& problem, const std::string& remedy) {
    return fail(ErrorCode::InvalidArgument, path, problem, remedy);
  };
  const char* another = "name another file, a new one for each shard";
  if (!found && !wanted) return {};
  if (!found) return refused("does not hold a shard of a sweep", another);
  const std::string shard = name_of(found->shard);
  if (!wanted)
    return refused(
        fmt::format("holds shard {} of a sweep", shard),
        fmt::format("continue it with --shard {}, join all shards with --join, or name another file", shard));
  if (shard != name_of(wanted->shard)) return refused(fmt::format("holds shard {}", shard), another);
  if (found->scope.directories != wanted->scope.directories)
    return refused(fmt::format("holds a shard of '{}'", fmt::join(found->scope.directories, "', '")),
                   "name the same directories, or another file");
  return {};
}

/// Decides which lines of an existing file to keep.
class LineFilter {
 public:
  LineFilter(const SweepInput& input, const std::string& hash, bool again)
      : input_(input), hash_(hash), again_(again) {
    for (std::size_t i = 0; i < input.motions.size(); ++i) {
      const std::string& path = input.motions[i].path;
      // Names that are not valid UTF-8 are ambiguous in the file.
      if (as_written(path) == path) by_path_[path] = i;
    }
  }

  /// `number`: of the first line of `text`.
  Result<void> read(const std::string& path, std::string_view text, std::size_t number) {
    for (; !text.empty(); ++number) {
      const std::size_t end = text.find('\n');
      const std::string line(text.substr(0, end));
      const bool truncated = end == text.npos;
      text.remove_prefix(truncated ? text.size() : end + 1);
      changed |= truncated;
      auto record = read_sweep_line(line);
      if (!record && truncated && is_start_of_line(line)) return {};
      if (!record)
        return fail(ErrorCode::InvalidFile, fmt::format("{}:{}", path, number), "is no result of a sweep",
                    "name another file");
      if (keep(*record)) {
        kept += line + '\n';
      } else {
        changed = true;
      }
    }
    return {};
  }

  std::string kept;
  bool changed = false;
  std::vector<SweepRecord> records;
  std::set<std::size_t> done;

 private:
  bool keep(SweepRecord& record) {
    const auto found = by_path_.find(record.path);
    if (found == by_path_.end()) return !lies_below(record.path, written_directories_);
    const SweepMotion& motion = input_.motions[found->second];
    // What failed may have failed for want of memory, space or permissions, which come back. What was unclear
    // may be clear now (--sequence).
    const bool same = record.status == motion.status && record.settings == hash_ && !again_ &&
                      record.state != SweepState::Failed && record.state != SweepState::Unclear;
    if (!same || !done.insert(found->second).second) return false;
    records.push_back(std::move(record));
    return true;
  }

  static std::vector<std::string> written(std::span<const std::string> paths) {
    std::vector<std::string> all;
    for (const std::string& path : paths) all.push_back(as_written(path));
    return all;
  }

  const SweepInput& input_;
  const std::string& hash_;
  bool again_;
  std::map<std::string, std::size_t> by_path_;
  std::vector<std::string> written_directories_ = written(input_.directories);
};

Result<std::string> read_all(const std::string& path, const system::File& file) {
  std::string text;
  std::array<char, 1 << 16> block;
  for (;;) {
    std::error_code code;
    const std::size_t count = file.read_at(text.size(), block, code);
    if (code) return file_error(path, "cannot be read", code);
    text.append(block.data(), count);
    if (count < block.size()) return text;
  }
}

}  // namespace

struct SweepFile::State {
  std::string path;
  system::File file;
  std::vector<std::size_t> remaining;
  std::vector<SweepRecord> records;

  /// Opens the file, creates it if necessary, and locks it. Another sweep may replace it before the lock.
  Result<void> open_and_lock() {
    // Bounded: on some file systems the numbers of a file change.
    for (int attempt = 0; attempt < 100; ++attempt) {
      FOLDPROOF_TRY(try_to_lock());
      if (has_its_name()) break;
    }
    return {};
  }

 private:
  bool has_its_name() const {
    const auto open = file.status(), named = system::status_of(path);
    return open && named && open->id == named->id;
  }

  Result<void> try_to_lock() {
    std::error_code code = file.close();
    file = system::File::open(path, system::File::Mode::Append, code);
    if (code) return file_error(path, "cannot be written", code);
    const auto status = file.status();
    if (!status || status->kind != system::FileKind::File) {
      return fail(ErrorCode::FileAccess, path, "is not a regular file",
                  "name a file, which may be a new one");
    }
    if (!file.lock()) {
      return fail(ErrorCode::FileAccess, path, "is being written by another sweep",
                  "wait for that, or name another file");
    }
    return {};
  }
};

SweepFile::SweepFile(std::unique_ptr<State> state) : state_(std::move(state)) {}
SweepFile::SweepFile(SweepFile&&) noexcept = default;
SweepFile& SweepFile::operator=(SweepFile&&) noexcept = default;
SweepFile::~SweepFile() = default;

const std::vector<std::size_t>& SweepFile::remaining() const { return state_->remaining; }
const std::vector<SweepRecord>& SweepFile::records() const { return state_->records; }

Result<SweepFile> SweepFile::open(const std::string& path, const SweepInput& input,
                                  const std::string& settings_hash, bool again, const ShardHeader* header) {
  auto state = std::make_unique<State>();
  state->path = path;
  FOLDPROOF_TRY(state->open_and_lock());
  const auto all = FOLDPROOF_TRY(read_all(path, state->file));
  std::string_view text = all;
  LineFilter lines(input, settings_hash, again);
  const auto found = take_header(text);
  if (!all.empty()) FOLDPROOF_TRY(require_same_shard(path, found ? &*found : nullptr, header));
  if (header) {
    lines.kept = line_of(*header) + '\n';
    lines.changed = !all.starts_with(lines.kept);
  }
  FOLDPROOF_TRY(lines.read(path, text, found ? 2 : 1));
  if (lines.changed) {
    auto file = FOLDPROOF_TRY(FileWriter::open(path));
    FOLDPROOF_TRY(file.write(lines.kept));
    if (!system::can_replace_open_files()) state->file = {};
    FOLDPROOF_TRY(file.commit());
    FOLDPROOF_TRY(state->open_and_lock());
  }
  state->records = std::move(lines.records);
  for (std::size_t i = 0; i < input.motions.size(); ++i) {
    if (!lines.done.contains(i)) state->remaining.push_back(i);
  }
  return SweepFile(std::move(state));
}

Result<void> SweepFile::add(const std::string& line) {
  auto record = FOLDPROOF_TRY(read_sweep_line(line));
  const auto before = state_->file.status();
  if (const std::error_code code = state_->file.write(line + '\n')) {
    // If this fails too, the next sweep removes the incomplete line.
    [[maybe_unused]] const std::error_code ignored =
        before ? state_->file.truncate(before->size) : std::error_code();
    return file_error(state_->path, "cannot be written", code);
  }
  state_->records.push_back(std::move(record));
  return {};
}

}  // namespace foldproof
