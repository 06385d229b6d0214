// Files appear whole or not at all: data goes to a temporary file beside the target, which commit renames.
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <filesystem>
#include <system_error>

#include "base/try.h"
#include "foldproof/io.h"
#include "io/named_files.h"
#include "io/write_error.h"

namespace foldproof {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kBufferBytes = std::size_t{1} << 18;

tl::unexpected<Error> write_error(const std::string& path, int code) {
  return io::write_error(path, {code, std::generic_category()});
}

int write_fully(int descriptor, bool may_close, std::span<const char> bytes) {
  while (!bytes.empty()) {
    const ssize_t count = ::write(descriptor, bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0 && errno == EPIPE && may_close) return 0;
    if (count < 0) return errno;
    bytes = bytes.subspan(static_cast<std::size_t>(count));
  }
  return 0;
}

/// A name in the target's directory that no other writer of this or another process uses.
std::string temporary_name(const fs::path& target) {
  static std::atomic<unsigned> counter{0};
  return (target.parent_path() / fmt::format(".{}.{}-{}.part", target.filename().string().substr(0, 200),
                                             ::getpid(), counter.fetch_add(1)))
      .string();
}

}  // namespace

struct FileWriter::State {
  std::string path;        // as the caller gave it
  std::string target;      // with symbolic links resolved, so that a link stays a link
  std::string temporary;   // empty for pipes, terminals and what is open already, which are written directly
  bool may_close = false;  // standard output: whoever reads it may have seen enough
  int descriptor = -1;
  int failure = 0;
  std::vector<char> buffer;

  ~State() {
    if (descriptor >= 0) ::close(descriptor);
    if (!temporary.empty()) ::unlink(temporary.c_str());
  }

  Result<void> flush() {
    if (failure == 0) failure = write_fully(descriptor, may_close, buffer);
    buffer.clear();
    if (failure != 0) return write_error(path, failure);
    return {};
  }
};

FileWriter::FileWriter(FileWriter&&) noexcept = default;
FileWriter& FileWriter::operator=(FileWriter&&) noexcept = default;
FileWriter::~FileWriter() = default;

Result<FileWriter> FileWriter::open(const std::string& path) {
  FileWriter writer;
  writer.state_ = std::make_unique<State>();
  State& state = *writer.state_;
  if (path == "-") {
    state.path = "standard output";
    state.may_close = true;
    state.descriptor = ::fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, 0);
    if (state.descriptor < 0) return write_error(state.path, errno);
    return writer;
  }
  state.path = path;
  const io::WriteTarget target = io::write_target(path);
  if (target.descriptor >= 0) {
    state.may_close = target.descriptor == STDOUT_FILENO;
    state.descriptor = ::fcntl(target.descriptor, F_DUPFD_CLOEXEC, 0);
    if (state.descriptor < 0) return write_error(path, errno);
    return writer;
  }
  std::error_code status;
  state.target = target.file.string();
  if (fs::is_directory(state.target, status)) return write_error(path, EISDIR);
  const bool special = fs::exists(state.target, status) && !fs::is_regular_file(state.target, status);
  const std::string name = special ? path : temporary_name(state.target);
  const int flags = O_WRONLY | O_CLOEXEC | (special ? 0 : O_CREAT | O_EXCL);
  state.descriptor = ::open(name.c_str(), flags, 0666);
  if (state.descriptor < 0) return write_error(path, errno);
  if (!special) state.temporary = name;
  state.buffer.reserve(kBufferBytes);
  return writer;
}

Result<void> FileWriter::write(std::span<const char> bytes) {
  State& state = *state_;
  if (state.buffer.size() + bytes.size() > kBufferBytes) {
    FOLDPROOF_TRY(state.flush());
  }
  if (bytes.size() < kBufferBytes) {
    state.buffer.insert(state.buffer.end(), bytes.begin(), bytes.end());
    return {};
  }
  state.failure = write_fully(state.descriptor, state.may_close, bytes);
  if (state.failure != 0) return write_error(state.path, state.failure);
  return {};
}

Result<void> FileWriter::rewrite(std::uint64_t offset, std::span<const char> bytes) {
  State& state = *state_;
  FOLDPROOF_TRY(state.flush());
  if (state.temporary.empty()) return write_error(state.path, state.failure = ESPIPE);
  while (!bytes.empty()) {
    const ssize_t count = ::pwrite(state.descriptor, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return write_error(state.path, state.failure = errno);
    bytes = bytes.subspan(static_cast<std::size_t>(count));
    offset += static_cast<std::uint64_t>(count);
  }
  return {};
}

Result<void> FileWriter::commit() {
  State& state = *state_;
  FOLDPROOF_TRY(state.flush());
  const int descriptor = std::exchange(state.descriptor, -1);
  if (::close(descriptor) != 0) return write_error(state.path, errno);
  if (state.temporary.empty()) return {};
  if (::rename(state.temporary.c_str(), state.target.c_str()) != 0) return write_error(state.path, errno);
  state.temporary.clear();
  return {};
}

}  // namespace foldproof
