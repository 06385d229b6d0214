// Conversion between sRGB and linear values.
#include <gmock/gmock.h>

#include "picture/color.h"

namespace foldproof {
namespace {

using picture::LinearColor;
using picture::to_color;
using picture::to_linear;

TEST(PictureColor, EveryCodeRoundTrips) {
  for (int k = 0; k < 256; ++k) {
    const Color gray{static_cast<std::uint8_t>(k), static_cast<std::uint8_t>(255 - k), 7};
    EXPECT_EQ(to_color(to_linear(gray)), gray);
  }
  EXPECT_EQ(to_color(LinearColor(2, -1, 0.5F)), (Color{255, 0, 188}));
}

}  // namespace
}  // namespace foldproof
