// Prints: a chart was drawn, and it is valid
// Draws a patch of surface in the plane, so that it can be proven not to meet itself.
#include <cstdio>

#include "foldproof/certificate.h"

int main() {
  using namespace foldproof;
  const Patch patch{.vertices = {0, 1, 2, 3}, .triangles = {{0, 1, 2}, {0, 2, 3}}};
  const std::vector<std::array<float, 3>> corners{{0, 0, 0}, {1, 0, 0.1f}, {1, 1, 0}, {0, 1, 0.1f}};
  ChartMaker maker;
  Drawing drawing;
  const ChartOutcome outcome = maker.draw(patch, corners, maker.facing(patch, corners), drawing);
  if (outcome != ChartOutcome::Made || !chart_is_valid(patch, drawing)) return 1;
  std::puts("a chart was drawn, and it is valid");
}
