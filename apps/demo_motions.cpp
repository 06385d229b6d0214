#include "demo_motions.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace foldproof {
namespace {

constexpr Index kAround = 18, kAlong = 72;  // of the tube of the legs, from the left foot to the right one
constexpr Index kSkirtAround = 48, kSkirtRows = 14;
constexpr double kHip = 0.13, kLeg = 0.85, kRadius = 0.085;

using std::numbers::pi;

/// Where the middle of a leg is; u: 0 at the hip, 1 at the foot; side: -1 left, 1 right.
Vec3 middle_of_leg(double u, double side, const Stride& stride) {
  const double angle = side * stride.swing * std::sin(2 * pi * stride.phase);
  const double out = side * kHip * (1 - stride.narrow * u * u);
  return {out, kLeg * u * u * (1.5 - 0.5 * u) * std::sin(angle),
          -kLeg * u * std::cos(angle)};  // bends at the hip
}

/// Where the middle of the tube is; s: -1 at the left foot, 1 at the right one, in between over the hips.
Vec3 middle(double s, const Stride& stride) {
  constexpr double kArch = 0.25;
  const double side = s < 0 ? -1 : 1, distance = std::abs(s);
  if (distance >= kArch) return middle_of_leg((distance - kArch) / (1 - kArch), side, stride);
  const double turn = pi / 2 * distance / kArch;
  return {side * kHip * std::sin(turn), 0, kHip * std::cos(turn)};
}

/// Thinner towards the feet, whose ends are round.
double tube_radius(double s) {
  const double end = std::min(1.0, (1 - std::abs(s)) / 0.09);
  return kRadius * (1.25 - 0.45 * std::abs(s)) * std::sqrt(1 - (1 - end) * (1 - end));
}

/// Computed with z up; y is up in files.
void add_vertex(const Vec3& p, std::vector<double>& x) { x.insert(x.end(), {p[0], p[2], -p[1]}); }

std::vector<double> pose_of_legs(const Stride& stride) {
  std::vector<double> x;
  add_vertex(middle(-1, stride), x);
  for (Index j = 1; j < kAlong; ++j) {
    const double s = 2.0 * j / kAlong - 1, d = 1e-4;
    const Vec3 along = (middle(s + d, stride) - middle(s - d, stride)).normalized();
    const Vec3 a = Vec3(0, 1, 0).cross(along).normalized(), b = along.cross(a);
    for (Index i = 0; i < kAround; ++i) {
      const double turn = 2 * pi * i / kAround;
      add_vertex(middle(s, stride) + tube_radius(s) * (std::cos(turn) * a + std::sin(turn) * b), x);
    }
  }
  add_vertex(middle(1, stride), x);
  return x;
}

/// Triangles between rings of `around` vertices, the first of which is `first`.
void add_rings(Index first, Index around, Index rings, std::vector<Triangle>& out) {
  for (Index j = 0; j + 1 < rings; ++j) {
    for (Index i = 0; i < around; ++i) {
      const Index a = first + j * around + i, b = first + j * around + (i + 1) % around;
      out.push_back({a, b, a + around});
      out.push_back({b, b + around, a + around});
    }
  }
}

std::vector<Triangle> triangles_of_legs() {
  std::vector<Triangle> triangles;
  const Index last_ring = 1 + (kAlong - 2) * kAround, last = last_ring + kAround;
  for (Index i = 0; i < kAround; ++i) {
    const Index next = (i + 1) % kAround;
    triangles.push_back({0, 1 + next, 1 + i});
    triangles.push_back({last, last_ring + i, last_ring + next});
  }
  add_rings(1, kAround, kAlong - 1, triangles);
  return triangles;
}

std::vector<double> pose_of_skirt(const Stride& stride) {
  std::vector<double> x;
  const double sway = 0.06 * std::sin(2 * pi * stride.phase);
  for (Index j = 0; j < kSkirtRows; ++j) {
    const double down = static_cast<double>(j) / (kSkirtRows - 1);
    for (Index i = 0; i < kSkirtAround; ++i) {
      const double turn = 2 * pi * i / kSkirtAround;
      const double fold = 1 + 0.06 * down * std::sin(12 * turn);
      add_vertex({(0.28 + 0.12 * down) * fold * std::cos(turn) + sway * down,
                  (0.17 + 0.05 * down) * fold * std::sin(turn), 0.08 - 0.5 * down},
                 x);
    }
  }
  return x;
}

std::unique_ptr<Motion> motion(std::string name, std::vector<Triangle> triangles,
                               std::vector<double> (*pose)(const Stride&),
                               const std::vector<Stride>& strides) {
  std::vector<std::vector<double>> frames;
  frames.reserve(strides.size());
  for (const Stride& stride : strides) frames.push_back(pose(stride));
  const auto vertices = static_cast<Index>(frames.front().size() / 3);
  return memory_motion(std::move(name), Topology::make(vertices, std::move(triangles)).value(),
                       std::move(frames));
}

}  // namespace

std::unique_ptr<Motion> legs(std::string name, const std::vector<Stride>& strides) {
  return motion(std::move(name), triangles_of_legs(), pose_of_legs, strides);
}

std::unique_ptr<Motion> skirt(std::string name, const std::vector<Stride>& strides) {
  std::vector<Triangle> triangles;
  add_rings(0, kSkirtAround, kSkirtRows, triangles);
  return motion(std::move(name), std::move(triangles), pose_of_skirt, strides);
}

std::vector<std::string> leg_parts() {
  std::vector<std::string> parts;
  for (const Triangle& triangle : triangles_of_legs()) {
    const Index ring = (*std::ranges::max_element(triangle) + kAround - 1) / kAround;
    parts.emplace_back(3 * ring < kAlong ? "leg_L" : 3 * ring > 2 * kAlong ? "leg_R" : "hips");
  }
  return parts;
}

}  // namespace foldproof
