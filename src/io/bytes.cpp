#include "io/bytes.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <utility>

#include "base/try.h"
#include "io/recognize.h"

namespace foldproof::io {
namespace {

std::string reason(int code) { return std::generic_category().message(code); }

}  // namespace

Result<InputFile> InputFile::open(const std::string& path) {
  InputFile file;
  file.path_ = path;
  // Without O_NONBLOCK, opening a named pipe would block until another process opens it.
  file.descriptor_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (file.descriptor_ < 0) {
    if (errno == ENOENT || errno == ENOTDIR) return does_not_exist(path);
    return fail(ErrorCode::FileAccess, path, "cannot be opened: " + reason(errno),
                "check the name and the permissions");
  }
  struct stat status {};
  if (::fstat(file.descriptor_, &status) != 0) {
    return fail(ErrorCode::FileAccess, path, "cannot be examined: " + reason(errno),
                "check the name and the permissions");
  }
  if (!S_ISREG(status.st_mode)) {
    return fail(ErrorCode::FileAccess, path, "is not a regular file",
                "save the data to a file and name that");
  }
  file.size_ = static_cast<std::uint64_t>(status.st_size);
  file.modified_ = status.st_mtim;
  std::array<char, kRecognizedBytes> buffer;
  const auto start = std::span(buffer).first(std::min<std::uint64_t>(file.size_, buffer.size()));
  FOLDPROOF_TRY(file.read_at(0, start));
  FOLDPROOF_TRY(check_is_data(path, {start.data(), start.size()}));
  return file;
}

tl::unexpected<Error> does_not_exist(const std::string& path) {
  return fail(ErrorCode::FileAccess, path, "does not exist", "check the name");
}

InputFile::InputFile(InputFile&& other) noexcept
    : path_(std::move(other.path_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      size_(other.size_),
      modified_(other.modified_) {}

InputFile& InputFile::operator=(InputFile&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(descriptor_, other.descriptor_);
  std::swap(size_, other.size_);
  std::swap(modified_, other.modified_);
  return *this;
}

InputFile::~InputFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

Result<void> InputFile::read_at(std::uint64_t offset, std::span<char> out) const {
  std::size_t done = 0;
  while (done < out.size()) {
    const ssize_t count =
        ::pread(descriptor_, out.data() + done, out.size() - done, static_cast<off_t>(offset + done));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0)
      return fail(ErrorCode::FileAccess, path_, "cannot be read: " + reason(errno),
                  "check the disk it is on");
    if (count == 0) {
      return fail(ErrorCode::InvalidFile, at_byte(path_, offset + done),
                  "the file ends here, but more was expected", "copy or export it again");
    }
    done += static_cast<std::size_t>(count);
  }
  struct stat status {};
  const bool same = ::fstat(descriptor_, &status) == 0 &&
                    static_cast<std::uint64_t>(status.st_size) == size_ &&
                    status.st_mtim.tv_sec == modified_.tv_sec && status.st_mtim.tv_nsec == modified_.tv_nsec;
  if (!same)
    return fail(ErrorCode::InvalidFile, path_, "has been written to since it was opened", "open it again");
  return {};
}

Result<std::vector<char>> read_file(const std::string& path, const ReadProgress& progress) {
  constexpr std::uint64_t kBlock = std::uint64_t{1} << 22;
  auto file = FOLDPROOF_TRY(InputFile::open(path));
  std::vector<char> bytes;
  bytes.reserve(file.size());
  while (bytes.size() < file.size()) {
    const std::size_t done = bytes.size();
    bytes.resize(std::min(done + kBlock, file.size()));
    FOLDPROOF_TRY(file.read_at(done, std::span(bytes).subspan(done)));
    if (progress) progress(path, bytes.size(), file.size());
  }
  return bytes;
}

Result<void> write_file(const std::string& path, std::span<const char> bytes) {
  auto file = FOLDPROOF_TRY(FileWriter::open(path));
  FOLDPROOF_TRY(file.write(bytes));
  return file.commit();
}

std::string at_byte(const std::string& path, std::uint64_t offset) {
  return fmt::format("{}, byte {}", path, offset);
}

}  // namespace foldproof::io
