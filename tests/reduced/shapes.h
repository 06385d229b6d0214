/// Generated meshes with a subspace, for tests of reduced motion.
#pragma once

#include <cmath>
#include <memory>
#include <numbers>
#include <random>

#include "foldproof/reduced.h"
#include "mesh/grid.h"

namespace foldproof::testing {

struct ReducedMesh {
  Topology topology;
  std::vector<double> rest;
  Pca subspace;

  std::shared_ptr<const Hierarchy> hierarchy(Index leaf_triangles = 12) const {
    return std::make_shared<const Hierarchy>(Hierarchy::build(topology, rest, {leaf_triangles}).value());
  }
  std::shared_ptr<const ReducedMotion> motion(Index leaf_triangles = 12) const {
    return std::make_shared<const ReducedMotion>(
        ReducedMotion::make(hierarchy(leaf_triangles), subspace).value());
  }
};

/// Rows of squares of two triangles; closed in u when `wrap`.
inline Topology grid(Index cells_u, Index cells_v, bool wrap) {
  return Grid{cells_u, cells_v, wrap, Diagonal::SecondToThird}.topology();
}

/// A tube of radius 1 and length 10 that bends in two directions, twists and bulges. Its subspace has the
/// principal components of random poses.
inline ReducedMesh bending_tube(Index around, Index along, double bend, Index modes = 6) {
  ReducedMesh mesh{grid(around, along, true), {}, {}};
  std::mt19937 random(5);
  std::normal_distribution<double> normal(0, 1);
  const auto pose = [&](double bend_y, double bend_z, double twist, double bulge) {
    std::vector<double> x;
    const double bent = std::hypot(bend_y, bend_z) + 1e-12, angle = std::atan2(bend_z, bend_y);
    for (Index j = 0; j <= along; ++j) {
      for (Index i = 0; i < around; ++i) {
        const double s = 10.0 * j / along - 5, phi = 2 * std::numbers::pi * i / around + twist * s / 5;
        const double r = 1 + bulge * std::exp(-s * s);
        // Bent about the middle in the plane of `angle`, with a soft joint.
        const double u = r * std::cos(phi - angle), w = r * std::sin(phi - angle);
        const double turn = bent * std::tanh(s / 2) / 2;
        const double along_x = s - u * std::sin(turn),
                     up = u * std::cos(turn) + (std::cosh(0.2 * s) - 1) * bent;
        x.insert(x.end(), {along_x, up * std::cos(angle) - w * std::sin(angle),
                           up * std::sin(angle) + w * std::cos(angle)});
      }
    }
    return x;
  };
  mesh.rest = pose(0, 0, 0, 0);
  Eigen::MatrixXd samples(mesh.rest.size(), 30);
  for (Eigen::Index k = 0; k < samples.cols(); ++k) {
    const double a = bend * normal(random), b = bend * normal(random);
    const double bulge = 0.1 * normal(random), twist = 0.2 * normal(random);
    const auto x = pose(a, b, twist, bulge);
    samples.col(k) = Eigen::Map<const Eigen::VectorXd>(x.data(), static_cast<Eigen::Index>(x.size()));
  }
  mesh.subspace = pca(samples, {.modes = modes}).value();
  return mesh;
}

/// A square cloth of side 1 that waves and rolls up, with such a subspace.
inline ReducedMesh waving_cloth(Index side, Index modes = 6) {
  ReducedMesh mesh{grid(side, side, false), {}, {}};
  std::mt19937 random(9);
  std::normal_distribution<double> normal(0, 1);
  const auto pose = [&](double roll, double wave, double cross) {
    std::vector<double> x;
    for (Index j = 0; j <= side; ++j) {
      for (Index i = 0; i <= side; ++i) {
        const double u = double(i) / side - 0.5, v = double(j) / side - 0.5;
        const double sine = std::abs(roll) < 1e-6 ? u : std::sin(roll * u) / roll;
        const double rise = std::abs(roll) < 1e-6 ? 0 : (1 - std::cos(roll * u)) / roll;
        x.insert(x.end(), {sine, v, rise + wave * std::sin(5 * v) + cross * u * v});
      }
    }
    return x;
  };
  mesh.rest = pose(0, 0, 0);
  Eigen::MatrixXd samples(mesh.rest.size(), 30);
  for (Eigen::Index k = 0; k < samples.cols(); ++k) {
    const double cross = 0.3 * normal(random), wave = 0.1 * normal(random), roll = 1.5 * normal(random);
    const auto x = pose(roll, wave, cross);
    samples.col(k) = Eigen::Map<const Eigen::VectorXd>(x.data(), static_cast<Eigen::Index>(x.size()));
  }
  mesh.subspace = pca(samples, {.modes = modes}).value();
  return mesh;
}

/// A random direction of length 1 in the motion's norm.
inline std::vector<double> random_direction(const ReducedMotion& motion, std::mt19937& random) {
  std::normal_distribution<double> normal(0, 1);
  std::vector<double> q(motion.modes());
  double square = 0;
  for (double& c : q) {
    c = normal(random);
    square += c * c;
  }
  for (Index k = 0; k < motion.modes(); ++k) q[k] *= motion.deviations()[k] / std::sqrt(square);
  return q;
}

}  // namespace foldproof::testing
