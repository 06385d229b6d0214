/// Products of matrices that have many rows and few columns, in the widest vectors that the machine has.
/// Every number is a sum in one order, the same on all machines.
#pragma once

#include "foldproof/statistics.h"

namespace foldproof {

/// a b.
Eigen::MatrixXd tall_product(const MatrixView& a, const MatrixView& b);
/// a^T b, of equally many rows.
Eigen::MatrixXd tall_inner(const MatrixView& a, const MatrixView& b);

/// How many rows of so many columns are worth looking at together: they stay in the cache.
Eigen::Index rows_at_a_time(Eigen::Index columns);

}  // namespace foldproof
