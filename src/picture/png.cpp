#include <png.h>

#include "base/try.h"
#include "io/bytes.h"
#include "picture/picture.h"

namespace foldproof {

namespace {

/// Pixels with their opacity, as libpng reads them.
std::vector<std::uint8_t> interleaved(const Image& image) {
  std::vector<std::uint8_t> bytes;
  bytes.reserve(4 * image.pixels.size());
  for (std::size_t k = 0; k < image.pixels.size(); ++k) {
    const Color& c = image.pixels[k];
    bytes.insert(bytes.end(), {c.red, c.green, c.blue, image.alpha[k]});
  }
  return bytes;
}

}  // namespace

// Uses libpng's simplified interface, which returns errors instead of calling longjmp.
Result<std::string> png_bytes(const Image& image) {
  const std::size_t pixels = std::size_t{image.width} * image.height;
  if (pixels == 0 || image.pixels.size() != pixels || (!image.alpha.empty() && image.alpha.size() != pixels))
    return fail(ErrorCode::InvalidArgument, "a picture", "is without pixels",
                "draw one of at least one pixel");
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  header.width = image.width;
  header.height = image.height;
  header.format = image.alpha.empty() ? PNG_FORMAT_RGB : PNG_FORMAT_RGBA;
  std::string bytes(PNG_IMAGE_PNG_SIZE_MAX(header), '\0');
  png_alloc_size_t size = bytes.size();
  static_assert(sizeof(Color) == 3, "pixels go to libpng as they are");
  const std::vector<std::uint8_t> rgba =
      image.alpha.empty() ? std::vector<std::uint8_t>() : interleaved(image);
  const void* data = image.alpha.empty() ? static_cast<const void*>(image.pixels.data()) : rgba.data();
  if (!png_image_write_to_memory(&header, bytes.data(), &size, 0, data, 0, nullptr)) {
    return fail(ErrorCode::LimitExceeded, "a picture", std::string("cannot be made a PNG: ") + header.message,
                "draw a smaller one");
  }
  bytes.resize(size);
  return bytes;
}

Result<void> write_png(const std::string& path, const Image& image) {
  const auto bytes = png_bytes(image);
  if (!bytes) return fail(bytes.error().code, path, bytes.error().problem, bytes.error().remedy);
  return io::write_file(path, *bytes);
}

}  // namespace foldproof
