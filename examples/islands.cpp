// Prints: after 6 steps with one share 1 of 4 lie on their floors, with a share for each island 4
// Points fall on floors of different heights. Where one share holds for all, the first contact stops the
// others.
#include <cstdio>

#include "foldproof/solver.h"

using namespace foldproof;

namespace {

constexpr Index kFalling = 4;

// A floor below each point, the k-th at the height -k.
CollisionMesh make_scene(std::vector<double>& x, std::vector<double>& target) {
  std::vector<Triangle> floors;
  for (Index k = 0; k < kFalling; ++k) {
    const double left = 10 * k, height = -1.0 * k;
    x.insert(x.end(), {left, 1, 0, left - 2, height, -2, left + 4, height, -2, left - 2, height, 4});
    floors.push_back({4 * k + 1, 4 * k + 2, 4 * k + 3});
  }
  target = x;
  for (Index k = 0; k < kFalling; ++k) target[12 * k + 1] = -10;
  return CollisionMesh::make(x, {}, floors).value();
}

int landed(const std::vector<double>& x) {
  int count = 0;
  for (Index k = 0; k < kFalling; ++k) count += x[12 * k + 1] + k < 1e-3;
  return count;
}

}  // namespace

int main() {
  std::vector<double> start, target, shares;
  const auto mesh = std::make_shared<const CollisionMesh>(make_scene(start, target));
  ContactChecker checker(mesh);
  std::vector<double> together = start, apart = start;
  for (int step = 0; step < 6; ++step) {
    const double share = checker.collision_free_step_size(together, target).value().share;
    step_towards(together, target, share, together);
    if (!checker.collision_free_step_sizes(apart, target, shares)) return 1;
    step_towards(apart, target, shares, apart);
  }
  std::printf("after 6 steps with one share %d of 4 lie on their floors, with a share for each island %d\n",
              landed(together), landed(apart));
}
