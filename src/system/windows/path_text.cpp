// std::filesystem::path of text in UTF-8. GCC 12's library makes it by mbrtowc, which knows no UTF-8 there,
// though its path::string writes it. The linker takes the function below instead (--wrap in
// src/CMakeLists.txt), so that no conversion can be forgotten.
#include <cwchar>

#include "text.h"

namespace foldproof::system {
namespace {

constexpr wchar_t kInvalid = 0xfffd;  // the replacement character

struct CodePoint {
  char32_t value = kInvalid;
  std::size_t bytes = 1;
};

/// The first of a text that is not empty.
CodePoint decode(const unsigned char* text, std::size_t size) {
  const unsigned char first = text[0];
  if (first < 0x80) return {first, 1};
  const std::size_t bytes = first >= 0xf0 ? 4 : first >= 0xe0 ? 3 : 2;
  constexpr char32_t kLeast[] = {0, 0, 0x80, 0x800, 0x10000};
  if (first < 0xc2 || first > 0xf4 || size < bytes) return {};
  char32_t value = first & (0x7fu >> bytes);
  for (std::size_t i = 1; i < bytes; ++i) {
    if ((text[i] & 0xc0) != 0x80) return {};
    value = value << 6 | (text[i] & 0x3fu);
  }
  const bool surrogate = value >= 0xd800 && value < 0xe000;
  return value < kLeast[bytes] || value > 0x10ffff || surrogate ? CodePoint{} : CodePoint{value, bytes};
}

}  // namespace

void take_utf8_in_paths() {}

}  // namespace foldproof::system

/// As the standard's, for UTF-8. Of a code point with two units, the second is kept in `state` and comes with
/// its last byte. Bytes that are no UTF-8 become the replacement character.
extern "C" std::size_t __wrap_mbrtowc(wchar_t* to, const char* from, std::size_t size,
                                      std::mbstate_t* state) {
  static thread_local std::mbstate_t own{};
  if (state == nullptr) state = &own;
  if (from == nullptr || size == 0) {
    if (from == nullptr) *state = {};
    return from == nullptr ? 0 : static_cast<std::size_t>(-2);
  }
  wchar_t unit = static_cast<wchar_t>(*state);
  std::size_t bytes = 1;
  if (unit != 0) {
    *state = {};
  } else {
    const auto point = foldproof::system::decode(reinterpret_cast<const unsigned char*>(from), size);
    bytes = point.bytes;
    unit = static_cast<wchar_t>(point.value);
    if (point.value > 0xffff) {
      unit = static_cast<wchar_t>(0xd800 + ((point.value - 0x10000) >> 10));
      *state = static_cast<std::mbstate_t>(0xdc00 + (point.value & 0x3ff));
      --bytes;
    }
  }
  if (to != nullptr) *to = unit;
  return unit == 0 ? 0 : bytes;
}
