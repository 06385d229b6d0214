/// Rows of key points, and the solution of Eq. 2.
#pragma once

#include "foldproof/keypoints.h"

namespace foldproof {

/// The three rows of each vertex.
Eigen::MatrixXd rows_of(const MatrixView& matrix, std::span<const Index> vertices);

/// p = inverse b minimises |rows p - b|^2, with a ridge when the rows do not determine p.
struct LeastSquares {
  Eigen::MatrixXd inverse;
  bool rank_deficient = false;
};
LeastSquares least_squares(const Eigen::MatrixXd& rows);

/// Lengths of a vector field, one 3-vector per vertex.
VertexDistance vertex_lengths(const VectorView& field);

}  // namespace foldproof
