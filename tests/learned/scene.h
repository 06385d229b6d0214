/// A tube that bends in two directions.
#pragma once

#include "model/cylinder.h"

namespace foldproof::testing {

/// The tube, bent gradually along its length: by `up` in its plane, and then by `aside` out of it.
inline std::vector<double> bent_twice(TubeShape shape, double up, double aside) {
  std::vector<double> x = bent(shape.around, shape.along, up);
  for (std::size_t i = 0; i < x.size(); i += 3) x[i + 2] += aside * x[i] * x[i] / 36;
  return x;
}

inline std::unique_ptr<Motion> bending_twice(TubeShape shape,
                                             const std::vector<std::array<double, 2>>& angles,
                                             std::string name = "tube") {
  std::vector<std::vector<double>> frames;
  for (const auto& [up, aside] : angles) frames.push_back(bent_twice(shape, up, aside));
  return memory_motion(std::move(name), tube(shape.around, shape.along), std::move(frames));
}

inline Eigen::VectorXd frame_of(Motion& motion, Index k) {
  Eigen::VectorXd x(3 * Eigen::Index{motion.topology().vertex_count()});
  EXPECT_TRUE(motion.read_frame(k, std::span(x.data(), static_cast<std::size_t>(x.size()))));
  return x;
}

inline constexpr TubeShape kSmallTubeToLearn{12, 24};

}  // namespace foldproof::testing
