/// Generated meshes and random deformations, for tests that hold whole queries against brute force.
#pragma once

#include <memory>
#include <ostream>
#include <span>
#include <vector>

#include "foldproof/check.h"
#include "oracle/families.h"

namespace foldproof::oracle {

struct Mesh {
  Index vertex_count = 0;
  std::vector<Triangle> triangles;
  std::vector<Edge> lines;        ///< After the triangles.
  std::vector<Index> points;      ///< After the lines.
  std::vector<double> positions;  ///< vertex_count x 3.

  Topology topology() const;
};

struct MeshFamily {
  const char* name;
  Mesh (*make)(Rng& rng);  ///< A few dozen to a few hundred triangles, about one mesh unit across.
};

/// For GoogleTest's messages.
inline void PrintTo(const MeshFamily& family, std::ostream* out) { *out << family.name; }

/// Sphere, cylinder, folded cloth, soup, non-manifold, several components, degenerate triangles and
/// duplicates, lines and points.
std::span<const MeshFamily> mesh_families();

/// A smooth random deformation of size `amplitude` and a jitter of a tenth of it. When `grid` is not zero,
/// positions are rounded to its multiples, so that exact touching happens.
std::vector<double> deformed(std::span<const double> positions, double amplitude, double grid, Rng& rng);

/// One query's input, kept together: objects, and positions at both ends.
struct Scene {
  std::vector<Topology> topologies;
  std::vector<std::vector<double>> x0, x1;
  std::vector<std::span<const double>> spans0() const { return {x0.begin(), x0.end()}; }
  std::vector<std::span<const double>> spans1() const { return {x1.begin(), x1.end()}; }
  std::vector<Object> hierarchies(Index leaf_triangles) const;
};

}  // namespace foldproof::oracle
