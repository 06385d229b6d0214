// Memory that the library allocates for Eigen is freed here, and the other way round, although this file is
// compiled for wider registers, with which Eigen would align it otherwise.
#include <cstdio>

#include "foldproof/statistics.h"

int main() {
  for (int k = 1; k < 200; ++k) {
    Eigen::MatrixXd samples = Eigen::MatrixXd::Random(k, 12);
    auto pca = foldproof::pca(samples, {.modes = 3});
    if (!pca) return std::puts(pca.error().line().c_str()), 1;
    pca->mean = Eigen::VectorXd::Zero(k + 8);
    pca->basis.resize(k + 8, 2);
  }
  std::puts("all of it was freed");
}
