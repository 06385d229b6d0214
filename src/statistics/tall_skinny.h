/// Products of matrices with many rows and few columns, in the widest vectors that the machine has. Every
/// number is summed in one fixed order, so all machines get the same result.
#pragma once

#include "foldproof/statistics.h"

namespace foldproof::inline internal {

/// a b.
Eigen::MatrixXd tall_skinny_product(const MatrixView& a, const MatrixView& b);
/// a^T b. Precondition: as many rows in a as in b.
Eigen::MatrixXd tall_skinny_inner(const MatrixView& a, const MatrixView& b);

/// How many rows of that many columns to process together, so that they stay in the cache.
Eigen::Index block_rows(Eigen::Index columns);

}  // namespace foldproof::inline internal
