// PNG files, read back with libpng.
#include <gmock/gmock.h>
#include <png.h>

#include <filesystem>
#include <fstream>

#include "picture/picture.h"
#include "report/sinking_triangle.h"

namespace foldproof {
namespace {

using ::testing::HasSubstr;
using testing::read_file;
using testing::TemporaryDirectory;

Image pattern(Index width, Index height) {
  Image image{width, height, {}};
  for (Index k = 0; k < width * height; ++k)
    image.pixels.push_back({static_cast<std::uint8_t>(k * 7), static_cast<std::uint8_t>(k / width), 200});
  return image;
}

TEST(Png, RoundTrip) {
  const TemporaryDirectory directory;
  for (const auto& [width, height] : {std::pair{37u, 11u}, {1u, 1u}, {300u, 2u}}) {
    const Image image = pattern(width, height);
    ASSERT_TRUE(write_png(directory / "a.png", image));
    const std::string bytes = read_file(directory / "a.png");
    EXPECT_EQ(bytes.substr(0, 8), "\x89PNG\r\n\x1a\n");
    EXPECT_EQ(bytes.substr(12, 4), "IHDR");
    png_image read{};
    read.version = PNG_IMAGE_VERSION;
    ASSERT_TRUE(png_image_begin_read_from_memory(&read, bytes.data(), bytes.size()));
    EXPECT_EQ(read.width, width);
    EXPECT_EQ(read.height, height);
    read.format = PNG_FORMAT_RGB;
    std::vector<Color> pixels(std::size_t{width} * height);
    ASSERT_TRUE(png_image_finish_read(&read, nullptr, pixels.data(), 0, nullptr));
    EXPECT_EQ(pixels, image.pixels);
    ASSERT_TRUE(write_png(directory / "b.png", image));
    EXPECT_EQ(read_file(directory / "b.png"), bytes);
  }
}

TEST(Png, KeepsOpacity) {
  Image image = pattern(5, 3);
  for (std::size_t k = 0; k < image.pixels.size(); ++k)
    image.alpha.push_back(static_cast<std::uint8_t>(255 - 17 * k));
  const auto bytes = png_bytes(image);
  ASSERT_TRUE(bytes);
  png_image read{};
  read.version = PNG_IMAGE_VERSION;
  ASSERT_TRUE(png_image_begin_read_from_memory(&read, bytes->data(), bytes->size()));
  read.format = PNG_FORMAT_RGBA;
  std::vector<std::uint8_t> rgba(4 * image.pixels.size());
  ASSERT_TRUE(png_image_finish_read(&read, nullptr, rgba.data(), 0, nullptr));
  for (std::size_t k = 0; k < image.pixels.size(); ++k) {
    EXPECT_EQ((Color{rgba[4 * k], rgba[4 * k + 1], rgba[4 * k + 2]}), image.pixels[k]);
    EXPECT_EQ(rgba[4 * k + 3], image.alpha[k]);
  }
  image.alpha.pop_back();
  EXPECT_FALSE(png_bytes(image));
}

TEST(Png, ErrorsLeaveNoFile) {
  const TemporaryDirectory directory;
  EXPECT_THAT(write_png(directory / "a.png", Image{}).error().line(), HasSubstr("without pixels"));
  EXPECT_THAT(write_png(directory / "a.png", Image{2, 2, {Color{}}}).error().line(),
              HasSubstr("without pixels"));
  EXPECT_THAT(write_png(directory / "none/a.png", pattern(2, 2)).error().line(),
              HasSubstr("cannot be written"));
  EXPECT_TRUE(std::filesystem::is_empty(directory.path()));
}

}  // namespace
}  // namespace foldproof
