#include "scene.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

namespace example {
namespace {

constexpr double kClothMass = 0.3, kBallMass = 1.5, kBallRadius = 0.22;

Eigen::Map<const Vec3> at(const Scene& scene, Index v) {
  return Eigen::Map<const Vec3>(&scene.x[3 * std::size_t{v}]);
}

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
      const Vec3 p(i * cell - 0.38, k * cell - 0.43,
                   height + 0.01 * std::sin(3.0 * i * cell + 5.0 * k * cell));
      add_vertex(scene, Eigen::AngleAxisd(0.3, Vec3::UnitZ()) * p, kClothMass / (n * n));
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
    for (Vec3& p : s.points) p.normalize();
    std::vector<foldproof::Triangle> quarters;
    for (const auto& [a, b, c] : s.faces) {
      const Index ab = between(a, b), bc = between(b, c), ca = between(c, a);
      quarters.insert(quarters.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    s.faces = std::move(quarters);
  }
  return s;
}

// Springs along the edges, across them against bending, and to the centre, which is inside and collides with
// nothing.
void add_ball(Scene& scene, int quartered, const Vec3& centre) {
  const Sphere sphere = icosphere(quartered);
  const Index first = scene.vertex_count();
  const double share = kBallMass / (static_cast<double>(sphere.points.size()) + 1);
  for (const Vec3& p : sphere.points) add_vertex(scene, centre + kBallRadius * p.normalized(), share);
  const Index middle = add_vertex(scene, centre, share);
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

void add_floor(Scene& scene) {
  constexpr Index kCells = 8;
  const Index first = scene.floor_begin = scene.movable = scene.vertex_count();
  for (Index i = 0; i <= kCells; ++i) {
    for (Index k = 0; k <= kCells; ++k)
      add_vertex(scene, Vec3(3.0 * i / kCells - 1.5, 3.0 * k / kCells - 1.5, 0), 1);
  }
  for (Index i = 0; i < kCells; ++i) {
    for (Index k = 0; k < kCells; ++k) {
      const Index v = first + i * (kCells + 1) + k;
      scene.faces.push_back({v, v + kCells + 1, v + 1});
      scene.faces.push_back({v + 1, v + kCells + 1, v + kCells + 2});
    }
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

}  // namespace example
