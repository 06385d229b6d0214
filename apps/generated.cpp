#include "generated.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <unordered_map>

namespace foldproof {
namespace {

using std::numbers::pi;

Topology make_topology(std::size_t vertices, std::vector<Triangle> triangles) {
  return std::move(*Topology::make(static_cast<Index>(vertices), std::move(triangles)));
}

std::vector<Triangle> cylinder_triangles(Index around, Index along) {
  const Index first_cap = (along + 1) * around, last_cap = first_cap + 1;
  std::vector<Triangle> triangles;
  for (Index i = 0; i < around; ++i) {
    const Index j = (i + 1) % around;
    for (Index ring = 0; ring < along; ++ring) {
      const Index low = ring * around, high = low + around;
      triangles.push_back({low + i, low + j, high + j});
      triangles.push_back({low + i, high + j, high + i});
    }
    triangles.push_back({j, i, first_cap});
    triangles.push_back({along * around + i, along * around + j, last_cap});
  }
  return triangles;
}

// --- The creature
// ------------------------------------------------------------------------------------------------

/// A capsule that may taper, and the joint that it turns around.
struct BoneShape {
  int parent;  // -1: none
  Vec3 joint, from, to;
  double radius_from, radius_to;
};

std::array<BoneShape, Creature::kBones> skeleton() {
  std::array<BoneShape, Creature::kBones> bones;
  bones[Creature::kBody] = {-1, {0, 0, 0}, {-0.95, 0.02, 0}, {0.8, 0, 0}, 0.42, 0.46};
  bones[Creature::kNeck] = {Creature::kBody, {0.95, 0.15, 0}, {0.95, 0.15, 0}, {1.4, 0.7, 0}, 0.32, 0.22};
  bones[Creature::kHead] = {Creature::kNeck, {1.4, 0.7, 0}, {1.45, 0.75, 0}, {1.9, 0.62, 0}, 0.27, 0.16};
  bones[Creature::kTail] = {Creature::kBody, {-1.3, 0.15, 0}, {-1.25, 0.15, 0}, {-2, 0.35, 0}, 0.13, 0.08};
  const auto leg = [&](int thigh, double x, double z, double knee) {
    const Vec3 hip(x, -0.15, z), joint(x + knee, -0.85, z * 1.1), foot(x, -1.55, z * 1.1);
    bones[thigh] = {Creature::kBody, hip, hip, joint, 0.24, 0.17};
    bones[thigh + 1] = {thigh, joint, joint, foot, 0.16, 0.13};
  };
  leg(Creature::kForeRightThigh, 0.8, 0.3, 0.03);
  leg(Creature::kForeLeftThigh, 0.8, -0.3, 0.03);
  leg(Creature::kHindRightThigh, -0.9, 0.3, -0.06);
  leg(Creature::kHindLeftThigh, -0.9, -0.3, -0.06);
  return bones;
}

double distance(const BoneShape& bone, const Vec3& x) {
  const Vec3 axis = bone.to - bone.from;
  const double t = std::clamp((x - bone.from).dot(axis) / axis.squaredNorm(), 0.0, 1.0);
  return (x - bone.from - t * axis).norm() - std::lerp(bone.radius_from, bone.radius_to, t);
}

/// Negative inside. Capsules flow into each other where they meet (polynomial smooth minimum).
double creature_field(std::span<const BoneShape> bones, const Vec3& x) {
  constexpr double kBlend = 0.1;
  double field = distance(bones[0], x);
  for (std::size_t k = 1; k < bones.size(); ++k) {
    const double other = distance(bones[k], x);
    const double near = std::max(kBlend - std::abs(field - other), 0.0) / kBlend;
    field = std::min(field, other) - near * near * kBlend / 4;
  }
  return field;
}

/// Surface nets (Gibson 1998): a vertex in every cell that the surface crosses, at the mean of its crossings,
/// and a quad around every grid edge that it crosses.
class SurfaceNet {
 public:
  SurfaceNet(const Vec3& low, const Vec3& high, double cell) : low_(low), cell_(cell) {
    for (int k = 0; k < 3; ++k) size_[k] = static_cast<std::size_t>(std::ceil((high[k] - low[k]) / cell)) + 1;
  }

