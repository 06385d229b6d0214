// Pictures of saved reports: PNG, compressed by the function `deflate` of the JavaScript module.
#include <emscripten.h>

#include <array>

#include "picture/picture.h"
#include "zlib.h"

namespace foldproof {
namespace {

// The bytes as a zlib stream in memory of its own, after its size in 4 bytes.
EM_JS(char*, deflated, (const char* bytes, std::size_t size), {
  const packed = Module['deflate'](HEAPU8.subarray(bytes, bytes + size));
  const at = _malloc(4 + packed.length);
  HEAPU32[at >> 2] = packed.length;
  HEAPU8.set(packed, at + 4);
  return at;
});

std::string zlib_stream(const std::string& bytes) {
  char* packed = deflated(bytes.data(), bytes.size());
  std::uint32_t size = 0;
  std::memcpy(&size, packed, sizeof size);
  std::string stream(packed + sizeof size, size);
  std::free(packed);
  return stream;
}

std::string big_endian(std::uint32_t value) {
  std::string bytes;
  for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(value >> shift);
  return bytes;
}

std::uint32_t crc(const std::string& bytes) {
  return static_cast<std::uint32_t>(
      crc32(0, reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uInt>(bytes.size())));
}

std::string chunk(const std::string& type, const std::string& data) {
  return big_endian(static_cast<std::uint32_t>(data.size())) + type + data + big_endian(crc(type + data));
}

/// Rows without a filter.
std::string rows_of(const Image& image) {
  std::string rows;
  for (std::size_t k = 0; k < image.pixels.size(); ++k) {
    if (k % image.width == 0) rows += '\0';
    const Color& c = image.pixels[k];
    for (const std::uint8_t value : {c.red, c.green, c.blue}) rows += static_cast<char>(value);
    if (!image.alpha.empty()) rows += static_cast<char>(image.alpha[k]);
  }
  return rows;
}

}  // namespace

Result<std::string> png_bytes(const Image& image) {
  const std::string depth_and_type = image.alpha.empty() ? "\x08\x02" : "\x08\x06";
  const std::string header = big_endian(image.width) + big_endian(image.height) + depth_and_type;
  return "\x89PNG\r\n\x1a\n" + chunk("IHDR", header + std::string(3, '\0')) +
         chunk("IDAT", zlib_stream(rows_of(image))) + chunk("IEND", "");
}

}  // namespace foldproof
