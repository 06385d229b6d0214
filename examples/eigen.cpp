// Prints: vertex 3 meets face 0 at 0.600 of the step
// One step of a mesh in matrices of Eigen: a row per vertex, a row per triangle.
#include "foldproof/eigen.h"

#include <cstdio>

#include "foldproof/check.h"

int main() {
  using namespace foldproof;
  PositionMatrix x0(6, 3);  // its rows are read in place; those of an Eigen::MatrixXd would be copied
  x0 << -9, -9, 0, 20, -9, 0, -9, 20, 0, 0, 0, 0.6, 1, 0, 2, 0, 1, 2;
  PositionMatrix x1 = x0;
  x1.bottomRows(3).rowwise() -= Eigen::RowVector3d(0, 0, 1);
  Eigen::MatrixXi faces(2, 3);
  faces << 0, 1, 2, 3, 4, 5;

  const auto mesh = Topology::make(6, ids_of<3>(faces));
  StepChecker checker({Hierarchy::build(mesh.value(), positions_of(x0)).value()});
  StepResult result;
  if (!checker.check(positions_of(x0), positions_of(x1), {}, result)) return 1;
  for (const auto& hit : result.vertex_face)
    std::printf("vertex %u meets face %u at %.3f of the step\n", hit.vertex, hit.face, hit.toi);
}
