#include "check/animations.h"

#include <array>
#include <cmath>
#include <numbers>

#include "mesh/grid.h"

namespace foldproof::oracle {
namespace {

using testing::Grid;

// There and back again: 0 .. 1 .. 0.
double to_and_fro(int step, int steps) { return 0.5 - 0.5 * std::cos(2 * std::numbers::pi * step / steps); }

constexpr int kSteps = 40;

// A sheet that is rolled up along its length until it touches itself, and unrolled.
Animation bending(Rng&) {
  Animation animation;
  const Grid sheet{60, 12};
  animation.topologies.push_back(sheet.topology());
  for (int k = 0; k <= kSteps; ++k) {
    const double angle = 0.05 + 7.2 * to_and_fro(k, kSteps);
    animation.poses.push_back({sheet.positions([&](double u, double v) {
      const double a = angle * (u - 0.5);
      return Vec3(std::sin(a) / angle, (1 - std::cos(a)) / angle + 0.002 * std::sin(20 * v), 0.3 * v);
    })});
  }
  return animation;
}

// A sheet that is folded flat onto itself along a line, and opened.
Animation folding(Rng& rng) {
  Animation animation;
  const Grid sheet{40, 16};
  animation.topologies.push_back(sheet.topology());
  std::vector<double> noise(41 * 17);
  for (double& n : noise) n = 0.004 * std::uniform_real_distribution<double>(-1, 1)(rng);
  for (int k = 0; k <= kSteps; ++k) {
    const double angle = 3.3 * to_and_fro(k, kSteps);
    std::size_t vertex = 0;
    animation.poses.push_back({sheet.positions([&](double u, double v) {
      const double s = std::max(0.0, u - 0.5), height = noise[vertex++];
      return Vec3(std::min(u, 0.5) + s * std::cos(angle) - height * std::sin(angle) * (s > 0),
                  s * std::sin(angle) + height * (s > 0 ? std::cos(angle) : 1), 0.4 * v);
    })});
  }
  return animation;
}

// A long strip that is twisted about its axis by several turns, until its windings cross each other.
Animation twisting(Rng&) {
  Animation animation;
  const Grid sheet{60, 8};
  animation.topologies.push_back(sheet.topology());
  for (int k = 0; k <= kSteps; ++k) {
    const double turns = 22 * to_and_fro(k, kSteps);
    animation.poses.push_back({sheet.positions([&](double u, double v) {
      const double a = turns * u, y = 0.25 * (v - 0.5), squeeze = 1 - 0.0445 * turns;
      return Vec3(u * squeeze + 0.2 * y, y * std::cos(a),
                  y * std::sin(a) + 0.03 * std::sin(turns) * std::sin(9 * u));
    })});
  }
  return animation;
}

// Bodies that drift through each other while they grow and shrink.
Animation several_bodies(Rng& rng) {
  Animation animation;
  std::vector<Mesh> meshes;
  for (const int family : {0, 1, 2}) meshes.push_back(mesh_families()[family].make(rng));
  for (const Mesh& mesh : meshes) animation.topologies.push_back(mesh.topology());
  for (int k = 0; k <= kSteps; ++k) {
    std::vector<Pose> pose;
    for (std::size_t b = 0; b < meshes.size(); ++b) {
      const double phase = 0.16 * k + 2 * double(b);
      const double scale = 1 + 0.1 * std::sin(3 * phase);
      Pose x = meshes[b].positions;
      for (std::size_t i = 0; i < x.size(); ++i)
        x[i] =
            scale * x[i] + 0.5 * std::sin(phase + 1.3 * double(i % 3)) + 0.02 * std::sin(20 * x[i] + phase);
      pose.push_back(std::move(x));
    }
    animation.poses.push_back(std::move(pose));
  }
  return animation;
}

// Unrelated poses between short stretches of small motion.
Animation jumping(Rng& rng) {
  Animation animation;
  const Mesh mesh = mesh_families()[rng() % 2].make(rng);
  const Grid sheet{20, 20};
  animation.topologies = {mesh.topology(), sheet.topology()};
  const Pose flat = sheet.positions([](double u, double v) { return Vec3(u - 0.5, v - 0.5, 0.3 * u * v); });
  Pose first = mesh.positions, second = flat;
  for (int k = 0; k <= kSteps; ++k) {
    if (k % 7 == 6) {
      first = deformed(mesh.positions, 0.3, k % 2 ? 0 : 1.0 / 16, rng);
      second = deformed(flat, 0.2, 0, rng);
    } else {
      first = deformed(first, 0.003, 0, rng);
      second = deformed(second, 0.003, 0, rng);
    }
    animation.poses.push_back({first, second});
  }
  return animation;
}

// Triangle soups, non-manifold edges, degenerate and double triangles.
Animation damaged(Rng& rng) {
  Animation animation;
  std::vector<Pose> pose;
  for (const int family : {3, 4, 6}) {
    const Mesh mesh = mesh_families()[family].make(rng);
    animation.topologies.push_back(mesh.topology());
    pose.push_back(mesh.positions);
  }
  for (int k = 0; k <= kSteps; ++k) {
    animation.poses.push_back(pose);
    for (Pose& x : pose) x = deformed(x, 0.002, k % 10 == 9 ? 1.0 / 256 : 0, rng);
  }
  return animation;
}

constexpr AnimationFamily kAnimations[] = {{"bending", bending},   {"folding", folding},
                                           {"twisting", twisting}, {"several_bodies", several_bodies},
                                           {"jumping", jumping},   {"damaged", damaged}};

}  // namespace

std::span<const AnimationFamily> generated_animations() { return kAnimations; }

}  // namespace foldproof::oracle
