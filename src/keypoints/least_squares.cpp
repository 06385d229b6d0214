#include "keypoints/least_squares.h"

#include <Eigen/SVD>
#include <cassert>
#include <nanoflann.hpp>

namespace foldproof {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double kSeen = 1e-4;  // Of the largest singular value: what key points must see of every mode.

// Some vertices of a pose, as nanoflann wants to see points.
struct KeyPositions {
  const VectorView& pose;
  std::span<const Index> vertices;

  std::size_t kdtree_get_point_count() const { return vertices.size(); }
  double kdtree_get_pt(std::size_t k, std::size_t axis) const {
    return pose[3 * static_cast<Eigen::Index>(vertices[k]) + static_cast<Eigen::Index>(axis)];
  }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

}  // namespace

VectorXd shares_of_vertices(const VectorView& pose, std::span<const Index> vertices) {
  VectorXd shares = VectorXd::Zero(static_cast<Eigen::Index>(vertices.size()));
  if (vertices.empty()) return shares;
  const KeyPositions positions{pose, vertices};
  using Metric = nanoflann::L2_Simple_Adaptor<double, KeyPositions>;
  const nanoflann::KDTreeSingleIndexAdaptor<Metric, KeyPositions, 3> tree(3, positions);
  for (Eigen::Index v = 0; v + 2 < pose.size(); v += 3) {
    std::size_t nearest = 0;
    double squared = 0;
    nanoflann::KNNResultSet<double> found(1);
    found.init(&nearest, &squared);
    tree.findNeighbors(found, pose.data() + v, nanoflann::SearchParams());
    shares[static_cast<Eigen::Index>(nearest)] += 1;
  }
  return shares.cwiseMax(1);  // Of key points in one place, one gets all.
}

MatrixXd rows_of(const MatrixView& matrix, std::span<const Index> vertices) {
  MatrixXd rows(3 * static_cast<Eigen::Index>(vertices.size()), matrix.cols());
  for (std::size_t k = 0; k < vertices.size(); ++k) {
    assert(3 * static_cast<Eigen::Index>(vertices[k]) + 2 < matrix.rows());
    rows.middleRows<3>(3 * static_cast<Eigen::Index>(k)) =
        matrix.middleRows<3>(3 * static_cast<Eigen::Index>(vertices[k]));
  }
  return rows;
}

LeastSquares least_squares(const MatrixXd& rows, const VectorXd& shares) {
  const Eigen::Index modes = rows.cols();
  if (modes == 0 || rows.rows() == 0) return {MatrixXd::Zero(modes, rows.rows()), modes > 0};
  const VectorXd weights = shares.cwiseSqrt().transpose().replicate<3, 1>().reshaped();
  const Eigen::JacobiSVD<MatrixXd> svd(weights.asDiagonal() * rows,
                                       Eigen::ComputeThinU | Eigen::ComputeThinV);
  const VectorXd& values = svd.singularValues();
  LeastSquares solved;
  solved.rank_deficient = rows.rows() < modes || !(values.minCoeff() > kSeen * values[0]);
  if (!(values[0] > 0)) return {MatrixXd::Zero(modes, rows.rows()), true};
  const double ridge = solved.rank_deficient ? kSeen * values[0] * kSeen * values[0] : 0;
  const VectorXd inverted = values.array() / (values.array().square() + ridge);
  solved.inverse = svd.matrixV() * inverted.asDiagonal() * svd.matrixU().transpose() * weights.asDiagonal();
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
