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

/// Chooses key points by the paper's method.
///
/// The first set is a Poisson-disk sample of the vertices in the pose `positions` (vertices x 3, mesh units):
/// `first_share` of them, at least one. Then rounds add to it. The first round takes its basis vectors from
/// `subspace`, each later one from a PCA of the residuals of the training poses when they are reconstructed
/// from the key points. For each basis vector, seen as a 3-vector V_k per vertex, a round adds i = argmax
/// |V_i| (Eq. 6) and j = argmin V_i . V_j (Eq. 7, when that is negative), both among vertices that are not
/// key points yet. Rounds end at the tolerance, at the budget `max_share`, after `max_rounds`, when they gain
/// nothing, or when the residual is only rounding.
///
/// `samples`: the training poses, x0 y0 z0 x1 ... in columns. A round takes basis vectors up to 95 % of the
/// residual's energy, at most 16. Cost of a round: O(size * samples * (samples + modes)). Error: sizes
/// differ, a number is not finite, a share outside (0, 1] or first_share > max_share, no samples.
Result<KeyPoints> choose_key_points(std::span<const double> positions, const MatrixView& samples,
                                    const Pca& subspace, const KeyPointSettings& settings = {});

/// Poisson-disk sampling: keeps a vertex, drops all others within a radius of it, and goes on with the next
/// one left. Bisection finds a radius that keeps about `count` vertices, never more and at least one.
/// Ascending ids. Cost: a few milliseconds per 10,000 vertices.
std::vector<Index> poisson_disk_sample(std::span<const double> positions, Index count);

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

PoseError pose_error(const Pca& subspace, const KeyPointMap& map, const VectorView& x);

/// Leave-one-out errors: those of each sample with the subspace (of that size) and key-point map of the other
/// samples. Fewer than two samples give none. Errors as pca. Cost: O(size * samples^2) for all together,
/// because it works in coordinates of a thin SVD of the samples.
Result<std::vector<PoseError>> leave_one_out(const MatrixView& samples, const SubspaceSize& size,
                                             std::span<const Index> vertices);

}  // namespace foldproof
