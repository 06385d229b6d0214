// Prints: at rest within 20 sweeps: with one share no, with a share for each island yes
// Block descent: sheets of springs fall on floors of different heights; in each sweep every vertex goes to
// the minimum of its own energy. Where one share holds for all, the first contact stops the others.
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "foldproof/solver.h"

namespace {

using namespace foldproof;
using Numbers = std::vector<double>;

constexpr Index kSheets = 4, kSide = 4, kSheetVertices = kSheets * kSide * kSide;  // before those of floors
constexpr double kFall = 6, kReach = 0.05, kBarrier = 100, kSpring = 1;            // for a mass / step^2 of 1

Vec3 at(const Numbers& x, Index v) { return Vec3::load(&x[3 * v]); }

// A floor below each sheet, the k-th at the height -k. `neighbors`: those to which a spring goes.
CollisionMesh make_scene(Numbers& x, std::vector<std::vector<Index>>& neighbors) {
  std::vector<Triangle> faces;
  neighbors.resize(kSheetVertices);
  const auto connect = [&](Index a, Index b) {
    neighbors[a].push_back(b);
    neighbors[b].push_back(a);
  };
  for (Index v = 0; v < kSheetVertices; ++v) {
    const Index sheet = v / (kSide * kSide), row = v / kSide % kSide, column = v % kSide;
    x.insert(x.end(), {10.0 * sheet + row, 0.3 + 0.1 * row, 1.0 * column});
    if (row > 0) connect(v, v - kSide);
    if (column > 0) connect(v, v - 1);
    if (row == 0 || column == 0) continue;
    connect(v, v - kSide - 1);
    faces.push_back({v - kSide - 1, v - kSide, v});
    faces.push_back({v - kSide - 1, v, v - 1});
  }
  for (Index k = 0; k < kSheets; ++k) {
    const double left = 10.0 * k - 1, height = -1.0 * k;
    const Index v = static_cast<Index>(x.size() / 3);
    x.insert(x.end(), {left, height, -2, left + 8, height, -2, left, height, 12});
    faces.push_back({v, v + 2, v + 1});
  }
  return CollisionMesh::make(x, {}, faces).value();
}

// The slope of a vertex's energy, and its second derivatives, a symmetric matrix by rows.
struct Block {
  Vec3 slope;
  std::array<Vec3, 3> rows{Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};

  void add(const Vec3& direction, double first, double second) {
    slope += first * direction;
    for (int i = 0; i < 3; ++i) rows[i] += second * direction[i] * direction;
  }
  Vec3 newton_step() const {  // Cramer's rule
    const Vec3 a = rows[1].cross(rows[2]), b = rows[2].cross(rows[0]), c = rows[0].cross(rows[1]);
    return (slope.x() * a + slope.y() * b + slope.z() * c) / -rows[0].dot(a);
  }
};

// One sweep from x: where it leads.
Numbers sweep(const Numbers& x, const Numbers& rest, const std::vector<std::vector<Index>>& neighbors,
              std::span<const ClosePair> pairs) {
  Numbers wanted = x;
  for (Index v = 0; v < kSheetVertices; ++v) {
    Block block;
    block.slope = at(wanted, v) - at(rest, v) + Vec3{0, kFall, 0};  // where inertia and gravity lead
    for (const Index w : neighbors[v]) {
      const Vec3 d = at(wanted, v) - at(wanted, w);
      block.add(d.normalized(), kSpring * (d.norm() - (at(rest, v) - at(rest, w)).norm()), kSpring);
    }
    for (const ClosePair& pair : pairs) {
      double weight = 0, change = 0;  // the latter: of the distance, by what was moved before
      for (int k = 0; k < 4; ++k) {
        const Index w = pair.vertices[k];
        if (w == v) weight += pair.weights[k];
        change += pair.weights[k] * pair.normal.dot(at(wanted, w) - at(x, w));
      }
      const double d = pair.distance, gap = d - kReach, log = std::log(d / kReach);
      if (weight == 0 || gap >= 0) continue;  // not of this vertex; listed for the sake of rounding
      const double first = -2 * gap * log - gap * gap / d,
                   second = gap * gap / (d * d) - 4 * gap / d - 2 * log;
      const double scale = kBarrier * pair.count;
      block.add(weight * pair.normal, scale * (first + second * change), scale * second);
    }
    (at(wanted, v) + block.newton_step()).store(&wanted[3 * v]);
  }
  return wanted;
}

bool is_at_rest(bool islands, int sweeps) {
  Numbers x, shares;
  std::vector<std::vector<Index>> neighbors;
  ContactChecker checker(std::make_shared<const CollisionMesh>(make_scene(x, neighbors)));
  const Numbers rest = x;
  std::vector<ClosePair> pairs;
  double largest = 0;
  for (int i = 0; i < sweeps; ++i) {
    if (!checker.close_pairs(x, kReach, pairs)) std::abort();  // for errors: wrong sizes, numbers not finite
    const Numbers wanted = sweep(x, rest, neighbors, pairs);
    largest = 0;
    for (std::size_t k = 0; k < x.size(); ++k) largest = std::max(largest, std::abs(wanted[k] - x[k]));
    if (islands) {
      if (!checker.collision_free_step_sizes(x, wanted, shares)) std::abort();
    } else {
      shares.assign(x.size() / 3, checker.collision_free_step_size(x, wanted).value().share);
    }
    step_towards(x, wanted, shares, x);  // proven free
  }
  return largest < 1e-3;
}

}  // namespace

int main() {
  constexpr int kSweeps = 20;
  std::printf("at rest within %d sweeps: with one share %s, with a share for each island %s\n", kSweeps,
              is_at_rest(false, kSweeps) ? "yes" : "no", is_at_rest(true, kSweeps) ? "yes" : "no");
}
