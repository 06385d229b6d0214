// The file of results, which must be whole whenever the program ends.
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <set>
#include <system_error>

#include "report/json_values.h"
#include "sweep/sweep.h"

namespace foldproof {
namespace {

tl::unexpected<Error> file_error(const std::string& path, const char* what, int code) {
  return fail(path, what + (": " + std::generic_category().message(code)),
              "check the directory, its permissions and the free space");
}

/// What a path becomes in a line; the same unless it is no UTF-8.
std::string as_written(const std::string& path) { return Json::parse(dump(path)).get<std::string>(); }

bool lies_below(const std::string& path, std::span<const std::string> directories) {
  for (const std::string& directory : directories) {
    const std::string begin = directory.ends_with('/') ? directory : directory + '/';
    if (path == directory || path.starts_with(begin)) return true;
  }
  return false;
}

/// An end that was cut off; what is no begin of a line of ours shall not be taken away.
bool is_begin_of_line(std::string_view text) {
  constexpr std::string_view kBegin = "{\"path\":\"";
  return text.starts_with(kBegin) || kBegin.starts_with(text);
}

/// Goes through an old file's lines and says what stays.
class Sorter {
 public:
  Sorter(const SweepInput& input, const std::string& hash, bool again)
      : input_(input), hash_(hash), again_(again) {
    for (std::size_t i = 0; i < input.motions.size(); ++i) {
      const std::string& path = input.motions[i].path;
      // Names that are no UTF-8 could stand for one another in the file.
      if (as_written(path) == path) by_path_[path] = i;
    }
  }

  Result<void> sort(const std::string& path, std::string_view text) {
    for (std::size_t number = 1; !text.empty(); ++number) {
      const std::size_t end = text.find('\n');
      const std::string line(text.substr(0, end));
      const bool cut = end == text.npos;
      text.remove_prefix(cut ? text.size() : end + 1);
      changed |= cut;
      auto record = read_sweep_line(line);
      if (!record && cut && is_begin_of_line(line)) return {};
      if (!record)
        return fail(fmt::format("{}:{}", path, number), "is no result of a sweep", "name another file");
      if (stays(*record)) {
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
  bool stays(SweepRecord& record) {
    const auto found = by_path_.find(record.path);
    if (found == by_path_.end()) return !lies_below(record.path, written_directories_);
    const SweepMotion& motion = input_.motions[found->second];
    const bool same = record.bytes == motion.bytes && record.modified == motion.modified &&
                      record.settings == hash_ && !again_;
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

Result<std::string> read_all(const std::string& path, int descriptor) {
  std::string text;
  char piece[1 << 16];
  for (;;) {
    const ssize_t count = ::read(descriptor, piece, sizeof piece);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return file_error(path, "cannot be read", errno);
    if (count == 0) return text;
    text.append(piece, static_cast<std::size_t>(count));
  }
}

}  // namespace

struct SweepFile::State {
  std::string path;
  int descriptor = -1;
  std::vector<std::size_t> left;
  std::vector<SweepRecord> records;

  ~State() {
    if (descriptor >= 0) ::close(descriptor);
  }

  /// Opens the file, makes it if need be, and holds others off it.
  Result<void> take_hold() {
    if (descriptor >= 0) ::close(descriptor);
    descriptor = ::open(path.c_str(), O_RDWR | O_APPEND | O_CREAT | O_CLOEXEC | O_NONBLOCK, 0666);
    if (descriptor < 0) return file_error(path, "cannot be written", errno);
    struct ::stat status = {};
    if (::fstat(descriptor, &status) != 0 || !S_ISREG(status.st_mode)) {
      return fail(path, "is no file that a sweep can go on with", "name a file, which need not be there yet");
    }
    // Where a file system has no locks, there is nothing to hold others off with.
    if (::flock(descriptor, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
      return fail(path, "is being written by another sweep", "wait for that, or name another file");
    }
    return {};
  }
};

SweepFile::SweepFile(std::unique_ptr<State> state) : state_(std::move(state)) {}
SweepFile::SweepFile(SweepFile&&) noexcept = default;
SweepFile& SweepFile::operator=(SweepFile&&) noexcept = default;
SweepFile::~SweepFile() = default;

const std::vector<std::size_t>& SweepFile::left() const { return state_->left; }
const std::vector<SweepRecord>& SweepFile::records() const { return state_->records; }

Result<SweepFile> SweepFile::open(const std::string& path, const SweepInput& input,
                                  const std::string& settings_hash, bool again) {
  auto state = std::make_unique<State>();
  state->path = path;
  if (auto held = state->take_hold(); !held) return tl::unexpected(held.error());
  const auto text = read_all(path, state->descriptor);
  if (!text) return tl::unexpected(text.error());
  Sorter sorter(input, settings_hash, again);
  if (auto sorted = sorter.sort(path, *text); !sorted) return tl::unexpected(sorted.error());
  if (sorter.changed) {
    auto file = FileWriter::open(path);
    if (!file) return tl::unexpected(file.error());
    if (auto done = file->write(sorter.kept); !done) return tl::unexpected(done.error());
    if (auto done = file->commit(); !done) return tl::unexpected(done.error());
    if (auto held = state->take_hold(); !held) return tl::unexpected(held.error());
  }
  state->records = std::move(sorter.records);
  for (std::size_t i = 0; i < input.motions.size(); ++i) {
    if (!sorter.done.contains(i)) state->left.push_back(i);
  }
  return SweepFile(std::move(state));
}

Result<void> SweepFile::add(const std::string& line) {
  auto record = read_sweep_line(line);
  if (!record) return tl::unexpected(record.error());
  const ::off_t begin = ::lseek(state_->descriptor, 0, SEEK_END);
  const std::string text = line + '\n';
  for (std::size_t at = 0; at < text.size();) {
    const ssize_t count = ::write(state_->descriptor, text.data() + at, text.size() - at);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) {
      const int code = errno;
      // Should this fail, too, the next sweep mends it.
      [[maybe_unused]] const int cut = ::ftruncate(state_->descriptor, begin);
      return file_error(state_->path, "cannot be written", code);
    }
    at += static_cast<std::size_t>(count);
  }
  state_->records.push_back(std::move(*record));
  return {};
}

}  // namespace foldproof
