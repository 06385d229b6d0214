/// Leave-one-out errors for callers that have the samples' thin SVD already.
#pragma once

#include <functional>

#include "foldproof/keypoints.h"
#include "statistics/thin_svd.h"

namespace foldproof::inline internal {

/// Gets the projection errors of the vertices `first`, `first` + 1, ... of a pose.
using ProjectionErrorVisitor =
    std::function<void(Eigen::Index pose, Index first, const VectorView& distances)>;

/// leave_one_out(samples, size, vertices). `svd`: of the samples, all modes. Precondition: two samples.
std::vector<PoseError> leave_one_out(const MatrixView& samples, const ThinSvd& svd, const SubspaceSize& size,
                                     std::span<const Index> vertices,
                                     const ProjectionErrorVisitor& visit = {});

}  // namespace foldproof::inline internal
