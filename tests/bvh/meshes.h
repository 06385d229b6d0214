/// Small generated meshes for tests of hierarchies.
#pragma once

#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "foldproof/bvh.h"
#include "mesh/grid.h"

namespace foldproof::testing {

struct Mesh {
  Topology topology;
  std::vector<double> positions;
};

/// A cloth of side x side squares, two triangles each.
inline Mesh cloth(Index side) {
  const Grid grid{side, side, false, Diagonal::SecondToThird};
  return {grid.topology(), grid.positions([](double u, double v) { return std::array{v, u, 0.0}; })};
}

/// `count` triangles without common vertices, at random positions in the unit cube.
inline Mesh soup(Index count, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0, 1), offset(-0.05, 0.05);
  std::vector<Triangle> triangles;
  std::vector<double> x;
  for (Index t = 0; t < count; ++t) {
    const double center[3] = {unit(random), unit(random), unit(random)};
    for (int corner = 0; corner < 3; ++corner) {
      for (const double c : center) x.push_back(c + offset(random));
    }
    triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
  }
  return {*Topology::make(3 * count, std::move(triangles)), std::move(x)};
}

/// Degenerate triangles, a fan of five triangles on one edge, and a vertex that no triangle uses.
inline Mesh odd() {
  std::vector<Triangle> triangles{{0, 0, 1}, {1, 1, 1}, {0, 1, 2}, {0, 1, 2}};
  std::vector<double> x{0, 0, 0, 1, 0, 0};
  for (Index k = 0; k < 5; ++k) {
    x.insert(x.end(), {0.5, std::cos(1.2 * k), std::sin(1.2 * k)});
    triangles.push_back({0, 1, 2 + k});
  }
  x.insert(x.end(), {9, 9, 9});
  return {*Topology::make(8, std::move(triangles)), std::move(x)};
}

/// The positions with every coordinate moved by up to `amount`.
inline std::vector<double> perturbed(const std::vector<double>& x, double amount, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> move(-amount, amount);
  std::vector<double> y = x;
  for (double& c : y) c += move(random);
  return y;
}

}  // namespace foldproof::testing
