/// Key points: a few vertices from whose positions the whole mesh is reconstructed (paper, Eq. 2, 6 and 7,
/// Fig. 2 and 3).
#pragma once

#include <vector>

#include "foldproof/mesh.h"
#include "foldproof/statistics.h"

namespace foldproof {

struct KeyPointSettings {
  double first_share = 0.02;  ///< Share of the vertices in the first set.
  double max_share = 0.04;    ///< Share of the vertices in all.
  /// Rounds end at this reconstruction error of the training poses: root mean square over vertices and poses,
  /// as a share of the size (largest side of the box around `positions`). 0: no such limit.
  double tolerance = 0;
  Index max_rounds = 32;  ///< After the first set.
  /// Rounds also end after this many without an improvement (of a thousandth of the error). Then the rounds
  /// after the best one are discarded: key points cannot reduce an error outside the subspace. 0: never.
  Index patience = 4;
};

struct KeyPoints {
  std::vector<Index> vertices;    ///< Without repetition, in the order in which rounds chose them.
  std::vector<Index> round_ends;  ///< vertices[0, round_ends[0]) is the first set, and so on.
  std::vector<double> errors;     ///< After each round: root mean square vertex distance, mesh units.
};

/// From the key points' positions to p: least squares on their rows of the subspace (Eq. 2), factorized once.
///
/// The weight of a key point is the number of vertices nearest to it in the mean pose, so that the fit
/// approximates one over all vertices. Without weights, clusters of key points pull the fit towards
/// themselves: on held-out frames of a hand (35,148 vertices, 21 modes) the error was 1.19 times that of all
/// vertices, and grew with every round; weighted it is 1.01 times.
///
/// When the key points do not determine all modes (a singular value of their weighted rows is below 1e-4 of
/// the largest), the square of that bound is added as a ridge. Undetermined modes then stay near 0.
class KeyPointMap {
 public:
  KeyPointMap() = default;
  /// Precondition: `vertices` < size of the subspace's mean / 3.
  /// Cost: O(size * log(key points) + key points * modes^2).
  KeyPointMap(const Pca& subspace, std::span<const Index> vertices);

  std::span<const Index> vertices() const { return vertices_; }
  /// The key points' positions in a whole pose: x y z of each, in the order of vertices().
  Eigen::VectorXd gather(const VectorView& x) const;
  /// p from the key points' positions, in the order of gather. Cost: one product, modes x 3 key points.
  Eigen::VectorXd coordinates(const VectorView& key_positions) const;
  /// Whether the ridge was needed.
  bool rank_deficient() const { return rank_deficient_; }

 private:
  std::vector<Index> vertices_;
  Eigen::VectorXd mean_;     // of the key points' positions
  Eigen::MatrixXd inverse_;  // modes x 3 key points
  bool rank_deficient_ = false;
};

/// Distances between the vertices of two poses, mesh units.
struct VertexDistance {
  double mean = 0;
  double worst = 0;
  Index worst_vertex = kNoIndex;
};

/// The reconstruction error of a pose x.
struct PoseError {
  /// From x to its reconstruction from all vertices (Eq. 4, 5): what is outside the subspace.
  VertexDistance projection;
  /// From that to the reconstruction from key points alone: what key points add.
  VertexDistance cueing;
  /// From x to its reconstruction from key points alone.
  VertexDistance total;
};

/// `a`, `b`: poses of equal size, x0 y0 z0 x1 ...
VertexDistance vertex_distance(const VectorView& a, const VectorView& b);

}  // namespace foldproof
