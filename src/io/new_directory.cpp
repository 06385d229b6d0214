#include "io/new_directory.h"

#include <fmt/format.h>

#include <system_error>
#include <utility>

#include "base/try.h"
#include "io/write_error.h"
#include "system/file.h"

namespace foldproof::io {
namespace {

namespace fs = std::filesystem;

}  // namespace

Result<NewDirectory> NewDirectory::open(fs::path target) {
  NewDirectory made;
  constexpr int kMostTries = 1000;  // another process of this number may have left some behind
  FOLDPROOF_TRY(require_possible_name(target.string(), target.string()));
  std::error_code code = std::make_error_code(std::errc::file_exists);
  for (int number = 0; number < kMostTries && code == std::errc::file_exists; ++number) {
    made.path_ = target.parent_path() /
                 fmt::format(".{}.{}-{}.part", target.filename().string(), system::process_number(), number);
    if (fs::create_directory(made.path_, code)) {
      made.target_ = std::move(target);
      return made;
    }
    if (!code) code = std::make_error_code(std::errc::file_exists);  // a directory that is there is no error
  }
  made.path_.clear();
  return write_error(target.string(), code);
}

NewDirectory::NewDirectory(NewDirectory&& other) noexcept
    : target_(std::move(other.target_)), path_(std::exchange(other.path_, {})) {}

NewDirectory::~NewDirectory() {
  std::error_code ignored;
  if (!path_.empty()) fs::remove_all(path_, ignored);
}

Result<void> NewDirectory::commit() {
  if (const std::error_code code = system::rename(path_, target_)) return write_error(target_.string(), code);
  path_.clear();
  return {};
}

Result<void> NewDirectory::replace() {
  const fs::path old = path_ / "old";
  std::error_code ignored = system::rename(target_, old);  // fails when there is none
  if (auto done = commit(); !done) {
    ignored = system::rename(old, target_);
    return done;
  }
  fs::remove_all(target_ / "old", ignored);
  return {};
}

}  // namespace foldproof::io
