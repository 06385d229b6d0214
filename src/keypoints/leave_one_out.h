/// Leave-one-out errors of reconstruction.
#pragma once

#include <functional>

#include "foldproof/keypoints.h"
#include "statistics/thin_svd.h"

namespace foldproof::inline internal {

/// Gets the projection errors of the vertices `first`, `first` + 1, ... of a pose.
using ProjectionErrorVisitor =
    std::function<void(Eigen::Index pose, Index first, const VectorView& distances)>;

/// The errors of each sample with the subspace (of that size) and key-point map of the other samples. `svd`:
/// of the samples, all modes: in its coordinates all together cost O(size * samples^2). Precondition: two
/// samples.
std::vector<PoseError> leave_one_out(const MatrixView& samples, const ThinSvd& svd, const SubspaceSize& size,
                                     std::span<const Index> vertices,
                                     const ProjectionErrorVisitor& visit = {});

}  // namespace foldproof::inline internal
