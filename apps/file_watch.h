/// Waiting for files to change.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <string>
#include <tuple>
#include <vector>

#include "file_arguments.h"

namespace foldproof {

/// Looks at the files that a command line reads, several times a second.
class FileWatch {
 public:
  /// `interrupted` ends all waiting. Both must outlive this.
  FileWatch(const FileArguments& files, const std::atomic<bool>& interrupted);

  /// Waits until no file has changed for a moment, so that none is half written, and notes how they are.
  void settle();
  /// Whether a file changes within a second, or has changed since `settle`: it was being written then.
  bool is_changing();
  /// Waits until a file differs from how `settle` found it; its name. Empty: interrupted.
  std::string wait();

 private:
  /// Name, size and time of the last change; of a missing file, the name alone.
  using State = std::vector<std::tuple<std::string, std::uint64_t, std::int64_t>>;

  State look() const;
  /// False: interrupted.
  bool pause() const;

  const FileArguments& files_;
  const std::atomic<bool>& interrupted_;
  State settled_;
};

}  // namespace foldproof
