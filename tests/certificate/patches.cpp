#include "certificate/patches.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "foldproof/eigen.h"
#include "mesh/grid.h"

namespace foldproof::testing {

double log_uniform(Rng& rng, double low, double high) {
  return std::exp(uniform(rng, std::log(low), std::log(high)));
}

Vec3 random_direction(Rng& rng) {
  for (;;) {
    const double z = uniform(rng, -1, 1), y = uniform(rng, -1, 1), x = uniform(rng, -1, 1);
    const Vec3 d(x, y, z);
    if (d.norm() > 0.1 && d.norm() < 1) return d.normalized();
  }
}

Vec3 random_vector(Rng& rng, double low, double high) {
  const Vec3 direction = random_direction(rng);
  return uniform(rng, low, high) * direction;
}

PosedPatch sheet(std::string name, int columns, int rows, const Surface& surface) {
  PosedPatch p{std::move(name), {}, {}};
  for (int j = 0; j <= rows; ++j) {
    for (int i = 0; i <= columns; ++i) {
      p.patch.vertices.push_back(static_cast<Index>(p.x.size()));
      p.x.push_back(surface(double(i) / columns, double(j) / rows));
    }
  }
  for (const Triangle& t : Grid{static_cast<Index>(columns), static_cast<Index>(rows)}.triangles()) {
    const auto at = [&](std::size_t corner) { return static_cast<std::uint16_t>(t[corner]); };
    p.patch.triangles.push_back({at(0), at(1), at(2)});
  }
  return p;
}

PosedPatch part_of(const PosedPatch& whole, const std::function<bool(std::size_t)>& keep) {
  PosedPatch part{whole.name, {}, {}};
  std::vector<int> number(whole.x.size(), -1);
  for (std::size_t k = 0; k < whole.patch.triangles.size(); ++k) {
    if (!keep(k)) continue;
    auto& t = part.patch.triangles.emplace_back();
    for (int c = 0; c < 3; ++c) {
      const std::uint16_t v = whole.patch.triangles[k][c];
      if (number[v] < 0) {
        number[v] = static_cast<int>(part.x.size());
        part.patch.vertices.push_back(static_cast<Index>(part.x.size()));
        part.x.push_back(whole.x[v]);
      }
      t[c] = static_cast<std::uint16_t>(number[v]);
    }
  }
  return part;
}

namespace {

Vec3 flat(double u, double v) { return {0.5 * u - 0.25, 0.5 * v - 0.25, 0}; }

PosedPatch fan(Rng& rng) {
  PosedPatch p{"fan", {}, {Vec3::Zero()}};
  constexpr int kSpokes = 9;
  for (int k = 0; k < kSpokes; ++k) {
    const double angle = 2 * std::numbers::pi * (k + uniform(rng, -0.3, 0.3)) / kSpokes;
    const double radius = uniform(rng, 0.1, 0.3);
    p.x.emplace_back(radius * std::cos(angle), radius * std::sin(angle), uniform(rng, -0.03, 0.03));
    p.patch.triangles.push_back(
        {0, static_cast<std::uint16_t>(k + 1), static_cast<std::uint16_t>((k + 1) % kSpokes + 1)});
  }
  for (std::size_t v = 0; v < p.x.size(); ++v) p.patch.vertices.push_back(static_cast<Index>(v));
  return p;
}

}  // namespace

std::vector<PosedPatch> chartable_patches(Rng& rng) {
  std::vector<PosedPatch> all;
  all.push_back(sheet("flat", 4, 4, flat));
  all.push_back(sheet("bumpy", 5, 4, [&](double u, double v) {
    const double z = uniform(rng, -0.04, 0.04), y = uniform(rng, -0.02, 0.02), x = uniform(rng, -0.02, 0.02);
    return Vec3(flat(u, v) + Vec3(x, y, z));
  }));
  all.push_back(sheet("cap", 5, 5, [](double u, double v) {
    const double a = 2.2 * (u - 0.5), b = 2.2 * (v - 0.5);
    return Vec3(0.3 * std::sin(a), 0.3 * std::sin(b) * std::cos(a), 0.3 * std::cos(a) * std::cos(b));
  }));
  const PosedPatch grid = sheet("hole", 5, 5, flat);
  // Without the cell in the middle.
  all.push_back(part_of(grid, [](std::size_t t) { return t / 2 != 12; }));
  // The cells (0,0), (0,1) and (1,2), (1,3) of a grid touch in one vertex only.
  const PosedPatch narrow = sheet("touching_in_a_vertex", 2, 4, flat);
  all.push_back(part_of(narrow, [](std::size_t t) {
    const std::size_t i = t / 2 % 2, j = t / 2 / 2;
    return (i == 0) == (j < 2);
  }));
  const PosedPatch not_convex = sheet("not_convex", 5, 4, flat);
  all.push_back(part_of(not_convex, [](std::size_t t) { return t / 2 % 5 != 2 || t / 2 / 5 == 0; }));
  all.push_back(sheet("strip", 20, 1, [](double u, double v) {
    return Vec3(0.5 * u - 0.25, 0.03 * v + 0.05 * std::sin(6 * u), 0.02 * std::cos(9 * u));
  }));
  all.push_back(fan(rng));
  all.push_back(sheet("slivers", 12, 2, [&](double u, double v) {
    // The columns become narrower and narrower.
    return Vec3(0.5 * u * u * u - 0.25, 0.5 * v - 0.25, 0.01 * std::sin(20 * v));
  }));
  return all;
}

Chart::Chart(const Patch& patch, const UvMap& uv_map) : vertices(patch.vertices), triangles(patch.triangles) {
  for (std::size_t i = 0; i < uv_map.uvs.size(); ++i) {
    points.push_back({static_cast<float>(uv_map.uvs[i][0]), static_cast<float>(uv_map.uvs[i][1]),
                      static_cast<float>(uv_map.heights[i])});
  }
  for (const Uv corner : kChartCorners)
    points.push_back({static_cast<float>(corner[0]), static_cast<float>(corner[1]), 0});
  triangles.insert(triangles.end(), uv_map.scaffold.begin(), uv_map.scaffold.end());
  for (const auto& t : triangles) weights.push_back(weight_of(points, t));
  fit = fit_of(points, triangles);
}

ChartOutcome parametrize(const Patch& patch, std::span<const Vec3> x, UvMap& out) {
  std::vector<std::array<float, 3>> positions;
  for (const Vec3& p : x)
    positions.push_back({static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())});
  Parametrizer parametrizer;
  return parametrizer.build(patch, positions, parametrizer.facing(patch, positions), out);
}

