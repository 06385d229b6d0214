/// Base64, and bytes that may be encoded in it.
#pragma once

#include <span>
#include <string_view>

namespace foldproof::io {

/// The value of a base64 digit; -1 for another character.
int base64_digit(char c);

/// Reads bytes in order, from base64 or as they are. Blanks are skipped; padding ends a group of digits,
/// after which another may follow.
class ByteStream {
 public:
  ByteStream(std::string_view text, bool base64) : text_(text), base64_(base64) {}

  /// At least as many bytes as are left.
  std::size_t remaining() const { return base64_ ? text_.size() / 4 * 3 + 3 : text_.size(); }
  /// Fills `out`; false when the stream ends before.
  bool read(std::span<char> out);

 private:
  bool next(char& byte);

  std::string_view text_;
  bool base64_;
  unsigned bits_ = 0;
  int bit_count_ = 0;
};

}  // namespace foldproof::io
