/// What the library uses of zlib besides PNG, which Emscripten does not have.
#pragma once

#include <array>
#include <cstdint>

using Bytef = unsigned char;
using uInt = unsigned int;

/// Continues the checksum of ZIP and PNG (ISO 3309), bytewise.
inline unsigned long crc32(unsigned long sum, const Bytef* bytes, uInt size) {
  static const auto kTable = [] {
    std::array<std::uint32_t, 256> table{};
    for (std::uint32_t k = 0; k < 256; ++k) {
      table[k] = k;
      for (int bit = 0; bit < 8; ++bit) table[k] = (table[k] >> 1) ^ ((table[k] & 1) != 0 ? 0xedb88320 : 0);
    }
    return table;
  }();
  auto rest = static_cast<std::uint32_t>(~sum);
  for (uInt i = 0; i < size; ++i) rest = (rest >> 8) ^ kTable[(rest ^ bytes[i]) & 255];
  return static_cast<std::uint32_t>(~rest);
}
