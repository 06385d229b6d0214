/// Chooses key points.
#pragma once

#include "foldproof/keypoints.h"

namespace foldproof::inline internal {

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

}  // namespace foldproof::inline internal