  template <class Field>
  void run(const Field& field) {
    values_.resize(size_[0] * size_[1] * size_[2]);
    for_each(size_, [&](const Place& p) { values_[number(p)] = field(at(p)); });
    for_each({size_[0] - 1, size_[1] - 1, size_[2] - 1}, [&](const Place& p) { add_vertex(p); });
    for_each({size_[0] - 1, size_[1] - 1, size_[2] - 1}, [&](const Place& p) { add_quads(p); });
  }

  std::vector<Vec3> vertices;
  std::vector<Triangle> triangles;

 private:
  using Place = std::array<std::size_t, 3>;

  template <class Visit>
  static void for_each(const Place& size, const Visit& visit) {
    for (std::size_t x = 0; x < size[0]; ++x) {
      for (std::size_t y = 0; y < size[1]; ++y) {
        for (std::size_t z = 0; z < size[2]; ++z) visit(Place{x, y, z});
      }
    }
  }
  std::size_t number(const Place& p) const { return (p[0] * size_[1] + p[1]) * size_[2] + p[2]; }
  Vec3 at(const Place& p) const {
    return low_ +
           cell_ * Vec3(static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2]));
  }
  static Place corner(Place p, int k) { return {p[0] + (k & 1), p[1] + (k >> 1 & 1), p[2] + (k >> 2 & 1)}; }

  void add_vertex(const Place& p) {
    Vec3 sum = Vec3::Zero();
    int crossings = 0;
    for (int a = 0; a < 8; ++a) {
      for (int axis = 0; axis < 3; ++axis) {
        const int b = a | 1 << axis;
        if (b == a) continue;
        const double at_a = values_[number(corner(p, a))], at_b = values_[number(corner(p, b))];
        if ((at_a < 0) == (at_b < 0)) continue;
        const double t = at_a / (at_a - at_b);
        sum += (1 - t) * at(corner(p, a)) + t * at(corner(p, b));
        ++crossings;
      }
    }
    if (crossings == 0) return;
    vertex_of_[number(p)] = static_cast<Index>(vertices.size());
    vertices.push_back(sum / crossings);
  }

  void add_quads(const Place& p) {
    for (int axis = 0; axis < 3; ++axis) {
      const int u = (axis + 1) % 3, v = (axis + 2) % 3;
      if (p[u] == 0 || p[v] == 0) continue;
      Place next = p;
      ++next[axis];
      const bool inside = values_[number(p)] < 0;
      if (inside == (values_[number(next)] < 0)) continue;
      std::array<Index, 4> quad;
      for (int k = 0; k < 4; ++k) {
        Place cell = p;
        cell[u] -= k == 1 || k == 2 ? 1 : 0;
        cell[v] -= k >= 2 ? 1 : 0;
        quad[k] = vertex_of_.at(number(cell));
      }
      if (!inside) std::swap(quad[1], quad[3]);
      // The shorter diagonal makes the better triangles.
      const bool other =
          (vertices[quad[1]] - vertices[quad[3]]).norm() < (vertices[quad[0]] - vertices[quad[2]]).norm();
      if (other) std::rotate(quad.begin(), quad.begin() + 1, quad.end());
      triangles.push_back({quad[0], quad[1], quad[2]});
      triangles.push_back({quad[0], quad[2], quad[3]});
    }
  }

  Vec3 low_;
  double cell_;
  Place size_;
  std::vector<double> values_;
  std::unordered_map<std::size_t, Index> vertex_of_;
};

