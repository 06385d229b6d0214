/// A generated motion: an open tube that bends.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "foldproof/model.h"
#include "mesh/grid.h"

namespace foldproof::testing {

/// `around` quads around and `along` quads along, two triangles each.
inline Topology tube(Index around, Index along) {
  return Grid{.columns = around, .rows = along, .closed = true}.topology();
}

/// The tube, of length 6 and radius 0.5, bent by `angle` in all.
inline std::vector<double> bent(Index around, Index along, double angle) {
  std::vector<double> x;
  for (Index i = 0; i <= along; ++i) {
    const double s = 6.0 * i / along, turn = angle * i / along;
    const double radius = angle == 0 ? 0 : 6.0 / angle;
    const double middle[2] = {angle == 0 ? s : radius * std::sin(turn),
                              angle == 0 ? 0 : radius * (1 - std::cos(turn))};
    for (Index j = 0; j < around; ++j) {
      const double phi = 2 * std::numbers::pi * j / around;
      const double out = 0.5 * std::cos(phi);
      x.insert(x.end(),
               {middle[0] - out * std::sin(turn), middle[1] + out * std::cos(turn), 0.5 * std::sin(phi)});
    }
  }
  return x;
}

struct TubeShape {
  Index around, along;
};
inline constexpr TubeShape kSmallTube{12, 8}, kTube{32, 48};

/// A frame per angle.
inline std::unique_ptr<Motion> bending_tube(TubeShape shape, const std::vector<double>& angles,
                                            std::string name = "tube") {
  std::vector<std::vector<double>> frames;
  for (const double angle : angles) frames.push_back(bent(shape.around, shape.along, angle));
  return memory_motion(std::move(name), tube(shape.around, shape.along), std::move(frames));
}

inline std::vector<TrainPose> all_poses(Motion& motion) {
  std::vector<TrainPose> poses;
  for (Index k = 0; k < motion.frame_count(); ++k) poses.push_back({&motion, k});
  return poses;
}

inline Model trained(Motion& motion, const TrainSettings& settings = {}) {
  auto model = train_model(all_poses(motion), settings);
  EXPECT_TRUE(model) << model.error().line();
  return std::move(*model);
}

/// The models in golden/: save_model wrote them when their format version was new. Version 1 has no learned
/// part.
inline Model small_model() { return trained(*bending_tube(kSmallTube, {0, 1.5})); }
inline Model small_learned_model(SubspaceKind kind = SubspaceKind::Pca) {
  TrainSettings settings{.references = 1};
  settings.learning.subspace = kind;
  return trained(*bending_tube(kSmallTube, {0, 0.5, 1, 1.5}), settings);
}

}  // namespace foldproof::testing
