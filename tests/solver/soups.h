/// Codimensional soups, and all pairs of their features by brute force.
#pragma once

#include <algorithm>
#include <set>

#include "foldproof/solver.h"
#include "oracle/families.h"

namespace foldproof::oracle {

/// Faces, edges without a face and points, with both ends of a step.
struct Soup {
  std::vector<Edge> edges;
  std::vector<Triangle> faces;
  std::vector<double> x0, x1;
  Index vertex_count() const { return static_cast<Index>(x0.size() / 3); }
};

/// The kinds of two features.
enum class Features { VertexFace, EdgeEdge, EdgeVertex, VertexVertex };

/// Two features: their ids as in Candidates, and their vertices as the narrow phase and the oracle take them.
struct FeaturePair {
  Features features;
  std::array<Index, 2> ids;
  std::array<Index, 4> vertices;
  Kind kind() const { return features == Features::EdgeEdge ? Kind::EdgeEdge : Kind::VertexFace; }
  FourPoints at(std::span<const double> x) const {
    FourPoints p;
    for (int k = 0; k < 4; ++k)
      p[k] = Vec3(x[3 * vertices[k]], x[3 * vertices[k] + 1], x[3 * vertices[k] + 2]);
    return p;
  }
  auto key() const { return std::pair(features, ids); }
};

/// Whether features with these vertices may collide, as CollisionFilter documents it.
template <class CanCollide>
bool may_collide(std::span<const Index> a, std::span<const Index> b, CanCollide can_collide) {
  bool any = false;
  for (const Index i : a) {
    for (const Index j : b) {
      if (i == j) return false;
      any = any || can_collide(i, j);
    }
  }
  return any;
}

/// Every relevant pair: from index matrices, without CollisionMesh. `edges` holds those of faces too.
template <class CanCollide>
std::vector<FeaturePair> all_pairs(const Soup& soup, std::span<const Edge> edges, CanCollide can_collide) {
  std::set<Index> with_edge;
  std::set<std::set<Index>> face_edges;
  for (const Triangle& t : soup.faces) {
    with_edge.insert(t.begin(), t.end());
    for (int k = 0; k < 3; ++k) face_edges.insert({t[k], t[(k + 1) % 3]});
  }
  for (const Edge& e : edges) with_edge.insert(e.begin(), e.end());
  std::vector<FeaturePair> pairs;
  const auto add = [&](Features features, std::array<Index, 2> ids, std::span<const Index> a,
                       std::span<const Index> b, std::array<Index, 4> vertices) {
    if (may_collide(a, b, can_collide)) pairs.push_back({features, ids, vertices});
  };
  const auto one = [](const Index& v) { return std::span(&v, 1); };
  for (Index v = 0; v < soup.vertex_count(); ++v) {
    for (Index f = 0; f < soup.faces.size(); ++f) {
      const Triangle& t = soup.faces[f];
      add(Features::VertexFace, {v, f}, one(v), t, {v, t[0], t[1], t[2]});
    }
    if (with_edge.contains(v)) continue;
    for (Index e = 0; e < edges.size(); ++e) {
      const Edge& s = edges[e];
      if (face_edges.contains({s[0], s[1]})) continue;
      add(Features::EdgeVertex, {e, v}, one(v), s, {v, s[0], s[1], s[1]});
    }
    for (Index w = v + 1; w < soup.vertex_count(); ++w) {
      if (!with_edge.contains(w)) add(Features::VertexVertex, {v, w}, one(v), one(w), {v, w, w, w});
    }
  }
  for (Index a = 0; a < edges.size(); ++a) {
    for (Index b = a + 1; b < edges.size(); ++b) {
      // In the library's order, on which the last digits of a time of impact depend.
      Edge e = {std::min(edges[a][0], edges[a][1]), std::max(edges[a][0], edges[a][1])};
      Edge g = {std::min(edges[b][0], edges[b][1]), std::max(edges[b][0], edges[b][1])};
      if (g < e) std::swap(e, g);
      add(Features::EdgeEdge, {a, b}, e, g, {e[0], e[1], g[0], g[1]});
    }
  }
  return pairs;
}

/// Whether no axis separates the boxes of the two features by more than `inflation`, on the same side at both
/// ends.
inline bool boxes_within(const FeaturePair& pair, std::span<const double> x0, std::span<const double> x1,
                         double inflation) {
  const int first = pair.kind() == Kind::EdgeEdge ? 2 : 1;  // number of points of the first feature
  const auto gap = [&](std::span<const double> x, int axis, bool above) {
    double low[2], high[2];
    for (int k = 0; k < 4; ++k) {
      const double v = x[3 * pair.vertices[k] + axis];
      const int which = k < first ? 0 : 1;
      const bool is_first = k == 0 || k == first;
      low[which] = is_first ? v : std::min(low[which], v);
      high[which] = is_first ? v : std::max(high[which], v);
    }
    return above ? low[0] - high[1] : low[1] - high[0];
  };
  for (int axis = 0; axis < 3; ++axis) {
    for (const bool above : {false, true}) {
      if (gap(x0, axis, above) > inflation && gap(x1, axis, above) > inflation) return false;
    }
  }
  return true;
}

inline bool all_may(Index, Index) { return true; }

/// Small elements in a box that move independently; coordinates are multiples of `grid`.
inline Soup random_soup(Rng& rng, int faces, int edges, int points, double speed, double grid) {
  std::uniform_real_distribution<double> center(0, 1), offset(-0.15, 0.15), velocity(-speed, speed);
  Soup soup;
  const auto round = [&](double v) { return std::round(v / grid) * grid; };
  const auto element = [&](int corners) {
    const Vec3 at(center(rng), center(rng), center(rng)), move(velocity(rng), velocity(rng), velocity(rng));
    for (int k = 0; k < corners; ++k) {
      for (int axis = 0; axis < 3; ++axis) {
        const double x = round(at[axis] + offset(rng));
        soup.x0.push_back(x);
        soup.x1.push_back(round(x + move[axis] + speed * offset(rng)));
      }
    }
    return soup.vertex_count() - static_cast<Index>(corners);
  };
  for (int k = 0; k < faces; ++k) {
    const Index v = element(3);
    soup.faces.push_back({v, v + 1, v + 2});
  }
  for (int k = 0; k < edges; ++k) {
    const Index v = element(2);
    soup.edges.push_back({v + 1, v});
    if (k % 3 == 0 && v >= 2) soup.edges.push_back({v, v - 2});  // a rod, or an edge off a face
  }
  for (int k = 0; k < points; ++k) element(1);
  return soup;
}

/// Two wavy sheets of 40 x 40 cells, 0.2 apart, at rest.
inline Soup two_sheets() {
  constexpr int kCells = 40;
  Soup soup;
  for (const double z : {0.0, 0.2}) {
    for (int i = 0; i <= kCells; ++i) {
      for (int k = 0; k <= kCells; ++k) {
        const double u = double(i) / kCells, v = double(k) / kCells;
        soup.x0.insert(soup.x0.end(), {u, v, z + 0.05 * std::sin(7 * u) * std::cos(5 * v)});
        if (i == 0 || k == 0) continue;
        const Index d = soup.vertex_count() - 1, c = d - 1, b = d - kCells - 1, a = b - 1;
        soup.faces.push_back({a, b, d});
        soup.faces.push_back({a, d, c});
      }
    }
  }
  soup.x1 = soup.x0;
  return soup;
}

inline CollisionMesh mesh_of(const Soup& soup, CollisionFilter filter = {}, Index leaf_triangles = 4) {
  CollisionMeshSettings settings;
  settings.filter = std::move(filter);
  settings.hierarchy.leaf_triangles = leaf_triangles;
  auto mesh = CollisionMesh::make(soup.x0, soup.edges, soup.faces, settings);
  if (!mesh) throw std::runtime_error(mesh.error().line());
  return std::move(*mesh);
}

/// The pairs of an answer, each with the kinds of its features.
inline std::set<std::pair<Features, std::array<Index, 2>>> keys_of(const Candidates& c) {
  std::set<std::pair<Features, std::array<Index, 2>>> keys;
  for (const auto& p : c.vertex_face) keys.insert({Features::VertexFace, {p.vertex, p.face}});
  for (const auto& p : c.edge_edge) keys.insert({Features::EdgeEdge, {p.edge_a, p.edge_b}});
  for (const auto& p : c.edge_vertex) keys.insert({Features::EdgeVertex, {p.edge, p.vertex}});
  for (const auto& p : c.vertex_vertex) keys.insert({Features::VertexVertex, {p.vertex_a, p.vertex_b}});
  return keys;
}

}  // namespace foldproof::oracle
