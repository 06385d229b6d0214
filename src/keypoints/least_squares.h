/// Rows of key points, and the solution of Eq. 2.
#pragma once

#include "foldproof/keypoints.h"

namespace foldproof {

/// The three rows of each vertex.
Eigen::MatrixXd rows_of(const MatrixView& matrix, std::span<const Index> vertices);

/// Per key point, how many vertices of a pose are nearer to it than to any other; itself always.
Eigen::VectorXd shares_of_vertices(const VectorView& pose, std::span<const Index> vertices);

/// p = inverse b minimises sum_k shares_k |(rows p - b)_k|^2 over key points k, with a ridge when the rows do
/// not determine p.
struct LeastSquares {
  Eigen::MatrixXd inverse;
  bool rank_deficient = false;
};
LeastSquares least_squares(const Eigen::MatrixXd& rows, const Eigen::VectorXd& shares);

/// Lengths of a vector field, one 3-vector per vertex.
VertexDistance vertex_lengths(const VectorView& field);

}  // namespace foldproof
