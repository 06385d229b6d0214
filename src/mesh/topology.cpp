#include <fmt/format.h>

#include <algorithm>

#include "base/try.h"
#include "foldproof/mesh.h"

namespace foldproof {
namespace {

std::string name_of(std::size_t triangle, std::size_t faces, std::size_t lines) {
  if (triangle < faces) return fmt::format("triangle {}", triangle);
  if (triangle < faces + lines) return fmt::format("line {}", triangle - faces);
  return fmt::format("point {}", triangle - faces - lines);
}

Result<void> require_loose(std::span<const Index> points, std::span<const Triangle> others,
                           Index vertex_count) {
  if (points.empty()) return {};
  std::vector<bool> used(vertex_count, false);
  for (const Triangle& t : others) {
    for (const Index v : t) used[v] = true;
  }
  const auto bad = std::ranges::find_if(points, [&](Index p) { return used[p]; });
  if (bad == points.end()) return {};
  return fail(ErrorCode::InvalidMesh, fmt::format("point {}", bad - points.begin()),
              fmt::format("is vertex {}, which is on a face or a line", *bad), "leave it out");
}

}  // namespace

Result<Topology> Topology::make(Index vertex_count, std::vector<Triangle> faces) {
  return make(vertex_count, std::move(faces), {}, {});
}

Result<Topology> Topology::make(Index vertex_count, std::vector<Triangle> triangles,
                                std::span<const Edge> lines, std::span<const Index> points) {
  const std::size_t face_count = triangles.size();
  triangles.reserve(face_count + lines.size() + points.size());
  for (const auto& [a, b] : lines) {
    if (a == b) {
      return fail(ErrorCode::InvalidMesh, fmt::format("line {}", triangles.size() - face_count),
                  fmt::format("goes from vertex {} to itself", a), "leave it out");
    }
    triangles.push_back({a, b, b});
  }
  for (const Index p : points) triangles.push_back({p, p, p});
  if (triangles.empty())
    return fail(ErrorCode::InvalidMesh, "mesh", "has no triangles", "give a mesh with at least one face");
  if (triangles.size() > kMaxTriangles) {
    return fail(ErrorCode::LimitExceeded, "mesh", fmt::format("has more than {} triangles", kMaxTriangles),
                "split it");
  }
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    for (const Index v : triangles[i]) {
      if (v >= vertex_count) {
        return fail(ErrorCode::InvalidMesh, name_of(i, face_count, lines.size()),
                    fmt::format("names vertex {}, but there are {} (counting from 0)", v, vertex_count),
                    "export the mesh again");
      }
    }
  }
  FOLDPROOF_TRY(require_loose(points, std::span(triangles).first(face_count + lines.size()), vertex_count));
  Topology mesh;
  mesh.vertex_count_ = vertex_count;
  mesh.face_count_ = static_cast<Index>(face_count);
  mesh.line_count_ = static_cast<Index>(lines.size());
  mesh.triangles_ = std::move(triangles);
  mesh.find_edges();
  return mesh;
}

// Buckets the sides of triangles by their lower vertex, then sorts each bucket by the higher one.
void Topology::find_edges() {
  struct Side {
    Index high, slot;
    bool operator<(const Side& other) const {
      return high != other.high ? high < other.high : slot < other.slot;
    }
  };
  const auto for_each_side = [&](auto visit) {
    for (Index t = 0; t < triangles_.size(); ++t) {
      for (Index k = 0; k < 3; ++k) {
        const auto [low, high] = std::minmax(triangles_[t][k], triangles_[t][(k + 1) % 3]);
        if (low != high) visit(low, Side{high, 3 * t + k});
      }
    }
  };
  std::vector<Index> end(vertex_count_ + std::size_t{1}, 0);
  for_each_side([&](Index low, const Side&) { ++end[low + std::size_t{1}]; });
  for (std::size_t v = 0; v < vertex_count_; ++v) end[v + 1] += end[v];
  std::vector<Side> sides(end.back());
  // Before this, end[v] is where bucket v begins; after it, where it ends.
  for_each_side([&](Index low, const Side& side) { sides[end[low]++] = side; });
  triangle_edges_.assign(triangles_.size(), {kNoIndex, kNoIndex, kNoIndex});
  edges_.reserve(sides.size() / 2 + 1);
  std::size_t begin = 0;
  for (Index low = 0; low < vertex_count_; begin = end[low++]) {
    std::sort(sides.begin() + static_cast<std::ptrdiff_t>(begin),
              sides.begin() + static_cast<std::ptrdiff_t>(end[low]));
    for (std::size_t k = begin; k < end[low]; ++k) {
      if (k == begin || sides[k].high != sides[k - 1].high) edges_.push_back({low, sides[k].high});
      triangle_edges_[sides[k].slot / 3][sides[k].slot % 3] = static_cast<Index>(edges_.size() - 1);
    }
  }
  edges_.shrink_to_fit();
}

std::vector<Edge> Topology::lines() const {
  std::vector<Edge> lines;
  for (const auto& [a, b, c] : triangles().subspan(face_count_, line_count_)) lines.push_back({a, b});
  return lines;
}

std::vector<Index> Topology::points() const {
  std::vector<Index> points;
  for (const auto& [a, b, c] : triangles().subspan(face_count_ + line_count_)) points.push_back(a);
  return points;
}

bool share_vertex(const Triangle& a, const Triangle& b) {
  for (const Index v : a) {
    if (v == b[0] || v == b[1] || v == b[2]) return true;
  }
  return false;
}

bool may_cross(const Topology& topology, Index a, Index b) {
  return topology.element(a) == Element::Face || topology.element(b) == Element::Face ||
         !share_vertex(topology.triangles()[a], topology.triangles()[b]);
}

}  // namespace foldproof
