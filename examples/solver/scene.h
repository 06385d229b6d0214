// A cloth above a soft ball on a floor, generated: vertices, faces, masses and springs.
#pragma once

#include <vector>

#include "foldproof/solver.h"

namespace example {

using foldproof::Index;
using foldproof::Vec3;

struct Spring {
  Index a, b;
  double stiffness;  // N/m
  double rest;       // m
};

// Metres, kilograms, seconds. Vertices from `movable` on stand still.
struct Scene {
  std::vector<double> x;
  std::vector<foldproof::Triangle> faces;
  std::vector<Spring> springs;
  std::vector<double> mass;
  Index movable = 0;
  Index floor_begin = 0;
  Index vertex_count() const { return static_cast<Index>(x.size() / 3); }
};

// `cloth`: vertices along a side of 1 m. `ball`: how often an icosahedron's faces are quartered.
Scene cloth_on_ball(Index cloth, int ball);

}  // namespace example
