// Pairs of leaves that may have charts.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "certificate/patch.h"

namespace foldproof {
namespace {

// `count` triangles around vertex 0.
Hierarchy fan(Index count) {
  std::vector<double> x{0, 0, 0};
  std::vector<Triangle> triangles;
  for (Index i = 0; i <= count; ++i) {
    x.insert(x.end(), {std::cos(6.0 * i / count), std::sin(6.0 * i / count), 0});
    if (i > 0) triangles.push_back({0, i, i + 1});
  }
  return *Hierarchy::build(*Topology::make(count + 2, std::move(triangles)), x, {.leaf_triangles = 1});
}

TEST(PatchSlots, AreThePairsOfAVertexUnlessFarTooManyMeetThere) {
  for (const Index count : {PatchSlots::kMaxLeavesAtVertex, PatchSlots::kMaxLeavesAtVertex + 1}) {
    const auto tree = std::make_shared<const Hierarchy>(fan(count));
    ASSERT_EQ(tree->leaf_count(), count);
    const PatchSlots slots(tree);
    const bool all = count == PatchSlots::kMaxLeavesAtVertex;
    const Index pairs = all ? count * (count - 1) : 2 * (count - 1);
    EXPECT_EQ(slots.count(), tree->nodes().size() + pairs);
    Index with_slot = 0;
    for (Index a = 0; a < count; ++a) {
      for (const Index b : slots.neighbors(a)) {
        const Index slot = slots.of_leaves(a, b);
        ASSERT_NE(slot, kNoIndex);
        EXPECT_EQ(slots.leaves_of(slot), (std::array<Index, 2>{std::min(a, b), std::max(a, b)}));
        ++with_slot;
      }
    }
    EXPECT_EQ(with_slot, pairs);
  }
}

}  // namespace
}  // namespace foldproof
