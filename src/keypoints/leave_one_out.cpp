#include "keypoints/least_squares.h"
#include "statistics/span.h"

namespace foldproof {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd without_column(const MatrixXd& matrix, Eigen::Index k) {
  MatrixXd rest(matrix.rows(), matrix.cols() - 1);
  rest.leftCols(k) = matrix.leftCols(k);
  rest.rightCols(rest.cols() - k) = matrix.rightCols(rest.cols() - k);
  return rest;
}

}  // namespace

Result<std::vector<PoseError>> leave_one_out(const MatrixView& samples, const SubspaceSize& size,
                                             std::span<const Index> vertices) {
  if (auto checked = check_columns(samples, "sample"); !checked) return tl::unexpected(checked.error());
  if (auto checked = check_size(size); !checked) return tl::unexpected(checked.error());
  std::vector<PoseError> errors;
  if (samples.cols() < 2) return errors;

  // All samples lie in their span, and so does every subspace of some of them: everything but the
  // lengths at the end is computed in coordinates of the span.
  const Span span = span_of(samples, kAllModes);
  const MatrixXd coordinates = span.values.asDiagonal() * span.scores.transpose();
  const MatrixXd key_rows = rows_of(span.directions, vertices);
  for (Eigen::Index k = 0; k < samples.cols(); ++k) {
    if (span.rank() == 0) {
      errors.push_back({});
      continue;
    }
    const Span rest = span_of(without_column(coordinates, k), size);
    const VectorXd x = coordinates.col(k) - rest.mean;
    const VectorXd best = rest.directions * (rest.directions.transpose() * x);
    const VectorXd shares = shares_of_vertices(span.mean + span.directions * rest.mean, vertices);
    const VectorXd key_point_p = least_squares(key_rows * rest.directions, shares).inverse * (key_rows * x);
    const VectorXd from_key_points = rest.directions * key_point_p;
    MatrixXd fields(x.size(), 3);
    fields << x - best, best - from_key_points, x - from_key_points;
    const MatrixXd at_vertices = span.directions * fields;
    errors.push_back({vertex_lengths(at_vertices.col(0)), vertex_lengths(at_vertices.col(1)),
                      vertex_lengths(at_vertices.col(2))});
  }
  return errors;
}

}  // namespace foldproof
