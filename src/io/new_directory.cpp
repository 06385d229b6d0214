#include "io/new_directory.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <utility>

#include "base/try.h"
#include "io/write_error.h"

namespace foldproof::io {
namespace {

namespace fs = std::filesystem;

}  // namespace

Result<NewDirectory> NewDirectory::open(fs::path target) {
  NewDirectory made;
  constexpr int kMostTries = 1000;  // another process of this number may have left some behind
  int code = EEXIST;
  for (int number = 0; number < kMostTries && code == EEXIST; ++number) {
    made.path_ =
        target.parent_path() / fmt::format(".{}.{}-{}.part", target.filename().string(), ::getpid(), number);
    code = ::mkdir(made.path_.c_str(), 0777) == 0 ? 0 : errno;
  }
  if (code == 0) {
    made.target_ = std::move(target);
    return made;
  }
  made.path_.clear();
  return write_error(target, {code, std::generic_category()});
}

NewDirectory::NewDirectory(NewDirectory&& other) noexcept
    : target_(std::move(other.target_)), path_(std::exchange(other.path_, {})) {}

NewDirectory::~NewDirectory() {
  std::error_code ignored;
  if (!path_.empty()) fs::remove_all(path_, ignored);
}

Result<void> NewDirectory::commit() {
  std::error_code code;
  fs::rename(path_, target_, code);
  if (code) return write_error(target_, code);
  path_.clear();
  return {};
}

Result<void> NewDirectory::replace() {
  std::error_code ignored;
  const fs::path old = path_ / "old";
  fs::rename(target_, old, ignored);  // fails when there is none
  if (auto done = commit(); !done) {
    fs::rename(old, target_, ignored);
    return done;
  }
  fs::remove_all(target_ / "old", ignored);
  return {};
}

}  // namespace foldproof::io
