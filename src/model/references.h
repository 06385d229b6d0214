/// Which poses to draw charts in.
#pragma once

#include "foldproof/certificate.h"

namespace foldproof {

/// How a pose bends, whatever its place and size: cosines between the mean normals of neighbouring leaves.
class BendDescriptor {
 public:
  explicit BendDescriptor(const PatchSlots& slots);
  std::vector<float> of(std::span<const double> positions) const;

 private:
  std::shared_ptr<const Hierarchy> hierarchy_;
  std::vector<std::array<Index, 2>> pairs_;
};

/// Up to `count` poses of which every other is near one: the first, then always the one farthest from those
/// chosen. Fewer when the rest only repeat them. Ascending.
std::vector<Index> choose_references(std::span<const std::vector<float>> descriptors, Index count);

}  // namespace foldproof
