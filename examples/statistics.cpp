// Prints: one mode tells 100 % of the variance, along (0.60, 0.80)
// Principal components of points on a line.
#include "foldproof/statistics.h"

#include <cstdio>

int main() {
  Eigen::MatrixXd points(2, 5);  // a column per point
  points << 3, 6, 9, 12, 15, 4, 8, 12, 16, 20;
  const auto pca = foldproof::pca(points);
  if (!pca) return std::puts(pca.error().line().c_str()), 1;
  std::printf("one mode tells %.0f %% of the variance, along (%.2f, %.2f)\n", 100 * pca->energy[0],
              pca->basis(0, 0), pca->basis(1, 0));
}
