/// A stored ZIP archive, written front to back. libzip is not used: it opens its output itself, which would
/// bypass FileWriter.
#pragma once

#include <string>
#include <vector>

#include "foldproof/io.h"

namespace foldproof::io {

/// Always ZIP64, so that there is one form to test. Per member: begin, data until `bytes` are written, end.
/// The caller commits the file after finish.
class ZipWriter {
 public:
  explicit ZipWriter(FileWriter& file) : file_(file) {}

  Result<void> begin(std::string name, std::uint64_t bytes);
  Result<void> data(std::span<const char> bytes);
  Result<void> end();
  Result<void> finish();

 private:
  struct Member {
    std::string name;
    std::uint64_t offset = 0;  ///< Of its local header.
    std::uint64_t bytes = 0;
    std::uint32_t crc = 0;
  };
  static void append_common(std::vector<char>& bytes, const Member& member);
  static void append_name(std::vector<char>& bytes, const Member& member);
  Result<void> put(std::span<const char> bytes);

  FileWriter& file_;
  std::uint64_t at_ = 0;
  std::vector<Member> members_;
};

}  // namespace foldproof::io
