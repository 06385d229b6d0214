/// What writer and reader of the model file share.
#pragma once

#include "foldproof/model.h"
#include "model/model_generated.h"

namespace foldproof {

/// Of the file. Also numbers and order of patches are part of it: those of PatchSlots and PatchReader.
inline constexpr std::uint32_t kModelVersion = 2;
/// Models without a learned part; read as what they are.
inline constexpr std::uint32_t kOldestModelVersion = 1;

inline constexpr const char* kCopyAgain = "copy the model again, or train it anew";

/// How many of a chart's triangles belong to its patch; fillers follow.
inline Index patch_triangles(const PatchSlots& slots, Index slot, std::span<const Index> collar) {
  const auto leaves = slots.hierarchy()->leaves();
  Index count = slots.triangles_of(slot);
  for (const Index leaf : collar) count += leaves[leaf + 1].triangles - leaves[leaf].triangles;
  return count;
}

}  // namespace foldproof
