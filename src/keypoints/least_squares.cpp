#include "keypoints/least_squares.h"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <cassert>
#include <nanoflann.hpp>

#include "statistics/tall_skinny.h"

namespace foldproof::internal {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

// Smallest singular value, relative to the largest, at which the key points determine all modes.
constexpr double kMinSingularValue = 1e-4;
// Smallest eigenvalue of the normal equations, relative to the largest, at which they are accurate enough.
constexpr double kMinEigenvalue = 1e-6;

// nanoflann's view of some vertices of a pose.
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

// nanoflann's view of the nearest point so far; points that are not nearer are ignored.
struct NearestSoFar {
  double squared;
  Index nearest;

  bool full() const { return true; }
  double worstDist() const { return squared; }
  bool addPoint(double distance, std::size_t index) {
    if (distance < squared) squared = distance, nearest = static_cast<Index>(index);
    return true;
  }
};

class KeyPointTree {
 public:
  KeyPointTree(const VectorView& pose, std::span<const Index> vertices)
      : positions_{pose, vertices}, tree_(3, positions_) {}

  // The key point nearest to a vertex; of equally near ones `guess`, if it is one of them.
  Index nearest(std::size_t vertex, Index guess) const {
    const double* at = positions_.pose.data() + 3 * vertex;
    double squared = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double d = at[axis] - positions_.kdtree_get_pt(guess, axis);
      squared += d * d;
    }
    NearestSoFar result{squared, guess};
    tree_.findNeighbors(result, at, nanoflann::SearchParams());
    return result.nearest;
  }

 private:
  using Metric = nanoflann::L2_Simple_Adaptor<double, KeyPositions>;
  KeyPositions positions_;
  nanoflann::KDTreeSingleIndexAdaptor<Metric, KeyPositions, 3> tree_;
};

}  // namespace

VectorXd nearest_counts(const VectorView& pose, std::span<const Index> vertices) {
  return NearestKeyPoints(pose, vertices).counts(pose);
}

NearestKeyPoints::NearestKeyPoints(const VectorView& pose, std::span<const Index> vertices)
    : vertices_(vertices) {
  if (vertices_.empty()) return;
  nearest_.assign(static_cast<std::size_t>(pose.size() / 3), 0);
  const KeyPointTree keys(pose, vertices_);
  // The key point nearest to one vertex is usually near the next one.
  Index guess = 0;
  for (std::size_t v = 0; v < nearest_.size(); ++v) guess = nearest_[v] = keys.nearest(v, guess);
}

VectorXd NearestKeyPoints::counts(const VectorView& pose) const {
  VectorXd counts = VectorXd::Zero(static_cast<Eigen::Index>(vertices_.size()));
  if (vertices_.empty()) return counts;
  const KeyPointTree keys(pose, vertices_);
  for (std::size_t v = 0; v < nearest_.size(); ++v) counts[keys.nearest(v, nearest_[v])] += 1;
  return counts.cwiseMax(1);  // Of key points at the same position, one gets all vertices.
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

LeastSquares least_squares(const MatrixXd& rows, const VectorXd& weights) {
  const Eigen::Index modes = rows.cols();
  if (modes == 0 || rows.rows() == 0) return {MatrixXd::Zero(modes, rows.rows()), modes > 0};
  const VectorXd roots = weights.cwiseSqrt().transpose().replicate<3, 1>().reshaped();
  const MatrixXd weighted = roots.asDiagonal() * rows;
  const Eigen::SelfAdjointEigenSolver<MatrixXd> normal(tall_skinny_inner(weighted, weighted));
  // Well conditioned: the normal equations are accurate enough.
  if (rows.rows() >= modes && normal.eigenvalues()[0] > kMinEigenvalue * normal.eigenvalues()[modes - 1]) {
    const MatrixXd& vectors = normal.eigenvectors();
    const MatrixXd inverse_square =
        vectors * normal.eigenvalues().cwiseInverse().asDiagonal() * vectors.transpose();
    return {inverse_square * weighted.transpose() * roots.asDiagonal(), false};
  }
  const Eigen::JacobiSVD<MatrixXd> svd(weighted, Eigen::ComputeThinU | Eigen::ComputeThinV);
  const VectorXd& values = svd.singularValues();
  LeastSquares solved;
  solved.rank_deficient = rows.rows() < modes || !(values.minCoeff() > kMinSingularValue * values[0]);
  if (!(values[0] > 0)) return {MatrixXd::Zero(modes, rows.rows()), true};
  const double ridge =
      solved.rank_deficient ? kMinSingularValue * values[0] * kMinSingularValue * values[0] : 0;
  const VectorXd inverted = values.array() / (values.array().square() + ridge);
  solved.inverse = svd.matrixV() * inverted.asDiagonal() * svd.matrixU().transpose() * roots.asDiagonal();
  return solved;
}

namespace {

VectorXd lengths_of(const VectorView& field) {
  return Eigen::Map<const MatrixXd>(field.data(), 3, field.size() / 3).colwise().norm();
}

void add_lengths(const VectorXd& lengths, Index first, VertexDistance& sums) {
  sums.mean += lengths.sum();
  Eigen::Index longest = 0;
  const double worst = lengths.maxCoeff(&longest);
  if (!(worst > sums.worst) && sums.worst_vertex != kNoIndex) return;
  sums.worst = worst;
  sums.worst_vertex = first + static_cast<Index>(longest);
}

}  // namespace

VertexDistance vertex_lengths(const VectorView& field) {
  if (field.size() < 3) return {};
  VertexDistance distance;
  add_lengths(lengths_of(field), 0, distance);
  const Eigen::Index vertices = field.size() / 3;
  distance.mean /= static_cast<double>(vertices);
  return distance;
}

VectorXd PoseErrorSum::add(Index first, const VectorView& projection, const VectorView& cueing) {
  vertices_ = first + static_cast<Index>(projection.size() / 3);
  VectorXd lengths = lengths_of(projection);
  add_lengths(lengths, first, sums_.projection);
  add_lengths(lengths_of(cueing), first, sums_.cueing);
  add_lengths(lengths_of(projection + cueing), first, sums_.total);
  return lengths;
}

PoseError PoseErrorSum::result() const {
  PoseError error = sums_;
  for (VertexDistance* d : {&error.projection, &error.cueing, &error.total}) d->mean /= vertices_;
  return error;
}

}  // namespace foldproof::internal
