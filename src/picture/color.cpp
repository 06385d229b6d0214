#include "picture/color.h"

#include <algorithm>
#include <cmath>

namespace foldproof::picture {
namespace {

// IEC 61966-2-1.
double decode(double value) {
  return value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
}
double encode(double light) {
  return light <= 0.0031308 ? light * 12.92 : 1.055 * std::pow(light, 1 / 2.4) - 0.055;
}

constexpr int kSteps = 1 << 14;  // fine enough for an exact round trip of every 8-bit value

struct Tables {
  std::array<float, 256> light;
  std::array<std::uint8_t, kSteps + 1> code;
  Tables() {
    for (int k = 0; k < 256; ++k) light[k] = static_cast<float>(decode(k / 255.0));
    for (int k = 0; k <= kSteps; ++k)
      code[k] = static_cast<std::uint8_t>(std::lround(255 * encode(static_cast<double>(k) / kSteps)));
  }
};

const Tables& tables() {
  static const Tables the_tables;
  return the_tables;
}

}  // namespace

LinearColor to_linear(Color color) {
  const auto& light = tables().light;
  return {light[color.red], light[color.green], light[color.blue]};
}

Color to_color(const LinearColor& light) {
  const auto& code = tables().code;
  const auto encoded = [&](float value) {
    return code[static_cast<std::size_t>(std::lround(std::clamp(value, 0.0F, 1.0F) * kSteps))];
  };
  return {encoded(light[0]), encoded(light[1]), encoded(light[2])};
}

}  // namespace foldproof::picture
