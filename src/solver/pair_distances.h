/// Closest points of pairs of features in a pose, eight pairs at a time.
#pragma once

#include <span>

#include "ccd/conservative_advancement.h"
#include "ccd/nearest_points.h"
#include "foldproof/solver.h"
#include "solver/near_boxes.h"

namespace foldproof::inline internal {

/// The features of a mesh in a pose: vertices, then edges, then triangles, each in leaf order.
struct PosedFeatures {
  const CollisionMesh& mesh;
  std::span<const PointAtEnds<1>> points;

  const Hierarchy& hierarchy() const { return *mesh.hierarchy(); }
  Index edges_begin() const { return static_cast<Index>(points.size()); }
  Index triangles_begin() const { return edges_begin() + static_cast<Index>(hierarchy().edges().size()); }
  bool is_edge(Index feature) const { return feature >= edges_begin() && feature < triangles_begin(); }
  bool is_edge_edge(BoxPair pair) const { return is_edge(pair.a) && is_edge(pair.b); }
  /// The four points of a pair, as FourPoints has them. Of an edge and a point, either may be first.
  std::array<Index, 4> corners(BoxPair pair) const {
    if (is_edge_edge(pair)) {
      const Edge &a = edge(pair.a), &b = edge(pair.b);
      return {a[0], a[1], b[0], b[1]};
    }
    const auto [vertex, other] = pair.b < edges_begin() ? BoxPair{pair.b, pair.a} : pair;
    if (other >= triangles_begin()) {
      const Triangle& t = hierarchy().triangles()[other - triangles_begin()];
      return {vertex, t[0], t[1], t[2]};
    }
    if (other < edges_begin()) return {vertex, other, other, other};
    return {vertex, edge(other)[0], edge(other)[1], edge(other)[1]};
  }

 private:
  const Edge& edge(Index feature) const { return hierarchy().edges()[feature - edges_begin()]; }
};

/// Calls visit(pair, nearest, lane) for each pair that is not proven farther apart than distance(), which is
/// asked again and again. The pairs are all of edges, or none is.
template <class Distance, class Visit>
void visit_distances(const PosedFeatures& features, std::span<const BoxPair> pairs, Distance distance,
                     Visit visit) {
  if (pairs.empty()) return;
  const bool edge_edge = features.is_edge_edge(pairs[0]);
  PairBatch batch{}, near_batch{};
  BoxPair near[8];
  NearestBatch nearest;
  int count = 0;
  const auto measure = [&] {
    for (unsigned left = nearest_points(near_batch, count, edge_edge, distance(), nearest); left != 0;
         left &= left - 1)
      visit(near[__builtin_ctz(left)], nearest, __builtin_ctz(left));
    count = 0;
  };
  const auto load = [](const double* x, int k, int lane, PairBatch& to) {
    for (int axis = 0; axis < 3; ++axis) to.x[0][k][axis][lane] = x[axis];
  };
  for (std::size_t first = 0; first < pairs.size(); first += 8) {
    const auto some = pairs.subspan(first, std::min<std::size_t>(8, pairs.size() - first));
    for (std::size_t lane = 0; lane < some.size(); ++lane) {
      const std::array<Index, 4> corners = features.corners(some[lane]);
      for (int k = 0; k < 4; ++k) load(features.points[corners[k]].x[0], k, static_cast<int>(lane), batch);
    }
    for (unsigned left = maybe_near(batch, static_cast<int>(some.size()), edge_edge, distance()); left != 0;
         left &= left - 1) {
      const int lane = __builtin_ctz(left);
      near[count] = some[lane];
      for (int k = 0; k < 4; ++k) {
        for (int axis = 0; axis < 3; ++axis) near_batch.x[0][k][axis][count] = batch.x[0][k][axis][lane];
      }
      if (++count == 8) measure();
    }
  }
  if (count > 0) measure();
}

/// What is nearest of a pair whose four vertices have these ids, with a count of 1.
ClosePair close_pair(const std::array<Index, 4>& ids, bool edge_edge, const NearestBatch& nearest, int lane,
                     double mollifier_threshold = 0);
/// The same of a pair that visit_distances visits.
ClosePair close_pair(const PosedFeatures& features, BoxPair pair, const NearestBatch& nearest, int lane);

/// Removes pairs whose closest features are those of an earlier one, which counts them. `table` is scratch.
void merge_close_pairs(std::vector<ClosePair>& pairs, std::vector<Index>& table);

}  // namespace foldproof::inline internal
