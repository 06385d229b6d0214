#include "keypoints/leave_one_out.h"

#include "keypoints/least_squares.h"
#include "statistics/tall.h"

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

// Per pose two columns in coordinates of the span: what its rebuild by the others misses, and what that
// rebuild's key points add to it.
MatrixXd missed_fields(const MatrixView& samples, const Span& span, const SubspaceSize& size,
                       std::span<const Index> vertices) {
  if (span.rank() == 0) return {0, 2 * samples.cols()};
  const MatrixXd coordinates = span.values.asDiagonal() * span.scores.transpose();
  const MatrixXd key_rows = rows_of(span.directions, vertices);
  const double others = static_cast<double>(samples.cols()) - 1;
  NearestKeyPoints nearest(span.mean, vertices);
  MatrixXd fields(span.rank(), 2 * samples.cols());
  for (Eigen::Index k = 0; k < samples.cols(); ++k) {
    const Span rest = span_of(without_column(coordinates, k), size);
    const VectorXd x = coordinates.col(k) - rest.mean;
    const VectorXd best = rest.directions * (rest.directions.transpose() * x);
    const VectorXd mean = span.mean + (span.mean - samples.col(k)) / others;
    const MatrixXd rows = key_rows * rest.directions;
    const VectorXd key_point_p = least_squares(rows, nearest.shares(mean)).inverse * (key_rows * x);
    fields.col(2 * k) = x - best;
    fields.col(2 * k + 1) = best - rest.directions * key_point_p;
  }
  return fields;
}

}  // namespace

std::vector<PoseError> leave_one_out(const MatrixView& samples, const Span& span, const SubspaceSize& size,
                                     std::span<const Index> vertices, const SeeMissed& see_missed) {
  // All samples lie in their span, and so does every subspace of some of them: everything but the lengths at
  // the end is computed in coordinates of the span.
  std::vector<FieldError> errors(static_cast<std::size_t>(samples.cols()));
  const MatrixXd fields = missed_fields(samples, span, size, vertices);
  const Eigen::Index step = 3 * rows_at_a_time(3 * fields.cols());
  for (Eigen::Index first = 0; first < samples.rows(); first += step) {
    const Eigen::Index rows = std::min(step, samples.rows() - first);
    const MatrixXd at_vertices = tall_product(span.directions.middleRows(first, rows), fields);
    for (Eigen::Index k = 0; k < samples.cols(); ++k) {
      const VectorXd missed = errors[static_cast<std::size_t>(k)].add(
          static_cast<Index>(first / 3), at_vertices.col(2 * k), at_vertices.col(2 * k + 1));
      if (see_missed) see_missed(k, static_cast<Index>(first / 3), missed);
    }
  }
  std::vector<PoseError> found;
  found.reserve(errors.size());
  for (const FieldError& error : errors) found.push_back(error.take());
  return found;
}

Result<std::vector<PoseError>> leave_one_out(const MatrixView& samples, const SubspaceSize& size,
                                             std::span<const Index> vertices) {
  if (auto checked = check_columns(samples, "sample"); !checked) return tl::unexpected(checked.error());
  if (auto checked = check_size(size); !checked) return tl::unexpected(checked.error());
  if (samples.cols() < 2) return std::vector<PoseError>{};
  return leave_one_out(samples, span_of(samples, kAllModes), size, vertices);
}

}  // namespace foldproof