/// How much each bone moves a vertex: nearly all of it goes to the capsule it lies on.
std::array<float, Creature::kBones> skin_weights(std::span<const BoneShape> bones, const Vec3& x) {
  constexpr double kReach = 0.06, kLeast = 0.03;
  std::array<double, Creature::kBones> raw;
  double sum = 0;
  for (std::size_t k = 0; k < bones.size(); ++k) {
    raw[k] = std::exp(-std::max(distance(bones[k], x), -0.15) / kReach);
    sum += raw[k];
  }
  double kept = 0;
  for (double& weight : raw) {
    weight = weight / sum < kLeast ? 0 : weight;
    kept += weight;
  }
  std::array<float, Creature::kBones> weights;
  for (std::size_t k = 0; k < raw.size(); ++k) weights[k] = static_cast<float>(raw[k] / kept);
  return weights;
}

}  // namespace

Cylinder::Cylinder(Index around, Index along)
    : around_(around),
      along_(along),
      topology_(make_topology(std::size_t{around} * (along + 1) + 2, cylinder_triangles(around, along))) {}

std::vector<double> Cylinder::pose(double angle, double towards) const {
  constexpr double kRadius = 0.5, kLength = 10;
  const Vec3 side(0, std::cos(towards), std::sin(towards)), other(0, -std::sin(towards), std::cos(towards));
  const double ds = kLength / along_;
  const auto turned = [&](double s) {
    return angle * std::clamp((s - kLength / 3) / (kLength / 3), 0.0, 1.0);
  };
  std::vector<double> x;
  const auto add = [&](const Vec3& p) { x.insert(x.end(), {p.x(), p.y(), p.z()}); };
  Vec3 middle(-kLength / 2, 0, 0), first = middle;
  for (Index ring = 0; ring <= along_; ++ring) {
    const double turn = turned(ring * ds);
    const Vec3 out = std::cos(turn) * side - std::sin(turn) * Vec3::UnitX();
    for (Index i = 0; i < around_; ++i) {
      const double around = 2 * pi * i / around_;
      // Vertices keep their place around the axis, into whatever direction it bends.
      add(middle + kRadius * (std::cos(around - towards) * out + std::sin(around - towards) * other));
    }
    if (ring == along_) break;
    const double on = turned((ring + 0.5) * ds);
    middle += ds * (std::cos(on) * Vec3::UnitX() + std::sin(on) * side);
  }
  add(first);
  add(middle);
  return x;
}

Creature::Turns Creature::rest() {
  Turns turns;
  turns.fill(Vec3::Zero());
  return turns;
}

Creature::Creature(double cell) {
  const auto bones = skeleton();
  SurfaceNet net(Vec3(-2.3, -1.9, -0.9), Vec3(2.3, 1.3, 0.9), cell);
  net.run([&](const Vec3& x) { return creature_field(bones, x); });
  for (const Vec3& x : net.vertices) weights_.push_back(skin_weights(bones, x));
  rest_ = std::move(net.vertices);
  topology_ = make_topology(rest_.size(), std::move(net.triangles));
}

std::vector<double> Creature::pose(const Turns& turns) const {
  const auto bones = skeleton();
  std::array<Eigen::Affine3d, kBones> place;
  for (int k = 0; k < kBones; ++k) {  // parents come first
    const double angle = turns[k].norm();
    const Eigen::AngleAxisd turn(angle, angle > 0 ? Vec3(turns[k] / angle) : Vec3(Vec3::UnitX()));
    const Eigen::Affine3d own =
        Eigen::Translation3d(bones[k].joint) * turn * Eigen::Translation3d(-bones[k].joint);
    place[k] = bones[k].parent < 0 ? own : place[bones[k].parent] * own;
  }
  std::vector<double> x;
  x.reserve(3 * rest_.size());
  for (std::size_t v = 0; v < rest_.size(); ++v) {
    Vec3 sum = Vec3::Zero();
    for (int k = 0; k < kBones; ++k) {
      if (weights_[v][k] > 0) sum += double{weights_[v][k]} * (place[k] * rest_[v]);
    }
    x.insert(x.end(), {sum.x(), sum.y(), sum.z()});
  }
  return x;
}

}  // namespace foldproof
