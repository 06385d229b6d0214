// Color maps: even steps of lightness, also with color vision deficiency.
#include <gmock/gmock.h>

#include "picture/color.h"

namespace foldproof {
namespace {

using picture::LinearColor;
using picture::to_color;
using picture::to_linear;

/// CIE lightness, 0 to 100, from linear values (IEC 61966-2-1 primaries).
double lightness(const LinearColor& color) {
  const double y = 0.2126 * color[0] + 0.7152 * color[1] + 0.0722 * color[2];
  return y > 216.0 / 24389 ? 116 * std::cbrt(y) - 16 : y * 24389 / 27;
}

TEST(PictureColor, EveryCodeRoundTrips) {
  for (int k = 0; k < 256; ++k) {
    const Color gray{static_cast<std::uint8_t>(k), static_cast<std::uint8_t>(255 - k), 7};
    EXPECT_EQ(to_color(to_linear(gray)), gray);
  }
  EXPECT_EQ(to_color(LinearColor(2, -1, 0.5F)), (Color{255, 0, 188}));
}

TEST(PictureColor, LightnessHasEvenSteps) {
  for (const auto& [map, sign] : {std::pair{ColorMap::Error, -1}, {ColorMap::Level, 1}}) {
    constexpr int kSteps = 20;
    std::vector<double> values;
    for (int k = 0; k <= kSteps; ++k)
      values.push_back(sign * lightness(to_linear(map_color(map, static_cast<double>(k) / kSteps))));
    const double mean = (values.back() - values.front()) / kSteps;
    EXPECT_GT(mean, 2.5);
    for (int k = 0; k < kSteps; ++k) {
      const double step = values[k + 1] - values[k];
      EXPECT_GT(step, 0.6 * mean) << k;
      EXPECT_LT(step, 1.4 * mean) << k;
    }
  }
}

/// Simulated full protanopia, deuteranopia and tritanopia (Machado, Oliveira and Fernandes 2009, severity 1).
TEST(PictureColor, OrderHoldsWithColorVisionDeficiency) {
  Eigen::Matrix3f protan, deutan, tritan;
  protan << 0.152286F, 1.052583F, -0.204868F, 0.114503F, 0.786281F, 0.099216F, -0.003882F, -0.048116F,
      1.051998F;
  deutan << 0.367322F, 0.860646F, -0.227968F, 0.280085F, 0.672501F, 0.047413F, -0.011820F, 0.042940F,
      0.968881F;
  tritan << 1.255528F, -0.076749F, -0.178779F, -0.078411F, 0.930809F, 0.147602F, 0.004733F, 0.691367F,
      0.303900F;
  for (const auto& sight : {protan, deutan, tritan}) {
    for (const auto& [map, sign] : {std::pair{ColorMap::Error, -1}, {ColorMap::Level, 1}}) {
      double last = -1000;
      for (int k = 0; k <= 20; ++k) {
        const LinearColor color = to_linear(map_color(map, k / 20.0));
        const double value = sign * lightness((sight * color.matrix()).cwiseMax(0).array());
        EXPECT_GT(value, last + 1) << k;
        last = value;
      }
    }
  }
}

TEST(PictureColor, ValuesAreClamped) {
  for (const ColorMap map : {ColorMap::Error, ColorMap::Level}) {
    EXPECT_EQ(map_color(map, -3), map_color(map, 0));
    EXPECT_EQ(map_color(map, 7), map_color(map, 1));
    EXPECT_EQ(map_color(map, std::nan("")), map_color(map, 0));
    EXPECT_FALSE(map_color(map, 0) == map_color(map, 1));
  }
}

}  // namespace
}  // namespace foldproof
