// Prints: start start start contact contact contact none: it slid 1.00 and is 0.010 above the floor
// A solver without a barrier: what to do where a step size is limited. A triangle slides on a floor.
#include <cstdio>

#include "foldproof/solver.h"

namespace {

using namespace foldproof;
using Numbers = std::vector<double>;

constexpr double kMinDistance = 0.01;
constexpr Index kFirstFree = 4;  // vertices before it are the floor

// Changes x so that the pair comes apart by `distance`, free vertices only.
void move_apart(const ClosePair& pair, double distance, Numbers& x) {
  double sum = 0;
  for (int k = 0; k < 4; ++k) sum += pair.vertices[k] >= kFirstFree ? pair.weights[k] * pair.weights[k] : 0;
  if (sum == 0) return;
  for (int k = 0; k < 4; ++k) {
    const Index v = pair.vertices[k];
    for (int axis = 0; axis < 3 && v >= kFirstFree; ++axis)
      x[3 * v + axis] += distance * pair.weights[k] / sum * pair.normal[axis];
  }
}

// By how much the step from x to `wanted` brings the pair apart.
double separation(const ClosePair& pair, const Numbers& x, const Numbers& wanted) {
  double sum = 0;
  for (int k = 0; k < 4; ++k) {
    const Index v = pair.vertices[k];
    sum += pair.weights[k] * pair.normal.dot(Vec3::load(&wanted[3 * v]) - Vec3::load(&x[3 * v]));
  }
  return sum;
}

// Moves x towards `wanted`, and along what is in the way. Returns whether it went on to the end.
bool advance(ContactChecker& checker, Numbers& x, Numbers wanted) {
  for (int round = 0; round < 20; ++round) {
    const StepSize size = checker.collision_free_step_size(x, wanted, kMinDistance).value();
    std::printf("%s%s", kStepLimitNames[std::size_t(size.limit)],
                size.limit == StepSize::Limit::None ? ": " : " ");
    step_towards(x, wanted, size.share, x);  // proven free
    if (size.limit == StepSize::Limit::None) return true;
    if (size.limit == StepSize::Limit::Start) {
      // Too close already: nothing can move with this minimum distance, not even apart. Without one it can.
      Numbers apart = x;
      move_apart(size.contact, 2 * kMinDistance - size.contact.distance, apart);
      const double share = checker.collision_free_step_size(x, apart).value().share;
      if (share == 0) return false;  // it touches: see has_intersections
      step_towards(x, apart, share, x);
      continue;
    }
    // Contact: goes on without that part of the step that brings the pair nearer.
    const double apart = separation(size.contact, x, wanted);
    if (apart < 0) {
      move_apart(size.contact, -apart, wanted);
    } else if (size.share == 0) {
      return false;  // undecided, and nothing moves: give a shorter step, or repair the thin triangle
    }
  }
  return false;
}

}  // namespace

int main() {
  Numbers x = {-9, -9, 0,     9, -9, 0,     -9, 9, 0,    9, 9, 0,  // a floor of two triangles
               0,  0,  0.005, 1, 0,  0.005, 0,  1, 0.005};
  const auto mesh = CollisionMesh::make(x, {}, {{0, 1, 2}, {2, 1, 3}, {4, 5, 6}});
  if (!mesh) return std::puts(mesh.error().line().c_str()), 1;
  ContactChecker checker(std::make_shared<const CollisionMesh>(*mesh));

  Numbers wanted = x;
  for (std::size_t i = 3 * kFirstFree; i < x.size(); i += 3) {
    wanted[i] += 1;
    wanted[i + 2] -= 1;
  }
  if (!advance(checker, x, wanted)) return std::puts("it is stuck"), 1;
  std::printf("it slid %.2f and is %.3f above the floor\n", x[12], std::min(x[14], x[20]));
}
