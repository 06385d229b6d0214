// Prints: vertex 3 meets face 0 at 0.600 of the step
// Every collision of one step: the second triangle sinks through the first.
#include "foldproof/check.h"

#include <cstdio>

int main() {
  using namespace foldproof;
  const std::vector<double> x0 = {-9, -9, 0, 20, -9, 0, -9, 20, 0, 0, 0, 0.6, 1, 0, 2, 0, 1, 2};
  const std::vector<double> x1 = {-9, -9, 0, 20, -9, 0, -9, 20, 0, 0, 0, -0.4, 1, 0, 1, 0, 1, 1};
  auto tree = Hierarchy::build(Topology::make(6, {{0, 1, 2}, {3, 4, 5}}).value(), x0);
  if (!tree) return std::puts(tree.error().line().c_str()), 1;

  StepChecker checker({std::move(*tree)});
  StepResult result;
  if (const auto done = checker.check(x0, x1, {}, result); !done)
    return std::puts(done.error().line().c_str()), 1;
  for (const auto& hit : result.vertex_face)
    std::printf("vertex %u meets face %u at %.3f of the step\n", hit.vertex, hit.face, hit.toi);
}
