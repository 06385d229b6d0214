#include "keypoints/leave_one_out.h"

#include "base/try.h"
#include "keypoints/least_squares.h"
#include "statistics/tall_skinny.h"

namespace foldproof::internal {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd without_column(const MatrixXd& matrix, Eigen::Index k) {
  MatrixXd rest(matrix.rows(), matrix.cols() - 1);
  rest.leftCols(k) = matrix.leftCols(k);
  rest.rightCols(rest.cols() - k) = matrix.rightCols(rest.cols() - k);
  return rest;
}

// Per pose, two columns in coordinates of the SVD: its projection error and its cueing error with what the
// other poses give.
MatrixXd error_fields(const MatrixView& samples, const ThinSvd& svd, const SubspaceSize& size,
                      std::span<const Index> vertices) {
  if (svd.rank() == 0) return {0, 2 * samples.cols()};
  const MatrixXd coordinates = svd.values.asDiagonal() * svd.scores.transpose();
  const MatrixXd key_rows = rows_of(svd.directions, vertices);
  const double others = static_cast<double>(samples.cols()) - 1;
  const NearestKeyPoints nearest(svd.mean, vertices);
  MatrixXd fields(svd.rank(), 2 * samples.cols());
  for (Eigen::Index k = 0; k < samples.cols(); ++k) {
    const ThinSvd rest = thin_svd(without_column(coordinates, k), size);
    const VectorXd x = coordinates.col(k) - rest.mean;
    const VectorXd best = rest.directions * (rest.directions.transpose() * x);
    const VectorXd mean = svd.mean + (svd.mean - samples.col(k)) / others;
    const MatrixXd rows = key_rows * rest.directions;
    const VectorXd key_point_p = least_squares(rows, nearest.counts(mean)).inverse * (key_rows * x);
    fields.col(2 * k) = x - best;
    fields.col(2 * k + 1) = best - rest.directions * key_point_p;
  }
  return fields;
}

}  // namespace

std::vector<PoseError> leave_one_out(const MatrixView& samples, const ThinSvd& svd, const SubspaceSize& size,
                                     std::span<const Index> vertices, const ProjectionErrorVisitor& visit) {
  // The samples, and every subspace of some of them, lie in the span of the SVD's directions. So only the
  // distances at the end need whole vertices.
  std::vector<PoseErrorSum> sums(static_cast<std::size_t>(samples.cols()));
  const MatrixXd fields = error_fields(samples, svd, size, vertices);
  const Eigen::Index step = 3 * block_rows(3 * fields.cols());
  for (Eigen::Index first = 0; first < samples.rows(); first += step) {
    const Eigen::Index rows = std::min(step, samples.rows() - first);
    const MatrixXd at_vertices = tall_skinny_product(svd.directions.middleRows(first, rows), fields);
    for (Eigen::Index k = 0; k < samples.cols(); ++k) {
      const VectorXd distances = sums[static_cast<std::size_t>(k)].add(
          static_cast<Index>(first / 3), at_vertices.col(2 * k), at_vertices.col(2 * k + 1));
      if (visit) visit(k, static_cast<Index>(first / 3), distances);
    }
  }
  std::vector<PoseError> errors;
  errors.reserve(sums.size());
  for (const PoseErrorSum& sum : sums) errors.push_back(sum.result());
  return errors;
}

}  // namespace foldproof::internal
