/// Learns the map from key points to certificates.
#pragma once

#include "learned/learn.h"

namespace foldproof::inline internal {

/// `keys`: key positions, a column per pose; `anchor`: those of the mean. Null when there are no nodes.
/// Error: numbers that are not finite.
Result<std::shared_ptr<const CertificateMap>> make_certificate_map(const Hierarchy& hierarchy,
                                                                   const LearnInput& input,
                                                                   const Eigen::MatrixXd& keys,
                                                                   const Eigen::VectorXd& anchor);

/// Per node of the hierarchy, its level: 0 for the root.
std::vector<Index> depths_of(const Hierarchy& hierarchy);

}  // namespace foldproof::inline internal
