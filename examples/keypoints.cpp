// Prints: 4 of 123 vertices, spread evenly: 0 39 78 117
// Chooses a few vertices that lie far from each other.
#include "foldproof/keypoints.h"

#include <cstdio>

#include "strip.h"

int main() {
  const std::vector<double> x = bent_strip(0.5);
  const auto chosen = foldproof::poisson_disk_sample(x, 4);
  std::printf("%zu of %zu vertices, spread evenly:", chosen.size(), x.size() / 3);
  for (const foldproof::Index v : chosen) std::printf(" %u", v);
  std::puts("");
}
