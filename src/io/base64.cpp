#include "io/base64.h"

#include <algorithm>

namespace foldproof::io {

int base64_digit(char c) {
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  if (c == '+') return 62;
  return c == '/' ? 63 : -1;
}

bool ByteStream::next(char& byte) {
  while (bit_count_ < 8) {
    if (text_.empty()) return false;
    const char c = text_.front();
    text_.remove_prefix(1);
    if (c == '=') {
      bit_count_ = 0;
    } else if (const int digit = base64_digit(c); digit >= 0) {
      bits_ = bits_ << 6 | static_cast<unsigned>(digit);
      bit_count_ += 6;
    } else if (c != ' ' && c != '\n' && c != '\r' && c != '\t') {
      return false;
    }
  }
  bit_count_ -= 8;
  byte = static_cast<char>(bits_ >> bit_count_ & 0xff);
  return true;
}

bool ByteStream::read(std::span<char> out) {
  if (base64_) return std::ranges::all_of(out, [this](char& byte) { return next(byte); });
  if (out.size() > text_.size()) return false;
  std::copy_n(text_.begin(), out.size(), out.begin());
  text_.remove_prefix(out.size());
  return true;
}

}  // namespace foldproof::io
