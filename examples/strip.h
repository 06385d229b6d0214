// A strip of triangles that bends by any angle, generated; the examples' mesh.
#pragma once

#include <cmath>
#include <vector>

#include "foldproof/io.h"

inline std::vector<double> bent_strip(double angle, int length = 40) {
  std::vector<double> x;
  double along = 0, up = 0;
  for (int k = 0; k <= length; ++k) {
    for (const double across : {0.0, 1.0, 2.0}) x.insert(x.end(), {along, across, up});
    along += std::cos(angle * k / length);
    up += std::sin(angle * k / length);
  }
  return x;
}

inline foldproof::Topology strip_topology(foldproof::Index length = 40) {
  std::vector<foldproof::Triangle> triangles;
  for (foldproof::Index v = 0; v < 3 * length; ++v) {
    if (v % 3 == 2) continue;
    triangles.push_back({v, v + 1, v + 3});
    triangles.push_back({v + 1, v + 4, v + 3});
  }
  return foldproof::Topology::make(3 * (length + 1), triangles).value();
}

inline std::unique_ptr<foldproof::Motion> bending_strip(double from, double to, int frames) {
  std::vector<std::vector<double>> poses;
  for (int k = 0; k < frames; ++k) poses.push_back(bent_strip(from + (to - from) * k / (frames - 1)));
  return foldproof::memory_motion("strip", strip_topology(), poses);
}
