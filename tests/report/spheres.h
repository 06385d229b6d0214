/// Two spheres in one mesh that move together: no step has a contact, whether they are separated or overlap.
#pragma once

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "report/report.h"

namespace foldproof::testing {

/// Unit spheres with their centers `distance` apart along x; each frame moves them by a quarter along y. The
/// second is rotated and lifted slightly, so that no two vertices or edges touch.
inline std::unique_ptr<Motion> two_spheres(double distance, std::size_t frames = 3) {
  constexpr Index kAround = 16, kAcross = 9;
  constexpr double kPi = 3.14159265358979323846;
  std::vector<double> x;
  std::vector<Triangle> triangles;
  for (const double turn : {0.0, 0.137}) {
    const auto first = static_cast<Index>(x.size() / 3);
    const double middle = turn == 0 ? 0 : distance, height = turn / 4;
    for (Index i = 0; i < kAcross; ++i) {
      const double lift = kPi * (i + 1) / (kAcross + 1);
      for (Index k = 0; k < kAround; ++k) {
        const double angle = 2 * kPi * k / kAround + turn;
        x.insert(x.end(), {middle + std::sin(lift) * std::cos(angle), std::sin(lift) * std::sin(angle),
                           height + std::cos(lift)});
        const Index here = first + i * kAround + k, beside = first + i * kAround + (k + 1) % kAround;
        if (i + 1 == kAcross) continue;
        triangles.push_back({here, here + kAround, beside});
        triangles.push_back({beside, here + kAround, beside + kAround});
      }
    }
    const Index north = first + kAround * kAcross, south = north + 1, last = first + kAround * (kAcross - 1);
    x.insert(x.end(), {middle, 0, height + 1, middle, 0, height - 1});
    for (Index k = 0; k < kAround; ++k) {
      triangles.push_back({north, first + k, first + (k + 1) % kAround});
      triangles.push_back({south, last + (k + 1) % kAround, last + k});
    }
  }
  std::vector<std::vector<double>> all;
  for (std::size_t f = 0; f < frames; ++f) {
    all.push_back(x);
    for (std::size_t k = 1; k < x.size(); k += 3) all.back()[k] += 0.25 * static_cast<double>(f);
  }
  return memory_motion("spheres", *Topology::make(static_cast<Index>(x.size() / 3), std::move(triangles)),
                       std::move(all));
}

}  // namespace foldproof::testing
