/// The least-squares problem of Eq. 2, and reconstruction errors.
#pragma once

#include "foldproof/keypoints.h"

namespace foldproof::inline internal {

/// The three rows of each vertex.
Eigen::MatrixXd rows_of(const MatrixView& matrix, std::span<const Index> vertices);

/// Per key point, how many vertices of a pose are nearest to it: at least 1.
Eigen::VectorXd nearest_counts(const VectorView& pose, std::span<const Index> vertices);

/// nearest_counts of several similar poses: what is nearest in the first is the guess in the others.
class NearestKeyPoints {
 public:
  NearestKeyPoints(const VectorView& pose, std::span<const Index> vertices);
  Eigen::VectorXd counts(const VectorView& pose) const;

 private:
  std::span<const Index> vertices_;
  std::vector<Index> nearest_;  // per vertex, an index into vertices_
};

/// p = inverse b minimizes sum_k weights_k |(rows p - b)_k|^2 over key points k, with a ridge when the rows
/// do not determine p.
struct LeastSquares {
  Eigen::MatrixXd inverse;
  bool rank_deficient = false;
};
LeastSquares least_squares(const Eigen::MatrixXd& rows, const Eigen::VectorXd& weights);

/// Lengths of a vector field, one 3-vector per vertex.
VertexDistance vertex_lengths(const VectorView& field);

/// Accumulates the PoseError of two vector fields, block by block.
class PoseErrorSum {
 public:
  /// `projection`, `cueing`: 3-vectors of the vertices from `first` on, which is where the last block ended.
  /// Returns the lengths of `projection`.
  Eigen::VectorXd add(Index first, const VectorView& projection, const VectorView& cueing);
  PoseError result() const;

 private:
  PoseError sums_;  // with sums in place of means
  Index vertices_ = 0;
};

}  // namespace foldproof::inline internal
