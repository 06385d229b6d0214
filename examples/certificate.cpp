// Prints: a chart was built, and it is valid
// Parametrizes a patch of surface over the plane, for proofs that the patch does not touch itself.
#include <cstdio>

#include "foldproof/certificate.h"

int main() {
  using namespace foldproof;
  const Patch patch{.vertices = {0, 1, 2, 3}, .triangles = {{0, 1, 2}, {0, 2, 3}}};
  const std::vector<std::array<float, 3>> corners{{0, 0, 0}, {1, 0, 0.1f}, {1, 1, 0}, {0, 1, 0.1f}};
  Parametrizer parametrizer;
  UvMap uv_map;
  const ChartOutcome outcome =
      parametrizer.build(patch, corners, parametrizer.facing(patch, corners), uv_map);
  if (outcome != ChartOutcome::Made || !chart_is_valid(patch, uv_map)) return 1;
  std::puts("a chart was built, and it is valid");
}
