#include <fmt/format.h>

#include <algorithm>

#include "foldproof/mesh.h"

namespace foldproof {

Result<Topology> Topology::make(Index vertex_count, std::vector<Triangle> triangles) {
  if (triangles.empty()) return fail("mesh", "has no triangles", "give a mesh with at least one face");
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    for (const Index v : triangles[i]) {
      if (v >= vertex_count) {
        return fail(fmt::format("triangle {}", i),
                    fmt::format("names vertex {}, but there are {} (counting from 0)", v, vertex_count),
                    "export the mesh again");
      }
    }
  }
  Topology mesh;
  mesh.vertex_count_ = vertex_count;
  mesh.triangles_ = std::move(triangles);

  std::vector<Edge>& edges = mesh.edges_;
  edges.reserve(mesh.triangles_.size() * 3);
  for (const Triangle& t : mesh.triangles_) {
    for (int k = 0; k < 3; ++k) {
      const Index a = t[k], b = t[(k + 1) % 3];
      if (a != b) edges.push_back({std::min(a, b), std::max(a, b)});
    }
  }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  edges.shrink_to_fit();

  mesh.triangle_edges_.reserve(mesh.triangles_.size());
  for (const Triangle& t : mesh.triangles_) {
    std::array<Index, 3> ids;
    for (int k = 0; k < 3; ++k) {
      const Index a = t[k], b = t[(k + 1) % 3];
      const Edge edge{std::min(a, b), std::max(a, b)};
      ids[k] = a == b
                   ? kNoIndex
                   : static_cast<Index>(std::lower_bound(edges.begin(), edges.end(), edge) - edges.begin());
    }
    mesh.triangle_edges_.push_back(ids);
  }
  return mesh;
}

bool share_vertex(const Triangle& a, const Triangle& b) {
  for (const Index v : a) {
    if (v == b[0] || v == b[1] || v == b[2]) return true;
  }
  return false;
}

}  // namespace foldproof
