// Prints: the point may go 0.4 of the way
// A point falls through a triangle, asked through ipc-toolkit. The test suite compiles this against a
// stand-in of ipc-toolkit's interfaces.
#include "foldproof/ipc_toolkit.h"

#include <cstdio>
#include <ipc/ipc.hpp>

int main() {
  Eigen::MatrixXd x0(4, 3), x1;
  x0 << -9, -9, 0, 20, -9, 0, -9, 20, 0, 0, 0, 1;
  x1 = x0;
  x1(3, 2) = -1;
  Eigen::MatrixXi edges(3, 2), faces(1, 3);
  edges << 0, 1, 1, 2, 2, 0;
  faces << 0, 1, 2;
  const ipc::CollisionMesh mesh(x0, edges, faces);

  foldproof::ipc_toolkit::BroadPhase broad_phase;             // was ipc::LBVH; keep it from step to step
  const foldproof::ipc_toolkit::NarrowPhaseCCD narrow_phase;  // was ipc::TightInclusionCCD
  const double size = ipc::compute_collision_free_stepsize(mesh, x0, x1, 0, &broad_phase, narrow_phase);
  std::printf("the point may go %.3g of the way\n", size);
}
