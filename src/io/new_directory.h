/// A directory that appears whole or not at all, as FileWriter's files do.
#pragma once

#include <filesystem>

#include "foldproof/base.h"

namespace foldproof::io {

/// Made beside its target under another name, and removed unless it gets the target's name.
class NewDirectory {
 public:
  static Result<NewDirectory> open(std::filesystem::path target);
  NewDirectory(NewDirectory&& other) noexcept;
  ~NewDirectory();

  /// Where to write until then.
  const std::filesystem::path& path() const { return path_; }

  /// Gives it the target's name. Error: a file or a directory that is not empty has it.
  Result<void> commit();
  /// The same in place of what has the name.
  Result<void> replace();

 private:
  NewDirectory() = default;
  std::filesystem::path target_, path_;
};

}  // namespace foldproof::io
