/// Rows of key points, and the solution of Eq. 2.
#pragma once

#include "foldproof/keypoints.h"

namespace foldproof {

/// The three rows of each vertex.
Eigen::MatrixXd rows_of(const MatrixView& matrix, std::span<const Index> vertices);

/// Per key point, how many vertices of a pose are nearer to it than to any other; itself always.
Eigen::VectorXd shares_of_vertices(const VectorView& pose, std::span<const Index> vertices);

/// The same in poses that resemble each other: what was nearest in the first is a good guess in the others.
class NearestKeyPoints {
 public:
  NearestKeyPoints(const VectorView& pose, std::span<const Index> vertices);
  Eigen::VectorXd shares(const VectorView& pose) const;

 private:
  std::span<const Index> vertices_;
  std::vector<Index> nearest_;  // per vertex: a place in vertices_
};

/// p = inverse b minimises sum_k shares_k |(rows p - b)_k|^2 over key points k, with a ridge when the rows do
/// not determine p.
struct LeastSquares {
  Eigen::MatrixXd inverse;
  bool rank_deficient = false;
};
LeastSquares least_squares(const Eigen::MatrixXd& rows, const Eigen::VectorXd& shares);

/// Lengths of a vector field, one 3-vector per vertex.
VertexDistance vertex_lengths(const VectorView& field);

/// PoseError of two fields, what the subspace misses and what key points add, seen a run of vertices at a
/// time.
class FieldError {
 public:
  /// 3-vectors of the vertices from `first` on, the run behind the last one. Returns the lengths of `missed`.
  Eigen::VectorXd add(Index first, const VectorView& missed, const VectorView& cueing);
  PoseError take() const;

 private:
  PoseError sums_;  // means: sums so far
  Index vertices_ = 0;
};

}  // namespace foldproof
