#include <fmt/format.h>

#include <algorithm>

#include "base/try.h"
#include "foldproof/solver.h"

namespace foldproof {
namespace {

Edge sorted(const Edge& e) { return {std::min(e[0], e[1]), std::max(e[0], e[1])}; }

Index find_edge(std::span<const Edge> sorted_edges, const Edge& edge) {
  const auto at = std::lower_bound(sorted_edges.begin(), sorted_edges.end(), edge);
  return at != sorted_edges.end() && *at == edge ? static_cast<Index>(at - sorted_edges.begin()) : kNoIndex;
}

Result<void> check_edges(Index vertex_count, std::span<const Edge> edges) {
  std::vector<std::pair<Edge, std::size_t>> rows;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const auto [a, b] = edges[i];
    if (std::max(a, b) >= vertex_count) {
      return fail(
          ErrorCode::InvalidMesh, fmt::format("edge {}", i),
          fmt::format("names vertex {}, but there are {} (counting from 0)", std::max(a, b), vertex_count),
          "correct the edge matrix");
    }
    if (a == b) {
      return fail(ErrorCode::InvalidMesh, fmt::format("edge {}", i),
                  fmt::format("goes from vertex {} to itself", a),
                  "leave it out; a vertex in no edge and no face is a point");
    }
    rows.emplace_back(sorted(edges[i]), i);
  }
  std::sort(rows.begin(), rows.end());
  for (std::size_t k = 1; k < rows.size(); ++k) {
    if (rows[k].first == rows[k - 1].first) {
      return fail(ErrorCode::InvalidMesh, fmt::format("edge {}", rows[k].second),
                  fmt::format("is the same as edge {}", rows[k - 1].second), "give every edge once");
    }
  }
  return {};
}

Result<void> check_faces(Index vertex_count, std::span<const Triangle> faces) {
  const auto highest = [](const Triangle& t) { return std::max({t[0], t[1], t[2]}); };
  const auto beyond =
      std::ranges::find_if(faces, [&](const Triangle& t) { return highest(t) >= vertex_count; });
  if (beyond != faces.end()) {
    return fail(
        ErrorCode::InvalidMesh, fmt::format("face {}", beyond - faces.begin()),
        fmt::format("names vertex {}, but there are {} (counting from 0)", highest(*beyond), vertex_count),
        "correct the face matrix");
  }
  const auto point =
      std::ranges::find_if(faces, [](const Triangle& t) { return t[0] == t[1] && t[1] == t[2]; });
  if (point == faces.end()) return {};
  return fail(ErrorCode::InvalidMesh, fmt::format("face {}", point - faces.begin()),
              fmt::format("names vertex {} three times", (*point)[0]),
              "leave it out; a vertex in no edge and no face is a point");
}

Result<void> check_parts(std::size_t numbers, std::span<const Edge> edges, const CollisionFilter& filter) {
  if (numbers % 3 != 0 || numbers / 3 >= kNoIndex) {
    return fail(ErrorCode::InvalidArgument, "rest positions", fmt::format("are {} numbers", numbers),
                "give three coordinates per vertex");
  }
  const auto count = static_cast<Index>(numbers / 3);
  if (filter.vertex_count() != kNoIndex && filter.vertex_count() != count) {
    return fail(ErrorCode::InvalidArgument, "filter",
                fmt::format("is for {} vertices", filter.vertex_count()),
                fmt::format("give a group for each of the {}", count));
  }
  return check_edges(count, edges);
}

}  // namespace

Result<CollisionMesh> CollisionMesh::make(std::span<const double> rest_positions, std::vector<Edge> edges,
                                          std::vector<Triangle> faces, CollisionMeshSettings settings) {
  const auto count = static_cast<Index>(rest_positions.size() / 3);
  if (rest_positions.size() / 3 + edges.size() + 4 * faces.size() >= kNoIndex)
    return fail(ErrorCode::LimitExceeded, "mesh", "has too many vertices, edges and faces to number them",
                "split it");
  FOLDPROOF_TRY(check_parts(rest_positions.size(), edges, settings.filter));
  FOLDPROOF_TRY(check_faces(count, faces));
  CollisionMesh mesh;
  mesh.filter_ = std::move(settings.filter);
  std::vector<bool> is_point(count, settings.points);
  for (const Edge& e : edges) is_point[e[0]] = is_point[e[1]] = false;

  std::vector<Edge> face_edges, lines;
  if (!faces.empty()) {
    const auto surface = FOLDPROOF_TRY(Topology::make(count, faces));
    face_edges.assign(surface.edges().begin(), surface.edges().end());
    for (const Triangle& t : faces) {
      for (const Index v : t) is_point[v] = false;
    }
  }
  std::vector<bool> given(face_edges.size(), false);
  for (Index i = 0; i < edges.size(); ++i) {
    const Index found = find_edge(face_edges, sorted(edges[i]));
    if (found != kNoIndex) {
      given[found] = true;
      continue;
    }
    mesh.codim_edges_.push_back(i);
    lines.push_back(edges[i]);
  }
  mesh.edges_ = std::move(edges);
  for (std::size_t k = 0; k < face_edges.size(); ++k) {
    if (!given[k]) mesh.edges_.push_back(face_edges[k]);
  }
  for (Index v = 0; v < count; ++v) {
    if (is_point[v]) mesh.codim_points_.push_back(v);
  }
  if (faces.empty() && lines.empty() && mesh.codim_points_.empty())
    return fail(ErrorCode::InvalidMesh, "collision mesh", "has nothing that could collide",
                "give faces, edges or points");

  auto all = FOLDPROOF_TRY(Topology::make(count, std::move(faces), lines, mesh.codim_points_));
  mesh.edge_rows_.resize(all.edges().size());
  for (Index row = 0; row < mesh.edges_.size(); ++row)
    mesh.edge_rows_[find_edge(all.edges(), sorted(mesh.edges_[row]))] = row;
  for (const Edge& e : mesh.edges_) {
    const auto at = [&](Index v) { return Vec3::load(&rest_positions[3 * std::size_t{v}]); };
    mesh.squared_rest_lengths_.push_back((at(e[1]) - at(e[0])).squaredNorm());
  }
  auto tree = FOLDPROOF_TRY(Hierarchy::build(std::move(all), rest_positions, settings.hierarchy));
  mesh.hierarchy_ = std::make_shared<const Hierarchy>(std::move(tree));
  return mesh;
}

}  // namespace foldproof
