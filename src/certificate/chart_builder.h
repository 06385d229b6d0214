/// Builds charts in the pose halfway through a step.
#pragma once

#include "bvh/kinetic_bvh.h"
#include "certificate/library.h"

namespace foldproof::inline internal {

/// The chart of a slot, or why there is none. Reusable: keeps its buffers.
struct BuiltChart {
  Index slot = 0;
  Patch patch;              ///< Includes the ring.
  std::vector<Index> ring;  ///< Neighboring leaves that face the same way as a node's patch.
  UvMap uv_map;
  ChartOutcome outcome = ChartOutcome::TooCurved;
};

/// Scratch: one per thread.
class ChartBuilder {
 public:
  explicit ChartBuilder(const PatchSlots& slots);
  /// Builds the chart of out.slot: of a node with its ring, or without it where that fails.
  void build(std::span<const MovingVertex> vertices, BuiltChart& out);

 private:
  void read_positions(std::span<const MovingVertex> vertices, const Patch& patch);
  void add_ring(std::span<const MovingVertex> vertices, const Vec3& facing, BuiltChart& out);

  const PatchSlots& slots_;
  PatchReader reader_;
  Parametrizer parametrizer_;
  std::vector<std::array<float, 3>> positions_;
  std::vector<std::uint32_t> last_build_;  // per leaf: the last build that tested it for the ring
  std::uint32_t build_number_ = 0;
};

}  // namespace foldproof::inline internal
