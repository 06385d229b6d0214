#include "generated.h"
#include "foldproof/eigen.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include <Eigen/Geometry>

namespace foldproof::bench {
namespace {

using Frame = std::vector<double>;

/// The shape at rest: one point per vertex, and triangles.
struct Rest {
  std::vector<Vec3> points;
  std::vector<Triangle> triangles;
};

/// Moves every point with `shape(point, t)` for t = 0, 1/(frames-1), ..., 1.
template <class Shape>
std::unique_ptr<Motion> animate(const char* name, const Rest& rest, Index frames, Shape shape) {
  std::vector<Frame> sequence(frames);
  for (Index k = 0; k < frames; ++k) {
    const double t = static_cast<double>(k) / (frames - 1);
    for (const Vec3& p : rest.points) {
      const Vec3 moved = shape(p, t);
      // Rounded to single precision, as a point cache would: then all competitors get exactly the same
      // numbers.
      for (int c = 0; c < 3; ++c) sequence[k].push_back(static_cast<float>(moved[c]));
    }
  }
  auto topology = Topology::make(static_cast<Index>(rest.points.size()), rest.triangles);
  return memory_motion(name, std::move(*topology), std::move(sequence));
}

/// Where a straight line along x goes when a stretch of it, `bend_length` long and centerd at 0, is bent by
/// `angle`. `offset` is the distance from the line towards the inside of the bend.
struct Bent {
  double along, towards;
};
Bent bend(double s, double offset, double bend_length, double angle) {
  const double curvature = angle / bend_length;
  const double inside = std::clamp(s, -bend_length / 2, bend_length / 2);
  const double turned = inside * curvature, rest = s - inside;
  const bool straight = std::abs(angle) < 1e-9;
  const double x = straight ? inside : std::sin(turned) / curvature;
  const double y = straight ? 0 : (1 - std::cos(turned)) / curvature;
  return {x + rest * std::cos(turned) - offset * std::sin(turned),
          y + rest * std::sin(turned) + offset * std::cos(turned)};
}

Rest tube(Index around, Index along, double length) {
  Rest rest;
  for (Index i = 0; i <= along; ++i)
    for (Index j = 0; j < around; ++j) {
      const double angle = 2 * std::numbers::pi * j / around;
      rest.points.push_back(
          {length * (static_cast<double>(i) / along - 0.5), std::cos(angle), std::sin(angle)});
    }
  for (Index i = 0; i < along; ++i)
    for (Index j = 0; j < around; ++j) {
      const Index a = i * around + j, b = i * around + (j + 1) % around;
      rest.triangles.push_back({a, b, a + around});
      rest.triangles.push_back({b, b + around, a + around});
    }
  const Index first = static_cast<Index>(rest.points.size()), last = first + 1, ring = along * around;
  rest.points.push_back({-length / 2, 0, 0});
  rest.points.push_back({length / 2, 0, 0});
  for (Index j = 0; j < around; ++j) {
    const Index next = (j + 1) % around;
    rest.triangles.push_back({first, next, j});
    rest.triangles.push_back({last, ring + j, ring + next});
  }
  return rest;
}

/// Twelve corners, twenty triangles: two poles and two rings of five, the lower turned by half a corner.
Rest icosahedron() {
  Rest rest;
  const double height = 1 / std::sqrt(5.0), radius = 2 / std::sqrt(5.0);
  rest.points.push_back({0, 0, 1});
  for (int ring = 0; ring < 2; ++ring)
    for (int k = 0; k < 5; ++k) {
      const double angle = 2 * std::numbers::pi * (k + 0.5 * ring) / 5;
      rest.points.push_back(
          {radius * std::cos(angle), radius * std::sin(angle), ring == 0 ? height : -height});
    }
  rest.points.push_back({0, 0, -1});
  for (Index k = 0; k < 5; ++k) {
    const Index upper = 1 + k, upper_next = 1 + (k + 1) % 5, lower = 6 + k, lower_next = 6 + (k + 1) % 5;
    rest.triangles.push_back({0, upper, upper_next});
    rest.triangles.push_back({upper, lower, upper_next});
    rest.triangles.push_back({upper_next, lower, lower_next});
    rest.triangles.push_back({lower, 11, lower_next});
  }
  return rest;
}

/// Every triangle into four, the new points pushed out to the unit sphere.
Rest subdivide(Rest coarse) {
  Rest fine;
  fine.points = std::move(coarse.points);
  std::map<Edge, Index> middles;
  const auto middle = [&](Index a, Index b) {
    const auto [place, is_new] = middles.try_emplace({std::min(a, b), std::max(a, b)}, fine.points.size());
    if (is_new) fine.points.push_back((fine.points[a] + fine.points[b]).normalized());
    return place->second;
  };
  for (const auto& [a, b, c] : coarse.triangles) {
    const Index ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
    for (const Triangle& t : {Triangle{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}})
      fine.triangles.push_back(t);
  }
  return fine;
}

Rest sheet(Index side) {
  Rest rest;
  for (Index i = 0; i <= side; ++i)
    for (Index j = 0; j <= side; ++j)
      rest.points.push_back({static_cast<double>(i) / side - 0.5, 0, static_cast<double>(j) / side - 0.5});
  for (Index i = 0; i < side; ++i)
    for (Index j = 0; j < side; ++j) {
      const Index a = i * (side + 1) + j, b = a + side + 1;
      rest.triangles.push_back({a, a + 1, b});
      rest.triangles.push_back({a + 1, b + 1, b});
    }
  return rest;
}

}  // namespace

std::unique_ptr<Motion> bending_cylinder() {
  constexpr double kLength = 30, kBendLength = 9;
  const double final_angle = 230 * std::numbers::pi / 180;
  return animate("bending-cylinder", tube(64, 160, kLength), 25, [=](const Vec3& p, double t) {
    const Bent at = bend(p.x(), p.y(), kBendLength, t * final_angle);
    return Vec3(at.along, at.towards, p.z());
  });
}

std::unique_ptr<Motion> squashed_sphere() {
  Rest rest = icosahedron();
  for (int level = 0; level < 6; ++level) rest = subdivide(std::move(rest));
  return animate("squashed-sphere", rest, 25, [](const Vec3& p, double t) {
    return Vec3(p.x() * (1 + 0.4 * t), p.y() * (1 + 0.4 * t), p.z() * (1 - 0.9 * t));
  });
}

std::unique_ptr<Motion> folding_cloth() {
  constexpr Index kSide = 212;
  constexpr double kBendLength =
      0.06;  // Leaves a gap of 2 * 0.06 / pi, eight triangles wide, between the layers.
  return animate("folding-cloth", sheet(kSide), 25, [=](const Vec3& p, double t) {
    const Bent at = bend(p.x(), 0, kBendLength, t * std::numbers::pi);
    return Vec3(at.along, at.towards, p.z());
  });
}

std::unique_ptr<Motion> pressed_cloths() {
  constexpr Index kSide = 150;
  Rest rest = sheet(kSide);
  const auto count = static_cast<Index>(rest.points.size());
  for (Index v = 0; v < count; ++v) rest.points.push_back(rest.points[v] + Vec3(0, 1, 0));
  for (std::size_t t = 0, end = rest.triangles.size(); t < end; ++t) {
    const auto [a, b, c] = rest.triangles[t];
    rest.triangles.push_back({a + count, b + count, c + count});
  }
  return animate("pressed-cloths", rest, 25, [](const Vec3& p, double t) {
    // Bumps are fifteen triangles long and 0.3 triangles high; where they are highest they reach through the
    // other sheet by a fiftieth of a triangle.
    const double edge = 1.0 / kSide, turn = 2 * std::numbers::pi / (15 * edge), upper = p.y();
    const double x = p.x() + 4 * edge * upper * t;
    const double wave = 0.05 * std::sin(8 * p.x() + 3 * t) * std::cos(6 * p.z());
    const double bump = 0.28 + 0.3 * std::sin(turn * x + 2 * t) * std::sin(turn * p.z());
    return Vec3(x, wave + upper * edge * bump, p.z());
  });
}

std::unique_ptr<Motion> ball_heap() {
  constexpr Index kAcross = 4;
  Rest ball = icosahedron();
  for (int level = 0; level < 3; ++level) ball = subdivide(std::move(ball));
  // Every ball is turned its own way, for else they would touch vertex to vertex, and stands two and a half
  // radii from the next: what is left over says which ball a vertex belongs to.
  constexpr double kApart = 2.5;
  Rest rest;
  for (Index place = 0; place < kAcross * kAcross * kAcross; ++place) {
    const Index x = place % kAcross, y = place / kAcross % kAcross, z = place / kAcross / kAcross;
    const Vec3 center = kApart * Vec3(x, y, z);
    const Eigen::Matrix3d turn =
        Eigen::AngleAxisd(0.7 * place, Eigen::Vector3d(1, 0.3 * place, 2).normalized()).toRotationMatrix();
    const auto first = static_cast<Index>(rest.points.size());
    for (const Vec3& p : ball.points) rest.points.push_back(center + to_vec3(turn * to_eigen(p)));
    for (const auto& [a, b, c] : ball.triangles) rest.triangles.push_back({a + first, b + first, c + first});
  }
  return animate("ball-heap", rest, 25, [=](const Vec3& p, double t) {
    const Vec3 center = to_vec3(to_eigen(p / kApart).array().round().matrix());
    // Pressed from above the balls grow wide; ever more of them overlap, by little.
    const Vec3 radii(1 + 0.1 * t, 1 + 0.1 * t, 1 - 0.2 * t);
    const double spacing = 2 - 0.02 * t;
    return Vec3((spacing * center + (p - kApart * center)).cwiseProduct(radii));
  });
}

std::unique_ptr<Motion> waving_cloth(Index side) {
  return animate("waving-cloth", sheet(side), 6, [](const Vec3& p, double t) {
    const double height = 0.06 * std::sin(9 * p.x() + 4 * p.z() - t) + 0.03 * std::sin(17 * p.z() + 2 * t) +
                          0.01 * std::sin(41 * p.x() - 23 * p.z() + 3 * t);
    return Vec3(p.x(), height, p.z() + 0.02 * std::sin(5 * p.x() + t));
  });
}

}  // namespace foldproof::bench
