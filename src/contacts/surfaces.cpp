#include "contacts/surfaces.h"

#include <algorithm>
#include <map>

namespace foldproof::internal {

Surfaces::Surfaces(std::vector<const Topology*> topologies) : topologies_(std::move(topologies)) {
  std::map<const Topology*, std::shared_ptr<const Stars>> known;
  vertex_offsets_.push_back(0);
  triangle_offsets_.push_back(0);
  for (const Topology* topology : topologies_) {
    auto& stars = known[topology];
    if (!stars) stars = std::make_shared<const Stars>(*topology);
    stars_.push_back(stars);
    vertex_offsets_.push_back(vertex_offsets_.back() + topology->vertex_count());
    triangle_offsets_.push_back(triangle_offsets_.back() + static_cast<Index>(topology->triangles().size()));
  }
}

Surfaces::Stars::Stars(const Topology& topology) : shells(topology) {
  const auto triangles = topology.triangles();
  const auto for_each_corner = [&](auto visit) {
    for (Index t = 0; t < triangles.size(); ++t) {
      const auto& [a, b, c] = triangles[t];
      visit(t, a);
      if (b != a) visit(t, b);
      if (c != a && c != b) visit(t, c);
    }
  };
  begin.assign(std::size_t{topology.vertex_count()} + 1, 0);
  for_each_corner([&](Index, Index v) { ++begin[v + 1]; });
  for (Index v = 0; v < topology.vertex_count(); ++v) begin[v + 1] += begin[v];
  this->triangles.resize(begin.back());
  std::vector<Index> next(begin.begin(), begin.end() - 1);
  for_each_corner([&](Index t, Index v) { this->triangles[next[v]++] = t; });
  list_neighbors(topology);
  std::vector<Index> at_edge(topology.edges().size(), 0);
  for (const auto& edges : topology.triangle_edges()) {
    for (const Index edge : edges) {
      if (edge != kNoIndex) most_at_edge = std::max(most_at_edge, ++at_edge[edge]);
    }
  }
}

void Surfaces::Stars::list_neighbors(const Topology& topology) {
  const Index vertices = topology.vertex_count();
  neighbors_begin.assign(std::size_t{vertices} + 1, 0);
  for (const Edge& edge : topology.edges()) {
    for (const Index v : edge) ++neighbors_begin[v + 1];
  }
  const auto rank = [&](Index v) { return std::pair(neighbors_begin[v + 1], v); };
  std::vector<Edge> edges(topology.edges().begin(), topology.edges().end());  // the lower vertex first
  std::vector<Index> lower(vertices, 0);
  for (auto& [low, high] : edges) {
    if (rank(high) < rank(low)) std::swap(low, high);
    ++lower[high];
  }
  higher_begin.resize(vertices);
  for (Index v = 0; v < vertices; ++v) {
    neighbors_begin[v + 1] += neighbors_begin[v];
    higher_begin[v] = neighbors_begin[v] + lower[v];
  }
  neighbors.resize(neighbors_begin.back());
  std::vector<Index> next_lower(neighbors_begin.begin(), neighbors_begin.end() - 1),
      next_higher = higher_begin;
  for (const auto& [low, high] : edges) {
    neighbors[next_higher[low]++] = high;
    neighbors[next_lower[high]++] = low;
  }
}

// Calls visit(triangle) with the triangles that have an edge, ascending, until it returns false.
template <class Visit>
void Surfaces::for_each_with_edge(Index object, const Edge& edge, const Visit& visit) const {
  const auto triangles = topologies_[object]->triangles();
  const auto at_0 = triangles_at(object, edge[0]), at_1 = triangles_at(object, edge[1]);
  const bool first = at_0.size() <= at_1.size();
  const Index other = edge[first ? 1 : 0];
  for (const Index t : first ? at_0 : at_1) {
    const auto& [a, b, c] = triangles[t];
    if ((a == other || b == other || c == other) && !visit(t)) return;
  }
}

void Surfaces::triangles_with_edge(Index object, const Edge& edge, std::vector<Index>& out) const {
  out.clear();
  for_each_with_edge(object, edge, [&](Index t) { return out.push_back(t), true; });
}

bool Surfaces::is_of_face(Index object, const Edge& edge) const {
  const Topology& topology = *topologies_[object];
  bool is = topology.face_count() == topology.triangles().size();
  if (!is) for_each_with_edge(object, edge, [&](Index t) { return is = is_face(object, t), false; });
  return is;
}

}  // namespace foldproof::internal
