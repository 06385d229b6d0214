#include "io/spool.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <system_error>
#include <utility>

namespace foldproof::io {
namespace {

tl::unexpected<Error> write_error(const std::string& where) {
  return fail(ErrorCode::FileAccess, where,
              "needs a temporary file that cannot be written: " + std::generic_category().message(errno),
              "free space in the temporary directory, or name another one in TMPDIR");
}

}  // namespace

Spool::Spool(Spool&& other) noexcept
    : where_(std::move(other.where_)), descriptor_(std::exchange(other.descriptor_, -1)) {}

Spool& Spool::operator=(Spool&& other) noexcept {
  std::swap(where_, other.where_);
  std::swap(descriptor_, other.descriptor_);
  return *this;
}

Spool::~Spool() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

Result<Spool> Spool::open(std::string where) {
  Spool spool;
  spool.where_ = std::move(where);
  std::error_code status;
  std::string name = (std::filesystem::temp_directory_path(status) / "foldproof-XXXXXX").string();
  spool.descriptor_ = ::mkostemp(name.data(), O_CLOEXEC);
  if (spool.descriptor_ < 0) return write_error(spool.where_);
  ::unlink(name.c_str());
  return spool;
}

Result<void> Spool::append(std::span<const char> bytes) {
  while (!bytes.empty()) {
    const ssize_t count = ::write(descriptor_, bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return write_error(where_);
    bytes = bytes.subspan(static_cast<std::size_t>(count));
  }
  return {};
}

bool Spool::read_at(std::uint64_t offset, std::span<char> out) const {
  while (!out.empty()) {
    const ssize_t count = ::pread(descriptor_, out.data(), out.size(), static_cast<off_t>(offset));
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return false;
    out = out.subspan(static_cast<std::size_t>(count));
    offset += static_cast<std::uint64_t>(count);
  }
  return true;
}

}  // namespace foldproof::io
