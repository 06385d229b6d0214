/// An unnamed temporary file for data that is too large for memory; closing it deletes it.
#pragma once

#include "foldproof/base.h"

namespace foldproof::io {

class Spool {
 public:
  /// `where` is for errors.
  static Result<Spool> open(std::string where);
  Spool(Spool&& other) noexcept;
  Spool& operator=(Spool&& other) noexcept;
  ~Spool();

  Result<void> append(std::span<const char> bytes);
  /// Fills `out` with the bytes from `offset`; false when they cannot be read.
  bool read_at(std::uint64_t offset, std::span<char> out) const;

 private:
  Spool() = default;
  std::string where_;
  int descriptor_ = -1;
};

}  // namespace foldproof::io
