/// A surface and generated poses of it for the tests of key points.
#pragma once

#include <Eigen/Dense>
#include <cmath>
#include <random>
#include <vector>

namespace foldproof::testing {

/// Vertices of a cylinder of radius 1 and length 4 along y: `around` times `along` of them.
inline std::vector<double> cylinder(int around, int along) {
  std::vector<double> positions;
  for (int b = 0; b < along; ++b) {
    for (int a = 0; a < around; ++a) {
      const double angle = 2 * M_PI * a / around;
      positions.insert(positions.end(), {std::cos(angle), 4.0 * b / (along - 1), std::sin(angle)});
    }
  }
  return positions;
}

inline Eigen::Map<const Eigen::VectorXd> as_vector(const std::vector<double>& positions) {
  return {positions.data(), static_cast<Eigen::Index>(positions.size())};
}

/// Poses of it in columns: bent along a circle, in a random direction by a random angle, and bulging.
inline Eigen::MatrixXd bent(const std::vector<double>& positions, int count, unsigned seed) {
  std::mt19937 random(seed);
  const auto uniform = [&](double from, double to) { return from + (to - from) * random() * 0x1p-32; };
  Eigen::MatrixXd poses(static_cast<Eigen::Index>(positions.size()), count);
  for (int k = 0; k < count; ++k) {
    const double towards = uniform(0, 2 * M_PI), angle = uniform(0.1, 1.5), bulge = uniform(-0.3, 0.3);
    const Eigen::Vector3d side(std::cos(towards), 0, std::sin(towards)), up(0, 1, 0);
    for (std::size_t v = 0; v < positions.size(); v += 3) {
      const double y = positions[v + 1], blown = 1 + bulge * std::sin(M_PI * y / 4);
      const Eigen::Vector3d across(positions[v] * blown, 0, positions[v + 2] * blown);
      const double inward = across.dot(side), turned = angle * y / 4, radius = 4 / angle - inward;
      poses.col(k).segment<3>(static_cast<Eigen::Index>(v)) = across - inward * side +
                                                              (4 / angle - radius * std::cos(turned)) * side +
                                                              radius * std::sin(turned) * up;
    }
  }
  return poses;
}

}  // namespace foldproof::testing
