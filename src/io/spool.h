/// An unnamed temporary file for data that is too large for memory; closing it deletes it.
#pragma once

#include "foldproof/base.h"
#include "system/file.h"

namespace foldproof::io {

class Spool {
 public:
  /// `where` is for errors.
  static Result<Spool> open(std::string where);

  Result<void> append(std::span<const char> bytes);
  /// Fills `out` with the bytes from `offset`; false when they cannot be read.
  bool read_at(std::uint64_t offset, std::span<char> out) const;

 private:
  Spool(std::string where, system::File file) : where_(std::move(where)), file_(std::move(file)) {}

  std::string where_;
  system::File file_;
};

}  // namespace foldproof::io
