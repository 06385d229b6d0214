/// The choice of poses to build charts in.
#pragma once

#include "certificate/patch.h"

namespace foldproof::inline internal {

/// Describes how a pose bends, independently of position and size: cosines between the mean normals of
/// neighboring leaves.
class BendDescriptor {
 public:
  explicit BendDescriptor(const PatchSlots& slots);
  std::vector<float> of(std::span<const double> positions) const;

 private:
  std::shared_ptr<const Hierarchy> hierarchy_;
  std::vector<std::array<Index, 2>> pairs_;
};

/// Farthest-point sampling: the first pose, then always the one farthest from those chosen, up to `count`.
/// Stops early where the remaining poses only repeat the chosen ones. Ascending.
std::vector<Index> choose_references(std::span<const std::vector<float>> descriptors, Index count);

}  // namespace foldproof::inline internal
