/// Key points: a few vertices whose positions tell the whole mesh's (paper, Eq. 2, 6 and 7, Fig. 2 and 3).
#pragma once

#include <vector>

#include "foldproof/mesh.h"
#include "foldproof/statistics.h"

namespace foldproof {

struct KeyPointSettings {
  double first_share = 0.02;  ///< Of the vertices, in the first set.
  double most_share = 0.04;   ///< Of the vertices, in all.
  /// Rounds end when the rebuilt training poses are this near, root mean square over vertices and poses, as a
  /// share of the size (largest side of the box around `positions`). 0: not by this.
  double tolerance = 0;
  Index most_rounds = 32;  ///< After the first set.
  /// Rounds also end after so many without a gain (a thousandth of the error), and those after the one of
  /// least error are taken back: what is outside the subspace, no key point mends. 0: never.
  Index patience = 4;
};

struct KeyPoints {
  std::vector<Index> vertices;    ///< No vertex twice; in the order in which rounds chose them.
  std::vector<Index> round_ends;  ///< vertices[0, round_ends[0]) is the first set, and so on.
  std::vector<double> errors;     ///< After each round: root mean square vertex distance, mesh units.
};

/// Chooses key points as the paper has it.
///
/// First set: of the vertices in the pose `positions` (vertices x 3, mesh units) keep one and drop all within
/// a radius, again and again; the radius comes from bisection so that `first_share` of them stay (at least
/// one). Then rounds: the first takes its basis vectors from `subspace`, each later one from a PCA of the
/// residual that the training poses have when rebuilt from the key points alone. For a basis vector, seen as
/// a 3-vector V_k per vertex, it adds i = argmax |V_i| (Eq. 6) and j = argmin V_i . V_j (Eq. 7, when that is
/// negative), both among the vertices that are not key points yet. Rounds end at the tolerance, at the budget
/// of `most_share`, after `most_rounds`, when they gain nothing, or when the residual is rounding only.
///
/// `samples`: the training poses, x0 y0 z0 x1 ... in columns. A round takes basis vectors up to 95 % of the
/// residual's energy, at most 16; its cost is O(size * samples * (samples + modes)). Error: sizes do not fit,
/// a number is not finite, a share outside (0, 1] or first_share > most_share, no samples.
Result<KeyPoints> choose_key_points(std::span<const double> positions, const MatrixView& samples,
                                    const Pca& subspace, const KeyPointSettings& settings = {});

/// The first set alone: about `count` vertices (never more, at least one), spread evenly. Ascending ids.
/// Cost: a few milliseconds per 10,000 vertices.
std::vector<Index> thin_by_radius(std::span<const double> positions, Index count);

/// From the key points' positions to p: least squares on their rows of the subspace (Eq. 2), factorised once.
///
/// A key point counts as often as there are vertices nearest to it in the mean pose, so that the fit
/// comes near to one over all vertices. Unweighted, the clusters of key points that rounds make pull the fit
/// towards themselves: on held-out frames of a hand (35,148 vertices, 21 modes) the error was 1.19 times that
/// of all vertices, and grew with every round; weighted it is 1.01 times.
///
/// When the key points do not tell all modes apart (a singular value of their weighted rows below 1e-4 of the
/// largest), the square of that bound is added as a ridge: modes that key points do not see then stay near 0
/// instead of exploding.
class KeyPointMap {
 public:
  KeyPointMap() = default;
  /// `vertices` < size of the subspace's mean / 3; a caller's bug otherwise.
  /// Cost: O(size * log(key points) + key points * modes^2).
  KeyPointMap(const Pca& subspace, std::span<const Index> vertices);

  std::span<const Index> vertices() const { return vertices_; }
  /// The rows of the key points from a whole pose: x y z of each, in the order of vertices().
  Eigen::VectorXd gather(const VectorView& x) const;
  /// p from the key points' positions (as gather gives them). Cost: one product, modes x 3 key points.
  Eigen::VectorXd coordinates(const VectorView& key_positions) const;
  /// True when the ridge was needed.
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

/// How badly a pose x is represented.
struct PoseError {
  VertexDistance
      projection;         ///< x against its best rebuild from all vertices (Eq. 4, 5): outside the subspace.
  VertexDistance cueing;  ///< That rebuild against the one from key points alone: what key points add.
  VertexDistance total;   ///< x against its rebuild from key points alone.
};

/// Between poses of equal size, x0 y0 z0 x1 ...
VertexDistance vertex_distance(const VectorView& a, const VectorView& b);

PoseError pose_error(const Pca& subspace, const KeyPointMap& map, const VectorView& x);

/// Each sample against the subspace (of that size) and key-point map that the other samples give. Fewer than
/// two samples: none. Errors as pca. Cost: O(size * samples^2) for all together, as everything happens in the
/// samples' span.
Result<std::vector<PoseError>> leave_one_out(const MatrixView& samples, const SubspaceSize& size,
                                             std::span<const Index> vertices);

}  // namespace foldproof
