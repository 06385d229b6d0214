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

// Appends what describes a hierarchy to Hierarchy::from_parts.
void append_parts(const Hierarchy& tree, Index first_triangle, std::vector<Index>& triangle_ids,
                  std::vector<Index>& leaf_sizes) {
  for (const Index id : tree.triangle_ids()) triangle_ids.push_back(first_triangle + id);
  const auto leaves = tree.leaves();
  for (const Hierarchy::Node& node : tree.nodes()) {
    const Index leaf = node.leaf_begin;
    leaf_sizes.push_back(node.is_leaf() ? leaves[leaf + 1].triangles - leaves[leaf].triangles : 0);
  }
}

// Faces and codimensional elements have trees of their own below a common root, because a leaf with an
// element that has no area gets no chart.
Result<Hierarchy> build_joined(Topology all, Index face_count, std::span<const double> positions,
                               const HierarchySettings& settings) {
  std::vector<Index> triangle_ids, leaf_sizes;
  const auto triangles = all.triangles();
  const std::span<const Triangle> parts[] = {triangles.first(face_count), triangles.subspan(face_count)};
  if (!parts[0].empty() && !parts[1].empty()) leaf_sizes.push_back(0);
  for (const auto part : parts) {
    if (part.empty()) continue;
    auto topology = FOLDPROOF_TRY(Topology::make(all.vertex_count(), {part.begin(), part.end()}));
    const auto tree = FOLDPROOF_TRY(Hierarchy::build(std::move(topology), positions, settings));
    append_parts(tree, static_cast<Index>(part.data() - triangles.data()), triangle_ids, leaf_sizes);
  }
  return Hierarchy::from_parts(std::move(all), std::move(triangle_ids), leaf_sizes);
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
  mesh.face_count_ = static_cast<Index>(faces.size());
  mesh.is_point_.assign(count, settings.points ? 1 : 0);
  for (const Edge& e : edges) mesh.is_point_[e[0]] = mesh.is_point_[e[1]] = 0;

  std::vector<Triangle> elements = std::move(faces);
  std::vector<Edge> face_edges;
  if (!elements.empty()) {
    const auto surface = FOLDPROOF_TRY(Topology::make(count, elements));
    face_edges.assign(surface.edges().begin(), surface.edges().end());
    for (const Triangle& t : surface.triangles()) {
      for (const Index v : t) mesh.is_point_[v] = 0;
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
    elements.push_back({edges[i][0], edges[i][1], edges[i][1]});
  }
  mesh.edges_ = std::move(edges);
  for (std::size_t k = 0; k < face_edges.size(); ++k) {
    if (!given[k]) mesh.edges_.push_back(face_edges[k]);
  }
  for (Index v = 0; v < count; ++v) {
    if (mesh.is_point_[v] == 0) continue;
    mesh.codim_points_.push_back(v);
    elements.push_back({v, v, v});
  }
  if (elements.empty())
    return fail(ErrorCode::InvalidMesh, "collision mesh", "has nothing that could collide",
                "give faces, edges or points");

  auto all = FOLDPROOF_TRY(Topology::make(count, std::move(elements)));
  mesh.edge_rows_.resize(all.edges().size());
  for (Index row = 0; row < mesh.edges_.size(); ++row)
    mesh.edge_rows_[find_edge(all.edges(), sorted(mesh.edges_[row]))] = row;
  auto tree =
      FOLDPROOF_TRY(build_joined(std::move(all), mesh.face_count_, rest_positions, settings.hierarchy));
  mesh.hierarchy_ = std::make_shared<const Hierarchy>(std::move(tree));
  return mesh;
}

}  // namespace foldproof
