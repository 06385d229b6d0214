// Prints: the box is 0.5 x 2 x 1
// The box around positions.
#include "foldproof/vec3.h"

#include <cstdio>

int main() {
  using foldproof::Vec3;
  const double positions[] = {0, 0, 0, 0.5, 1, 0, 0.25, -1, 1};  // x y z of each, as meshes have them
  Vec3 low = Vec3::load(positions), high = low;
  for (int i = 0; i < 9; i += 3) {
    low = low.cwiseMin(Vec3::load(&positions[i]));
    high = high.cwiseMax(Vec3::load(&positions[i]));
  }
  const Vec3 size = high - low;
  std::printf("the box is %g x %g x %g\n", size.x(), size.y(), size.z());
}
