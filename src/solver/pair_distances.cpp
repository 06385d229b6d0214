#include "solver/pair_distances.h"

#include <algorithm>
#include <bit>

namespace foldproof::internal {
namespace {

// Vertices with the weights that a feature's closest point gives them, those of weight 0 left out.
struct Support {
  Index vertices[3] = {};
  double weights[3] = {};
  int size = 0;

  void add(Index vertex, double weight) {
    if (!(weight > 0)) return;
    for (int k = 0; k < size; ++k) {
      if (vertices[k] != vertex) continue;  // a line or point is a triangle that names a vertex twice
      weights[k] += weight;
      return;
    }
    vertices[size] = vertex;
    weights[size++] = weight;
  }
};

// The weights of a triangle's corners, or of the ends of both edges.
std::array<double, 4> weights_of(const NearestBatch& nearest, int lane, bool edge_edge) {
  const double u = nearest.u[lane], v = nearest.v[lane];
  switch (static_cast<int>(nearest.side[lane])) {
    case 0:
      return edge_edge ? std::array{1 - u, u, 1.0, 0.0} : std::array{1 - u, u, 0.0, 0.0};
    case 1:
      return edge_edge ? std::array{1.0, 0.0, 1 - u, u} : std::array{1 - u, 0.0, u, 0.0};
    case 2:
      return edge_edge ? std::array{0.0, 1.0, 1 - u, u} : std::array{0.0, 1 - u, u, 0.0};
    case 3:
      return {1 - u, u, 0, 1};
    default:
      return edge_edge ? std::array{1 - u, u, 1 - v, v} : std::array{1 - u - v, u, v, 0.0};
  }
}

// The smaller id first, where the order is free.
void sort_support(Support& support) {
  if (support.size != 2 || support.vertices[0] < support.vertices[1]) return;
  std::swap(support.vertices[0], support.vertices[1]);
  std::swap(support.weights[0], support.weights[1]);
}

// 0 unless the edges are nearly parallel; as in ipc-toolkit.
double mollifier_threshold(const PosedFeatures& features, BoxPair pair) {
  const auto row = [&](Index edge) {
    return features.mesh.edge_row(features.hierarchy().edge_ids()[edge - features.edges_begin()]);
  };
  const double threshold =
      1e-3 * features.mesh.squared_rest_length(row(pair.a)) * features.mesh.squared_rest_length(row(pair.b));
  const std::array<Index, 4> corners = features.corners(pair);
  const auto at = [&](int k) { return Vec3::load(features.points[corners[k]].x[0]); };
  return (at(1) - at(0)).cross(at(3) - at(2)).squaredNorm() < threshold ? threshold : 0;
}

}  // namespace

ClosePair close_pair(const std::array<Index, 4>& ids, bool edge_edge, const NearestBatch& nearest, int lane,
                     double mollifier_threshold) {
  const std::array<double, 4> weights = weights_of(nearest, lane, edge_edge);
  ClosePair close;
  close.distance = nearest.distance[lane];
  close.normal = Vec3(nearest.normal[0][lane], nearest.normal[1][lane], nearest.normal[2][lane]);
  close.mollifier_threshold = mollifier_threshold;
  if (edge_edge &&
      (mollifier_threshold > 0 || std::ranges::all_of(weights, [](double w) { return w > 0; }))) {
    close.kind = ClosePair::Kind::EdgeEdge;
    close.vertices = ids;
    close.weights = {weights[0], weights[1], -weights[2], -weights[3]};
    return close;
  }
  Support a, b;
  if (edge_edge) {
    for (int k = 0; k < 2; ++k) {
      a.add(ids[k], weights[k]);
      b.add(ids[2 + k], weights[2 + k]);
    }
  } else {
    a.add(ids[0], 1);
    for (int k = 0; k < 3; ++k) b.add(ids[1 + k], weights[k]);
  }
  if (a.size > 1 || (b.size == 1 && b.vertices[0] < a.vertices[0])) {
    std::swap(a, b);
    close.normal = -close.normal;
  }
  sort_support(b);
  close.kind = static_cast<ClosePair::Kind>(b.size - 1);
  close.vertices.fill(b.vertices[b.size - 1]);
  close.vertices[0] = a.vertices[0];
  close.weights[0] = 1;
  for (int k = 0; k < b.size; ++k) {
    close.vertices[1 + k] = b.vertices[k];
    close.weights[1 + k] = -b.weights[k];
  }
  return close;
}

ClosePair close_pair(const PosedFeatures& features, BoxPair pair, const NearestBatch& nearest, int lane) {
  std::array<Index, 4> ids = features.corners(pair);
  for (Index& id : ids) id = features.hierarchy().vertex_ids()[id];
  const bool edge_edge = features.is_edge_edge(pair);
  return close_pair(ids, edge_edge, nearest, lane, edge_edge ? mollifier_threshold(features, pair) : 0);
}

void merge_close_pairs(std::vector<ClosePair>& pairs, std::vector<Index>& table) {
  const auto is_reduced = [](const ClosePair& pair) { return pair.kind < ClosePair::Kind::VertexFace; };
  const auto reduced = static_cast<std::size_t>(std::ranges::count_if(pairs, is_reduced));
  table.assign(std::bit_ceil(2 * reduced + 1), kNoIndex);  // open addressing
  Index size = 0;
  for (const ClosePair& pair : pairs) {
    bool is_new = true;
    if (is_reduced(pair)) {
      std::uint64_t hash = 0;
      for (int k = 0; k < 3; ++k) hash = (hash ^ pair.vertices[k]) * 0x9e3779b97f4a7c15;
      std::size_t slot = hash >> 32 & (table.size() - 1);
      while (table[slot] != kNoIndex && pairs[table[slot]].vertices != pair.vertices)
        slot = (slot + 1) & (table.size() - 1);
      is_new = table[slot] == kNoIndex;
      if (is_new)
        table[slot] = size;
      else
        ++pairs[table[slot]].count;
    }
    if (is_new) pairs[size++] = pair;
  }
  pairs.resize(size);
}

}  // namespace foldproof::internal
