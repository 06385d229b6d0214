// Prints: the point may go 0.4 of the way; then 1 pair is within 0.5
// How far a solver may step: a point falls through a triangle.
#include "foldproof/solver.h"

#include <cstdio>

int main() {
  using namespace foldproof;
  const std::vector<double> x0 = {-9, -9, 0, 20, -9, 0,
                                  -9, 20, 0, 0,  0,  1};  // vertex 3 is in no face: a point
  std::vector<double> x1 = x0;
  x1[11] = -1;
  const auto mesh = CollisionMesh::make(x0, {}, {{0, 1, 2}});  // positions at rest, edges, faces
  if (!mesh) return std::puts(mesh.error().line().c_str()), 1;

  ContactChecker checker(std::make_shared<const CollisionMesh>(*mesh));  // keep it from step to step
  const auto size = checker.collision_free_step_size(x0, x1);
  if (!size) return std::puts(size.error().line().c_str()), 1;
  std::vector<double> x(x0.size());
  step_towards(x0, x1, size->share, x);
  Candidates near;
  if (const auto done = checker.candidates(x, 0.5, near); !done)
    return std::puts(done.error().line().c_str()), 1;
  std::printf("the point may go %.3g of the way; then %zu pair is within 0.5\n", size->share, near.size());
}
