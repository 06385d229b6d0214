/// A temporary file without a name: takes what is too much for memory, and is gone when closed.
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
  /// Fills `out` from `offset`; false when that cannot be read.
  bool read_at(std::uint64_t offset, std::span<char> out) const;

 private:
  Spool() = default;
  std::string where_;
  int descriptor_ = -1;
};

}  // namespace foldproof::io
