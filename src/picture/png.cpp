#include <png.h>

#include "foldproof/picture.h"

namespace foldproof {

// libpng's simplified interface: an error is a value there, too, and not a jump across our frames.
Result<void> write_png(const std::string& path, const Image& image) {
  const std::size_t pixels = std::size_t{image.width} * image.height;
  if (pixels == 0 || image.pixels.size() != pixels)
    return fail(path, "is to hold a picture without pixels", "draw one of at least one pixel");
  auto file = FileWriter::open(path);
  if (!file) return tl::unexpected(file.error());

  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  header.width = image.width;
  header.height = image.height;
  header.format = PNG_FORMAT_RGB;
  std::vector<char> bytes(PNG_IMAGE_PNG_SIZE_MAX(header));
  png_alloc_size_t size = bytes.size();
  static_assert(sizeof(Colour) == 3, "pixels go to libpng as they are");
  if (!png_image_write_to_memory(&header, bytes.data(), &size, 0, image.pixels.data(), 0, nullptr)) {
    return fail(path, std::string("cannot be made a PNG: ") + header.message, "draw a smaller picture");
  }
  if (auto done = file->write(std::span(bytes).first(size)); !done) return done;
  return file->commit();
}

}  // namespace foldproof
