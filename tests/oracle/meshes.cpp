#include "oracle/meshes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "mesh/grid.h"

namespace foldproof::oracle {
namespace {

Index below(Rng& rng, Index n) { return std::uniform_int_distribution<Index>(0, n - 1)(rng); }

Index add_vertex(Mesh& mesh, double x, double y, double z) {
  mesh.positions.insert(mesh.positions.end(), {x, y, z});
  return mesh.vertex_count++;
}

// `place`: see Grid::positions.
template <class Place>
Mesh mesh_of(const testing::Grid& grid, Place place) {
  return {.vertex_count = grid.vertex_count(),
          .triangles = grid.triangles(),
          .lines = {},
          .points = {},
          .positions = grid.positions(place)};
}

Mesh sphere(Rng&) {
  constexpr double kPi = std::numbers::pi;
  // Not quite to the poles, so that no triangle is degenerate.
  return mesh_of({12, 8, true}, [](double u, double v) {
    const double polar = kPi * (0.05 + 0.9 * v), around = 2 * kPi * u;
    return Vec3(0.5 * std::sin(polar) * std::cos(around), 0.5 * std::sin(polar) * std::sin(around),
                0.5 * std::cos(polar));
  });
}

Mesh cylinder(Rng&) {
  return mesh_of({8, 12, true}, [](double u, double v) {
    const double around = 2 * std::numbers::pi * u;
    return Vec3(0.15 * std::cos(around), 0.15 * std::sin(around), v - 0.5);
  });
}

Mesh folded_cloth(Rng& rng) {
  const double gap = uniform(rng, 0.005, 0.1);
  return mesh_of({16, 6}, [gap](double u, double v) {
    // Down one side and back up the other, `gap` apart.
    const double along = std::abs(u - 0.5) * 2, side = u < 0.5 ? -1 : 1;
    return Vec3(along - 0.5, v - 0.5, side * gap * std::min(1.0, 4 * along));
  });
}

Mesh soup(Rng& rng) {
  Mesh mesh;
  for (int i = 0; i < 60; ++i) {
    Triangle t;
    const Vec3 center(uniform(rng, -0.5, 0.5), uniform(rng, -0.5, 0.5), uniform(rng, -0.5, 0.5));
    for (Index& v : t) {
      v = add_vertex(mesh, center.x() + uniform(rng, -0.2, 0.2), center.y() + uniform(rng, -0.2, 0.2),
                     center.z() + uniform(rng, -0.2, 0.2));
    }
    mesh.triangles.push_back(t);
  }
  return mesh;
}

void append(Mesh& mesh, const Mesh& other, const Vec3& shift) {
  const Index first = mesh.vertex_count;
  for (Index v = 0; v < other.vertex_count; ++v) {
    add_vertex(mesh, other.positions[3 * v] + shift.x(), other.positions[3 * v + 1] + shift.y(),
               other.positions[3 * v + 2] + shift.z());
  }
  for (const Triangle& t : other.triangles)
    mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
}

// Five leaves of a book on one spine, and triangles that name any vertices at all.
Mesh non_manifold(Rng& rng) {
  Mesh mesh;
  constexpr Index kRows = 5;
  for (Index j = 0; j <= kRows; ++j) add_vertex(mesh, 0, 0, double(j) / kRows - 0.5);
  for (int leaf = 0; leaf < 5; ++leaf) {
    const double angle = uniform(rng, 0, 2 * std::numbers::pi);
    const Index first = mesh.vertex_count;
    for (Index j = 0; j <= kRows; ++j) {
      add_vertex(mesh, 0.5 * std::cos(angle), 0.5 * std::sin(angle), double(j) / kRows - 0.5);
    }
    for (Index j = 0; j < kRows; ++j) {
      mesh.triangles.push_back({j, j + 1, first + j});
      mesh.triangles.push_back({j + 1, first + j + 1, first + j});
    }
  }
  for (int i = 0; i < 10; ++i) {
    const Index n = mesh.vertex_count;
    mesh.triangles.push_back({below(rng, n), below(rng, n), below(rng, n)});
  }
  return mesh;
}

Mesh several_components(Rng& rng) {
  Mesh mesh;
  for (int i = 0; i < 3; ++i) {
    append(mesh, i == 1 ? cylinder(rng) : sphere(rng),
           Vec3(uniform(rng, -0.6, 0.6), uniform(rng, -0.6, 0.6), uniform(rng, -0.6, 0.6)));
  }
  add_vertex(mesh, 0, 0, 0);  // In no triangle.
  return mesh;
}

// Cloth with triangles that are segments or points, twice the same triangle, and vertices at the same place.
Mesh damaged(Rng& rng) {
  Mesh mesh = folded_cloth(rng);
  const Index n = mesh.vertex_count;
  for (int i = 0; i < 6; ++i) {
    const Index from = below(rng, n), to = below(rng, n);
    std::copy_n(mesh.positions.begin() + 3 * from, 3, mesh.positions.begin() + 3 * to);
  }
  for (int i = 0; i < 4; ++i) {
    const Index v = below(rng, n);
    mesh.triangles.push_back({v, v, below(rng, n)});
    mesh.triangles.push_back({v, v, v});
    mesh.triangles.push_back(mesh.triangles[below(rng, 50)]);
    Triangle turned = mesh.triangles[below(rng, 50)];
    std::swap(turned[0], turned[1]);
    mesh.triangles.push_back(turned);
    const double* p = &mesh.positions[3 * v];
    const Index twin = add_vertex(mesh, p[0], p[1], p[2]);
    mesh.triangles.push_back({twin, below(rng, n), below(rng, n)});
  }
  return mesh;
}

// A sphere with hairs, loose polylines and points around and in it; some of all are listed twice or are there
// already.
Mesh hairy(Rng& rng) {
  Mesh mesh = sphere(rng);
  const Index n = mesh.vertex_count;
  const auto anywhere = [&] {
    return add_vertex(mesh, uniform(rng, -0.7, 0.7), uniform(rng, -0.7, 0.7), uniform(rng, -0.7, 0.7));
  };
  for (int i = 0; i < 20; ++i) {
    Index from = i < 12 ? below(rng, n) : anywhere();
    for (int k = 0; k < 3; ++k) {
      const Vec3 p = Vec3::load(&mesh.positions[3 * from]) +
                     Vec3(uniform(rng, -0.3, 0.3), uniform(rng, -0.3, 0.3), uniform(rng, -0.3, 0.3));
      const Index to = add_vertex(mesh, p.x(), p.y(), p.z());
      mesh.lines.push_back(k == 1 ? Edge{to, from} : Edge{from, to});
      from = to;
    }
  }
  for (int i = 0; i < 25; ++i) mesh.points.push_back(anywhere());
  const Triangle& face = mesh.triangles[below(rng, 50)];
  mesh.lines.insert(mesh.lines.end(),
                    {{face[0], face[1]}, mesh.lines[3], {mesh.lines[5][1], mesh.lines[5][0]}});
  mesh.points.push_back(mesh.points[4]);
  mesh.triangles.push_back({mesh.lines[8][0], mesh.lines[8][1], mesh.lines[8][1]});
  return mesh;
}

constexpr std::array<MeshFamily, 8> kMeshFamilies = {{
    {"sphere", sphere},
    {"cylinder", cylinder},
    {"folded_cloth", folded_cloth},
    {"soup", soup},
    {"non_manifold", non_manifold},
    {"several_components", several_components},
    {"damaged", damaged},
    {"hairy", hairy},
}};

}  // namespace

Topology Mesh::topology() const {
  Result<Topology> made = Topology::make(vertex_count, triangles, lines, points);
  if (!made) throw std::runtime_error(made.error().line());
  return *made;
}

std::span<const MeshFamily> mesh_families() { return kMeshFamilies; }

std::vector<double> deformed(std::span<const double> positions, double amplitude, double grid, Rng& rng) {
  // Three plane waves about as long as the mesh, and noise.
  std::array<Vec3, 3> direction, frequency;
  std::array<double, 3> phase;
  for (int k = 0; k < 3; ++k) {
    direction[k] = Vec3(uniform(rng, -1, 1), uniform(rng, -1, 1), uniform(rng, -1, 1));
    frequency[k] = Vec3(uniform(rng, -5, 5), uniform(rng, -5, 5), uniform(rng, -5, 5));
    phase[k] = uniform(rng, 0, 6);
  }
  std::vector<double> result(positions.begin(), positions.end());
  for (std::size_t v = 0; v < result.size() / 3; ++v) {
    Vec3 p = Vec3::load(&result[3 * v]);
    Vec3 shift(uniform(rng, -0.1, 0.1), uniform(rng, -0.1, 0.1), uniform(rng, -0.1, 0.1));
    for (int k = 0; k < 3; ++k) shift += std::sin(frequency[k].dot(p) + phase[k]) * direction[k];
    p += amplitude * shift;
    if (grid != 0) p = nearest_multiple(p, grid);
    p.store(&result[3 * v]);
  }
  return result;
}

std::vector<Object> Scene::hierarchies(Index leaf_triangles) const {
  std::vector<Object> result;
  for (std::size_t i = 0; i < topologies.size(); ++i) {
    Result<Hierarchy> built = Hierarchy::build(topologies[i], x0[i], {leaf_triangles});
    if (!built) throw std::runtime_error(built.error().line());
    result.push_back(std::make_shared<const Hierarchy>(std::move(*built)));
  }
  return result;
}

}  // namespace foldproof::oracle
