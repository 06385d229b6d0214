#include "keypoints/least_squares.h"

namespace foldproof {

using Eigen::VectorXd;

KeyPointMap::KeyPointMap(const Pca& subspace, std::span<const Index> vertices)
    : vertices_(vertices.begin(), vertices.end()), mean_(gather(subspace.mean)) {
  LeastSquares solved =
      least_squares(rows_of(subspace.basis, vertices_), nearest_counts(subspace.mean, vertices_));
  inverse_ = std::move(solved.inverse);
  rank_deficient_ = solved.rank_deficient;
}

VectorXd KeyPointMap::gather(const VectorView& x) const { return rows_of(x, vertices_); }

VectorXd KeyPointMap::coordinates(const VectorView& key_positions) const {
  return inverse_ * (key_positions - mean_);
}

VertexDistance vertex_distance(const VectorView& a, const VectorView& b) { return vertex_lengths(a - b); }

}  // namespace foldproof
