#include "keypoints/least_squares.h"

#include <Eigen/SVD>
#include <cassert>

namespace foldproof {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double kSeen = 1e-4;  // Of the largest singular value: what key points must see of every mode.

}  // namespace

MatrixXd rows_of(const MatrixView& matrix, std::span<const Index> vertices) {
  MatrixXd rows(3 * static_cast<Eigen::Index>(vertices.size()), matrix.cols());
  for (std::size_t k = 0; k < vertices.size(); ++k) {
    assert(3 * static_cast<Eigen::Index>(vertices[k]) + 2 < matrix.rows());
    rows.middleRows<3>(3 * static_cast<Eigen::Index>(k)) =
        matrix.middleRows<3>(3 * static_cast<Eigen::Index>(vertices[k]));
  }
  return rows;
}

LeastSquares least_squares(const MatrixXd& rows) {
  const Eigen::Index modes = rows.cols();
  if (modes == 0 || rows.rows() == 0) return {MatrixXd::Zero(modes, rows.rows()), modes > 0};
  const Eigen::JacobiSVD<MatrixXd> svd(rows, Eigen::ComputeThinU | Eigen::ComputeThinV);
  const VectorXd& values = svd.singularValues();
  LeastSquares solved;
  solved.rank_deficient = rows.rows() < modes || !(values.minCoeff() > kSeen * values[0]);
  if (!(values[0] > 0)) return {MatrixXd::Zero(modes, rows.rows()), true};
  const double ridge = solved.rank_deficient ? kSeen * values[0] * kSeen * values[0] : 0;
  const VectorXd inverted = values.array() / (values.array().square() + ridge);
  solved.inverse = svd.matrixV() * inverted.asDiagonal() * svd.matrixU().transpose();
  return solved;
}

VertexDistance vertex_lengths(const VectorView& field) {
  const Eigen::Index vertices = field.size() / 3;
  if (vertices == 0) return {};
  const Eigen::Map<const MatrixXd> vectors(field.data(), 3, vertices);
  const VectorXd lengths = vectors.colwise().norm();
  Eigen::Index worst = 0;
  VertexDistance distance;
  distance.worst = lengths.maxCoeff(&worst);
  distance.worst_vertex = static_cast<Index>(worst);
  distance.mean = lengths.mean();
  return distance;
}

}  // namespace foldproof
