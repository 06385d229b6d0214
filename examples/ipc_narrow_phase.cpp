// Prints: two points that fly towards each other keep 0.2 of their gap until 0.4 of the way
#include "foldproof/ipc_narrow_phase.h"

#include <cstdio>

int main() {
  foldproof::ipc_toolkit::NarrowPhaseCCD narrow_phase;
  narrow_phase.rescale_distance = true;
  const Eigen::Vector3d p0(0, 0, 0), p1(1, 0, 0), q0(4, 0, 0), q1(-3, 0, 0);
  double toi = 1;
  if (!narrow_phase.point_point_ccd(p0, q0, p1, q1, toi)) return 1;
  std::printf("two points that fly towards each other keep 0.2 of their gap until %.1g of the way\n", toi);
}
