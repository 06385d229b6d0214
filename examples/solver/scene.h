// Generated scenes: vertices, faces, masses and springs.
#pragma once

#include <functional>
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
  double reach = 0.006;  // of the barrier, m
  // Where there is one: puts those vertices, heavy ones, that are led where they should be at a time.
  std::function<void(double seconds, std::span<double> x)> lead;
  Index vertex_count() const { return static_cast<Index>(x.size() / 3); }
};

// `cloth`: vertices along a side of 1 m. `ball`: how often an icosahedron's faces are quartered.
Scene cloth_on_ball(Index cloth, int ball);
// Soft balls, two on four, that fall into a bowl and onto each other.
Scene pile_of_balls(int quartered);
// A soft rod, 2 m long, of rings with as many vertices as `around`, whose ends turn against each other and
// come nearer until it winds around itself.
Scene twisted_rod(Index around);

}  // namespace example
