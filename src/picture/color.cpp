#include "picture/color.h"

#include <algorithm>
#include <cmath>

namespace foldproof {
namespace picture {
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

}  // namespace picture

namespace {

/// Oklab (Ottosson 2020): lightness and two opponent axes, perceptually uniform.
struct Lab {
  double lightness, a, b;
};

Color to_color(const Lab& lab) {
  const double l = std::pow(lab.lightness + 0.3963377774 * lab.a + 0.2158037573 * lab.b, 3);
  const double m = std::pow(lab.lightness - 0.1055613458 * lab.a - 0.0638541728 * lab.b, 3);
  const double s = std::pow(lab.lightness - 0.0894841775 * lab.a - 1.2914855480 * lab.b, 3);
  return picture::to_color({static_cast<float>(4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s),
                            static_cast<float>(-1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s),
                            static_cast<float>(-0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s)});
}

// Lightness in even steps. Hues go from yellow to blue, which color vision deficiencies rarely confuse.
constexpr std::array<Lab, 5> kErrorStops{{{0.90, 0.002, 0.010},
                                          {0.75, 0.055, 0.135},
                                          {0.60, 0.150, 0.085},
                                          {0.45, 0.155, -0.020},
                                          {0.30, 0.070, -0.090}}};
constexpr std::array<Lab, 5> kLevelStops{{{0.30, 0.000, -0.120},
                                          {0.45, -0.040, -0.090},
                                          {0.60, -0.085, -0.015},
                                          {0.75, -0.090, 0.090},
                                          {0.90, -0.030, 0.150}}};

}  // namespace

Color map_color(ColorMap map, double value) {
  const auto& stops = map == ColorMap::Error ? kErrorStops : kLevelStops;
  const double position = value > 0 ? std::min(value, 1.0) * (stops.size() - 1) : 0;
  const auto low = std::min(static_cast<std::size_t>(position), stops.size() - 2);
  const double t = position - static_cast<double>(low);
  const Lab &from = stops[low], &to = stops[low + 1];
  return to_color(Lab{std::lerp(from.lightness, to.lightness, t), std::lerp(from.a, to.a, t),
                      std::lerp(from.b, to.b, t)});
}

}  // namespace foldproof