Step::Step(std::vector<Vec3> from, std::vector<Vec3> to) : x0(std::move(from)), x1(std::move(to)) {
  for (std::size_t v = 0; v < x0.size(); ++v) {
    MovingVertex& m = vertices.emplace_back();
    for (int axis = 0; axis < 3; ++axis) {
      m.x[axis] = static_cast<float>(x0[v][axis]);
      m.x[4 + axis] = static_cast<float>(x1[v][axis]);
    }
    m.x[3] = m.x[7] = 0;
  }
}

std::vector<Vec3> deformed(std::span<const Vec3> x, double amplitude, double roughness, Rng& rng) {
  std::vector<Vec3> result(x.begin(), x.end());
  for (int wave = 0; wave < 3; ++wave) {
    const Vec3 direction = random_direction(rng), frequency = 12 * random_direction(rng);
    const double phase = uniform(rng, 0, 6);
    for (std::size_t v = 0; v < x.size(); ++v)
      result[v] += amplitude / 3 * std::sin(frequency.dot(x[v]) + phase) * direction;
  }
  for (Vec3& p : result) p += amplitude * roughness * random_vector(rng, 0, 1);
  return result;
}

std::vector<Vec3> moved(std::span<const Vec3> x, double angle, double shift, Rng& rng) {
  const Eigen::AngleAxisd rotation(angle, to_eigen(random_direction(rng)));
  const Vec3 translation = shift * random_vector(rng, 0, 1);
  std::vector<Vec3> result;
  for (const Vec3& p : x) result.push_back(to_vec3(rotation * to_eigen(p)) + translation);
  return result;
}

void fit_into_frame(std::vector<Vec3>& x0, std::vector<Vec3>& x1) {
  Vec3 low = Vec3::Constant(1e300), high = -low;
  for (const auto* x : {&x0, &x1}) {
    for (const Vec3& p : *x) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
  }
  if (low.minCoeff() > -0.99 && high.maxCoeff() < 0.99) return;
  const Vec3 middle = (low + high) / 2;
  const double scale = std::min(1.0, 1.9 / (high - low).maxCoeff());
  for (auto* x : {&x0, &x1}) {
    for (Vec3& p : *x) p = (p - middle) * scale;
  }
}

Step random_step(const PosedPatch& patch, double amplitude, Rng& rng) {
  const double roughness = rng() % 2 ? 0.1 : 1;
  const double angle = uniform(rng, 0, 3);
  std::vector<Vec3> x0 = moved(deformed(patch.x, amplitude, roughness, rng), angle, 0.3, rng);
  std::vector<Vec3> x1 = deformed(x0, amplitude, roughness, rng);
  x1 = moved(x1, rng() % 4 ? uniform(rng, 0, 1) : uniform(rng, 0, 3), 0.3, rng);
  fit_into_frame(x0, x1);
  return {std::move(x0), std::move(x1)};
}

}  // namespace foldproof::testing
