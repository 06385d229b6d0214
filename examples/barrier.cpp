// Prints: the rod rests 0.091 to 0.091 above the floor; the gradient agrees with differences: yes
// A barrier simulation without computing a distance: a rod sinks to a floor and stays above it.
#include <cmath>
#include <cstdio>

#include "foldproof/solver.h"

namespace {

using namespace foldproof;
using Numbers = std::vector<double>;

constexpr double kReach = 0.1, kStiffness = 40, kWeight = 0.1;  // of the barrier; of each end of the rod
constexpr std::size_t kFirstFree = 4;                           // vertices before it are the floor

Vec3 at(const Numbers& x, Index v) { return Vec3::load(&x[3 * v]); }

struct Energy {
  double value = 0;
  Numbers gradient;
  void add(Index v, const Vec3& g) {
    for (int axis = 0; axis < 3; ++axis) gradient[3 * v + axis] += g[axis];
  }
};

// Weight, and for each pair its count times the mollifier m times the barrier b:
// b(d) = -(d - reach)^2 ln(d / reach), m(c) = (2 - c / threshold) c / threshold, c = |a x b|^2.
Energy energy(const Numbers& x, std::span<const ClosePair> pairs) {
  Energy e{0, Numbers(x.size())};
  for (Index v = kFirstFree; v < x.size() / 3; ++v) {
    e.value += kWeight * x[3 * v + 2];
    e.add(v, {0, 0, kWeight});
  }
  for (const ClosePair& pair : pairs) {
    const double d = pair.distance, gap = d - kReach, scale = kStiffness * pair.count;
    if (gap >= 0) continue;  // listed for the sake of rounding
    const double b = -gap * gap * std::log(d / kReach),
                 slope = -2 * gap * std::log(d / kReach) - gap * gap / d;
    double m = 1;
    const auto& v = pair.vertices;
    if (pair.mollifier_threshold > 0) {
      const Vec3 a = at(x, v[1]) - at(x, v[0]), o = at(x, v[3]) - at(x, v[2]);
      const double y = a.cross(o).squaredNorm() / pair.mollifier_threshold;
      m = (2 - y) * y;
      const double m_slope = 2 * (1 - y) / pair.mollifier_threshold * scale * b;
      const Vec3 of_a = 2 * m_slope * (o.squaredNorm() * a - a.dot(o) * o);
      const Vec3 of_o = 2 * m_slope * (a.squaredNorm() * o - a.dot(o) * a);
      e.add(v[1], of_a);
      e.add(v[0], -of_a);
      e.add(v[3], of_o);
      e.add(v[2], -of_o);
    }
    e.value += scale * m * b;
    for (int k = 0; k < 4; ++k) e.add(v[k], scale * m * slope * pair.weights[k] * pair.normal);
  }
  return e;
}

Energy energy_at(ContactChecker& checker, const Numbers& x) {
  std::vector<ClosePair> pairs;
  if (!checker.close_pairs(x, kReach, pairs))
    std::abort();  // for errors: wrong sizes, numbers that are not finite
  return energy(x, pairs);
}

}  // namespace

int main() {
  // A square of two triangles, and a rod nearly along their common edge.
  Numbers x = {-1, -1, 0, 1, -1, 0, -1, 1, 0, 1, 1, 0, 0.5, -0.51, 0.08, -0.5, 0.5, 0.3};
  const auto mesh = CollisionMesh::make(x, {{4, 5}}, {{0, 1, 2}, {2, 1, 3}});
  if (!mesh) return std::puts(mesh.error().line().c_str()), 1;
  ContactChecker checker(std::make_shared<const CollisionMesh>(*mesh));

  double worst = 0;
  for (int i = 0; i < 400; ++i) {
    const Energy now = energy_at(checker, x);
    Numbers target = x;
    for (std::size_t k = 3 * kFirstFree; k < x.size(); ++k) target[k] -= 0.2 * now.gradient[k];
    if (i % 40 == 0) {  // central differences
      for (std::size_t k = 3 * kFirstFree; k < x.size(); ++k) {
        Numbers up = x, down = x;
        up[k] += 1e-7;
        down[k] -= 1e-7;
        const double difference = (energy_at(checker, up).value - energy_at(checker, down).value) / 2e-7;
        worst = std::max(worst, std::abs(difference - now.gradient[k]));
      }
    }
    double share = checker.collision_free_step_size(x, target)->share;
    Numbers next(x.size());
    do {
      step_towards(x, target, share, next);
      share /= 2;
    } while (energy_at(checker, next).value > now.value && share > 1e-12);
    x = next;
  }
  std::printf("the rod rests %.3f to %.3f above the floor; the gradient agrees with differences: %s\n",
              std::min(x[14], x[17]), std::max(x[14], x[17]), worst < 1e-5 ? "yes" : "no");
}
