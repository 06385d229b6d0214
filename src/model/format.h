/// Shared by the writer and the reader of the model file.
#pragma once

#include "certificate/patch.h"
#include "foldproof/model.h"
#include "model/model_generated.h"

namespace foldproof::inline internal {

/// Of the format, which includes the numbering of slots (PatchSlots) and the order in patches (PatchReader).
inline constexpr std::uint32_t kModelVersion = 2;
/// Without a learned part; still read.
inline constexpr std::uint32_t kOldestModelVersion = 1;

inline constexpr const char* kCopyAgain = "copy the model again, or train it anew";

/// How many of a chart's triangles belong to its patch; the scaffold follows.
inline Index patch_triangles(const PatchSlots& slots, Index slot, std::span<const Index> ring) {
  const auto leaves = slots.hierarchy()->leaves();
  Index count = slots.triangle_count(slot);
  for (const Index leaf : ring) count += leaves[leaf + 1].triangles - leaves[leaf].triangles;
  return count;
}

}  // namespace foldproof::inline internal
