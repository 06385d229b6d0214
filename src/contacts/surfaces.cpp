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
    if (!stars) stars = stars_of(*topology);
    stars_.push_back(stars);
    vertex_offsets_.push_back(vertex_offsets_.back() + topology->vertex_count());
    triangle_offsets_.push_back(triangle_offsets_.back() + static_cast<Index>(topology->triangles().size()));
  }
}

std::shared_ptr<const Surfaces::Stars> Surfaces::stars_of(const Topology& topology) {
  const auto stars = std::make_shared<Stars>();
  const auto triangles = topology.triangles();
  const auto for_each_corner = [&](auto visit) {
    for (Index t = 0; t < triangles.size(); ++t) {
      const auto& [a, b, c] = triangles[t];
      visit(t, a);
      if (b != a) visit(t, b);
      if (c != a && c != b) visit(t, c);
    }
  };
  stars->begin.assign(std::size_t{topology.vertex_count()} + 1, 0);
  for_each_corner([&](Index, Index v) { ++stars->begin[v + 1]; });
  for (Index v = 0; v < topology.vertex_count(); ++v) stars->begin[v + 1] += stars->begin[v];
  stars->triangles.resize(stars->begin.back());
  std::vector<Index> next(stars->begin.begin(), stars->begin.end() - 1);
  for_each_corner([&](Index t, Index v) { stars->triangles[next[v]++] = t; });
  return stars;
}

void Surfaces::triangles_with_edge(Index object, const Edge& edge, std::vector<Index>& out) const {
  out.clear();
  const auto triangles = topologies_[object]->triangles();
  for (const Index t : triangles_at(object, edge[0])) {
    if (std::find(triangles[t].begin(), triangles[t].end(), edge[1]) != triangles[t].end()) out.push_back(t);
  }
}

bool Surfaces::is_of_face(Index object, const Edge& edge) const {
  const Topology& topology = *topologies_[object];
  if (topology.face_count() == topology.triangles().size()) return true;
  const auto has_edge = [&](Index t) {
    const Triangle& corners = topology.triangles()[t];
    return std::find(corners.begin(), corners.end(), edge[1]) != corners.end();
  };
  const auto at = triangles_at(object, edge[0]);
  return is_face(object, *std::find_if(at.begin(), at.end(), has_edge));
}

}  // namespace foldproof::internal
