/// Leaving poses out, for those who have the poses' span already.
#pragma once

#include <functional>

#include "foldproof/keypoints.h"
#include "statistics/span.h"

namespace foldproof {

/// Sees how far vertices `first`, `first` + 1 and so on of a pose are from its best rebuild by the others.
using SeeMissed = std::function<void(Eigen::Index pose, Index first, const VectorView& lengths)>;

/// The same as leave_one_out(samples, size, vertices). `span`: of the samples, all modes. At least two
/// samples.
std::vector<PoseError> leave_one_out(const MatrixView& samples, const Span& span, const SubspaceSize& size,
                                     std::span<const Index> vertices, const SeeMissed& see_missed = {});

}  // namespace foldproof
