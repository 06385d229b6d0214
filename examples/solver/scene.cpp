#include "scene.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "foldproof/eigen.h"

namespace example {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kClothMass = 0.3, kBallMass = 1.5, kBallRadius = 0.22;

Vec3 at(const Scene& scene, Index v) { return Vec3::load(&scene.x[3 * std::size_t{v}]); }

Index add_vertex(Scene& scene, const Vec3& x, double mass) {
  scene.x.insert(scene.x.end(), {x.x(), x.y(), x.z()});
  scene.mass.push_back(mass);
  return scene.vertex_count() - 1;
}

void add_spring(Scene& scene, Index a, Index b, double stiffness) {
  scene.springs.push_back({a, b, stiffness, (at(scene, a) - at(scene, b)).norm()});
}

// Springs along the threads, across the cells, and over two threads against bending.
void add_cloth(Scene& scene, Index n, double height) {
  const Index first = scene.vertex_count();
  const double cell = 1.0 / (n - 1);
  for (Index i = 0; i < n; ++i) {
    for (Index k = 0; k < n; ++k) {
      // A little askew, so that nothing is parallel to anything by chance.
      const Eigen::Vector3d p(i * cell - 0.38, k * cell - 0.43,
                              height + 0.01 * std::sin(3.0 * i * cell + 5.0 * k * cell));
      const Eigen::AngleAxisd turn(0.3, Eigen::Vector3d::UnitZ());
      add_vertex(scene, foldproof::to_vec3(turn * p), kClothMass / (n * n));
    }
  }
  const auto id = [&](Index i, Index k) { return first + i * n + k; };
  for (Index i = 0; i < n; ++i) {
    for (Index k = 0; k < n; ++k) {
      if (i + 1 < n) add_spring(scene, id(i, k), id(i + 1, k), 200);
      if (k + 1 < n) add_spring(scene, id(i, k), id(i, k + 1), 200);
      if (i + 2 < n) add_spring(scene, id(i, k), id(i + 2, k), 0.5);
      if (k + 2 < n) add_spring(scene, id(i, k), id(i, k + 2), 0.5);
      if (i + 1 == n || k + 1 == n) continue;
      add_spring(scene, id(i, k), id(i + 1, k + 1), 40);
      add_spring(scene, id(i + 1, k), id(i, k + 1), 40);
      if ((i + k) % 2 == 0) {
        scene.faces.push_back({id(i, k), id(i + 1, k), id(i + 1, k + 1)});
        scene.faces.push_back({id(i, k), id(i + 1, k + 1), id(i, k + 1)});
      } else {
        scene.faces.push_back({id(i, k), id(i + 1, k), id(i, k + 1)});
        scene.faces.push_back({id(i + 1, k), id(i + 1, k + 1), id(i, k + 1)});
      }
    }
  }
}

struct Sphere {
  std::vector<Vec3> points;
  std::vector<foldproof::Triangle> faces;
};

Sphere icosphere(int quartered) {
  const double g = (1 + std::sqrt(5.0)) / 2;
  Sphere s;
  for (const double a : {1.0, -1.0}) {
    for (const double b : {g, -g}) {
      s.points.emplace_back(0, a, b);
      s.points.emplace_back(a, b, 0);
      s.points.emplace_back(b, 0, a);
    }
  }
  // Three corners are a face when they are all at an edge's length, 2, from each other.
  for (Index i = 0; i < 12; ++i) {
    for (Index j = i + 1; j < 12; ++j) {
      for (Index k = j + 1; k < 12; ++k) {
        const Vec3 &p = s.points[i], &q = s.points[j], &r = s.points[k];
        if ((p - q).norm() > 2.1 || (q - r).norm() > 2.1 || (r - p).norm() > 2.1) continue;
        const bool outward = (q - p).cross(r - p).dot(p) > 0;
        s.faces.push_back(outward ? foldproof::Triangle{i, j, k} : foldproof::Triangle{i, k, j});
      }
    }
  }
  for (; quartered > 0; --quartered) {
    std::map<std::pair<Index, Index>, Index> middle;
    const auto between = [&](Index a, Index b) {
      const auto [at, added] = middle.try_emplace(std::minmax(a, b), static_cast<Index>(s.points.size()));
      if (added) s.points.push_back((s.points[a] + s.points[b]).normalized());
      return at->second;
    };
    for (Vec3& p : s.points) p = p.normalized();
    std::vector<foldproof::Triangle> quarters;
    for (const auto& [a, b, c] : s.faces) {
      const Index ab = between(a, b), bc = between(b, c), ca = between(c, a);
      quarters.insert(quarters.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    s.faces = std::move(quarters);
  }
  return s;
}

// Springs along the edges, across them against bending, and to the center, which is inside and collides with
// nothing.
void add_ball(Scene& scene, int quartered, const Vec3& center) {
  const Sphere sphere = icosphere(quartered);
  const Index first = scene.vertex_count();
  const double share = kBallMass / (static_cast<double>(sphere.points.size()) + 1);
  for (const Vec3& p : sphere.points) add_vertex(scene, center + kBallRadius * p.normalized(), share);
  const Index middle = add_vertex(scene, center, share);
  const double radial = 4000.0 / static_cast<double>(sphere.points.size());
  for (Index v = first; v < middle; ++v) add_spring(scene, v, middle, radial);
  std::map<std::pair<Index, Index>, Index> opposite;
  for (const auto& f : sphere.faces) {
    scene.faces.push_back({first + f[0], first + f[1], first + f[2]});
    for (int k = 0; k < 3; ++k) {
      const Index a = first + f[k], b = first + f[(k + 1) % 3], c = first + f[(k + 2) % 3];
      const auto [at, added] = opposite.try_emplace(std::minmax(a, b), c);
      if (added) continue;
      add_spring(scene, a, b, 150);
      add_spring(scene, at->second, c, 30);
    }
  }
}

// Flat, or a bowl that rises with the square of the distance from its middle.
void add_floor(Scene& scene, double rise = 0) {
  const Index cells = rise > 0 ? 16 : 8;
  const Index first = scene.floor_begin = scene.movable = scene.vertex_count();
  for (Index i = 0; i <= cells; ++i) {
    for (Index k = 0; k <= cells; ++k) {
      const double x = 3.0 * i / cells - 1.5, y = 3.0 * k / cells - 1.5;
      add_vertex(scene, Vec3(x, y, rise * (x * x + y * y)), 1);
    }
  }
  for (Index i = 0; i < cells; ++i) {
    for (Index k = 0; k < cells; ++k) {
      const Index v = first + i * (cells + 1) + k;
      scene.faces.push_back({v, v + cells + 1, v + 1});
      scene.faces.push_back({v + 1, v + cells + 1, v + cells + 2});
    }
  }
}

// A vertex at each ring's center, which collides with nothing, holds it open.
void add_rod(Scene& scene, Index around, Index rings, double radius, double length) {
  constexpr double kMass = 2;
  const double share = kMass / (rings * (around + 1.0));
  for (Index r = 0; r < rings; ++r) {
    const double z = length * r / (rings - 1);
    const Vec3 center(z - length / 2, 1e-3 * std::sin(9 * z),
                      1);  // a little bent, so that it knows where to go
    for (Index k = 0; k < around; ++k) {
      const double angle = 2 * kPi * (k + 0.5 * (r % 2)) / around;
      add_vertex(scene, center + radius * Vec3(0, std::cos(angle), std::sin(angle)), share);
    }
    add_vertex(scene, center, share);
  }
  const auto id = [&](Index r, Index k) { return r * (around + 1) + k % around; };
  const auto center = [&](Index r) { return r * (around + 1) + around; };
  for (Index r = 0; r < rings; ++r) {
    for (Index k = 0; k < around; ++k) {
      add_spring(scene, id(r, k), id(r, k + 1), 200);
      add_spring(scene, id(r, k), id(r, k + 2), 2);
      add_spring(scene, id(r, k), center(r), 400.0 / around);
      if (r + 2 < rings) add_spring(scene, id(r, k), id(r + 2, k), 2);
      if (r + 1 == rings) continue;
      // Odd rings are turned by half a cell, so that a cell's short diagonal changes sides.
      const Index left = id(r + 1, r % 2 == 0 ? k + around - 1 : k),
                  right = id(r + 1, r % 2 == 0 ? k : k + 1);
      add_spring(scene, id(r, k), left, 200);
      add_spring(scene, id(r, k), right, 200);
      scene.faces.push_back({id(r, k), right, left});
      scene.faces.push_back({id(r, k), id(r, k + 1), right});
    }
    if (r + 1 < rings) add_spring(scene, center(r), center(r + 1), 200);
    if (r + 2 < rings) add_spring(scene, center(r), center(r + 2), 20);
  }
}

}  // namespace

Scene cloth_on_ball(Index cloth, int ball) {
  Scene scene;
  add_cloth(scene, cloth, 2 * kBallRadius + 0.05);
  add_ball(scene, ball, Vec3(0, 0, kBallRadius + 0.008));
  add_floor(scene);
  return scene;
}

Scene pile_of_balls(int quartered) {
  Scene scene;
  const double half = kBallRadius + 0.005;
  for (const auto& [x, y] : {std::pair(-1., -1.), std::pair(1., -1.), std::pair(-1., 1.), std::pair(1., 1.)})
    add_ball(scene, quartered, Vec3(half * x, half * y, 0.45));
  // Above where two and four meet, a little off, so that they settle.
  add_ball(scene, quartered, Vec3(-0.06 * half, -0.96 * half, 0.45 + 1.8 * half));
  add_ball(scene, quartered, Vec3(0.05 * half, 1.03 * half, 0.45 + 1.8 * half));
  add_floor(scene, 0.8);
  return scene;
}

Scene twisted_rod(Index around) {
  constexpr double kRadius = 0.05, kLength = 2, kTurns = 0.8, kNearer = 0.15;  // per second; m/s
  Scene scene;
  const double edge = 2 * kPi * kRadius / around;
  const auto rings = static_cast<Index>(kLength / (0.866 * edge)) + 1;
  add_rod(scene, around, rings, kRadius, kLength);
  scene.reach = std::min(scene.reach, 0.6 * edge);
  scene.movable = scene.floor_begin = scene.vertex_count();
  std::vector<Index> led;
  for (Index r = 0; r < rings; ++r) {
    if (r >= 3 && r + 3 < rings) continue;
    for (Index k = 0; k <= around; ++k) led.push_back(r * (around + 1) + k);
  }
  for (const Index v : led) scene.mass[v] *= 1e3;
  scene.lead = [led, start = scene.x](double seconds, std::span<double> x) {
    for (const Index v : led) {
      const Vec3 from = Vec3::load(&start[3 * std::size_t{v}]);
      const double side = from.x() < 0 ? -1 : 1;
      const Vec3 axis(from.x() - side * kNearer * seconds, 0, 1);
      const Eigen::AngleAxisd turn(side * 2 * kPi * kTurns * seconds, Eigen::Vector3d::UnitX());
      const Vec3 to = axis + foldproof::to_vec3(turn * Eigen::Vector3d(0, from.y(), from.z() - 1));
      to.store(&x[3 * std::size_t{v}]);
    }
  };
  return scene;
}

}  // namespace example
