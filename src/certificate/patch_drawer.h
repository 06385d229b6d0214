/// Draws patches in the pose halfway through a step.
#pragma once

#include "bvh/kinetic.h"
#include "foldproof/certificate.h"

namespace foldproof {

/// What came of drawing a slot. Reused: buffers are kept.
struct DrawnPatch {
  Index slot = 0;
  Patch patch;                ///< With the collar.
  std::vector<Index> collar;  ///< Neighbours that face the same way as a node's patch.
  Drawing drawing;
  ChartOutcome outcome = ChartOutcome::TooCurved;
};

/// Scratch: one per thread.
class PatchDrawer {
 public:
  explicit PatchDrawer(const PatchSlots& slots);
  /// Draws out.slot: a node with as much collar as may be, else without.
  void draw(std::span<const MovingVertex> vertices, DrawnPatch& out);

 private:
  void read_positions(std::span<const MovingVertex> vertices, const Patch& patch);
  void add_collar(std::span<const MovingVertex> vertices, const Eigen::Vector3f& facing, DrawnPatch& out);

  const PatchSlots& slots_;
  PatchReader reader_;
  ChartMaker maker_;
  std::vector<std::array<float, 3>> positions_;
  std::vector<std::uint32_t> seen_;  // per leaf: the last drawing that looked at it
  std::uint32_t drawings_ = 0;
};

}  // namespace foldproof
