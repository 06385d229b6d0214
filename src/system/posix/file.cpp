#include "system/file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>

namespace foldproof::system {
namespace {

namespace fs = std::filesystem;

std::error_code last_error() { return {errno, std::generic_category()}; }

/// Its fields have two names.
std::int64_t modified(const auto& status) {
  const auto time = [&] {
    if constexpr (requires { status.st_mtimespec; }) {
      return status.st_mtimespec;
    } else {
      return status.st_mtim;
    }
  }();
  return std::int64_t{time.tv_sec} * 1'000'000'000 + time.tv_nsec;
}

FileStatus file_status(const struct ::stat& status) {
  FileStatus result;
  if (S_ISREG(status.st_mode)) result.kind = FileKind::File;
  if (S_ISDIR(status.st_mode)) result.kind = FileKind::Directory;
  result.size = static_cast<std::uint64_t>(status.st_size);
  result.modified = modified(status);
  result.id = {static_cast<std::uint64_t>(status.st_dev), static_cast<std::uint64_t>(status.st_ino)};
  return result;
}

int descriptor_of(std::intptr_t handle) { return static_cast<int>(handle); }

}  // namespace

std::optional<FileStatus> status_of(const fs::path& path) {
  struct ::stat status = {};
  if (::stat(path.c_str(), &status) != 0) return std::nullopt;
  return file_status(status);
}

File File::open(const fs::path& path, Mode mode, std::error_code& code) {
  // Without O_NONBLOCK, opening a named pipe would block until another process opens it.
  int flags = O_RDONLY | O_NONBLOCK;
  if (mode == Mode::Create) flags = O_WRONLY | O_CREAT | O_EXCL;
  if (mode == Mode::Write) flags = O_WRONLY;
  if (mode == Mode::Append) flags = O_RDWR | O_APPEND | O_CREAT | O_NONBLOCK;
  File file;
  file.handle_ = ::open(path.c_str(), flags | O_CLOEXEC, 0666);
  code = file ? std::error_code() : last_error();
  return file;
}

File File::duplicate(int descriptor, std::error_code& code) {
  File file;
  file.handle_ = ::fcntl(descriptor, F_DUPFD_CLOEXEC, 0);
  code = file ? std::error_code() : last_error();
  return file;
}

File File::temporary(std::error_code& code) {
  std::error_code ignored;
  std::string name = (fs::temp_directory_path(ignored) / "foldproof-XXXXXX").string();
  File file;
  file.handle_ = ::mkostemp(name.data(), O_CLOEXEC);
  code = file ? std::error_code() : last_error();
  if (file) ::unlink(name.c_str());
  return file;
}

std::size_t File::read_at(std::uint64_t offset, std::span<char> out, std::error_code& code) const {
  code.clear();
  std::size_t done = 0;
  while (done < out.size()) {
    const ssize_t count = ::pread(descriptor_of(handle_), out.data() + done, out.size() - done,
                                  static_cast<off_t>(offset + done));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) code = last_error();
    if (count <= 0) break;
    done += static_cast<std::size_t>(count);
  }
  return done;
}

std::error_code File::write(std::span<const char> bytes) {
  while (!bytes.empty()) {
    const ssize_t count = ::write(descriptor_of(handle_), bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return last_error();
    bytes = bytes.subspan(static_cast<std::size_t>(count));
  }
  return {};
}

std::error_code File::write_at(std::uint64_t offset, std::span<const char> bytes) {
  while (!bytes.empty()) {
    const ssize_t count =
        ::pwrite(descriptor_of(handle_), bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return last_error();
    bytes = bytes.subspan(static_cast<std::size_t>(count));
    offset += static_cast<std::uint64_t>(count);
  }
  return {};
}

std::error_code File::truncate(std::uint64_t size) {
  return ::ftruncate(descriptor_of(handle_), static_cast<off_t>(size)) == 0 ? std::error_code()
                                                                            : last_error();
}

std::optional<FileStatus> File::status() const {
  struct ::stat status = {};
  if (::fstat(descriptor_of(handle_), &status) != 0) return std::nullopt;
  return file_status(status);
}

bool File::lock() {
  // Other errors are ignored: some file systems have no locks.
  return ::flock(descriptor_of(handle_), LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK;
}

std::error_code File::close() {
  const std::intptr_t handle = std::exchange(handle_, kNone);
  if (handle == kNone || ::close(descriptor_of(handle)) == 0) return {};
  return last_error();
}

std::error_code rename(const fs::path& from, const fs::path& to) {
  return ::rename(from.c_str(), to.c_str()) == 0 ? std::error_code() : last_error();
}

bool can_replace_open_files() { return true; }

bool may_write(const fs::path& path) {
  std::error_code ignored;
  return ::access(path.c_str(), fs::is_directory(path, ignored) ? W_OK | X_OK : W_OK) == 0;
}

std::uint64_t process_number() { return static_cast<std::uint64_t>(::getpid()); }

int descriptor_named(const fs::path& path) {
  const std::string name = path.filename().string();
  if (name.empty() || name.size() > 6 || name.find_first_not_of("0123456789") != name.npos) return -1;
  std::error_code code;
  const fs::path directory = fs::canonical(path.has_parent_path() ? path.parent_path() : ".", code);
  const bool is_open = directory == fmt::format("/proc/{}/fd", ::getpid()) || directory == "/dev/fd";
  return is_open ? std::stoi(name) : -1;
}

bool is_open_on(int descriptor, const fs::path& path) {
  struct ::stat file = {}, open = {};
  return ::stat(path.c_str(), &file) == 0 && ::fstat(descriptor, &open) == 0 && S_ISREG(file.st_mode) &&
         file.st_dev == open.st_dev && file.st_ino == open.st_ino;
}

std::string problem_of_name(const fs::path&) { return ""; }

std::string_view separators() { return "/"; }

}  // namespace foldproof::system
