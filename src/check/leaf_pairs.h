/// Pairs of leaves, the output of the broad phase.
#pragma once

#include "bvh/traverse.h"

namespace foldproof::inline internal {

/// A part of the traversal of one object with itself, or of two objects.
struct TraversalTask {
  Traversal traversal;
  Index object_a, object_b;
};

/// A pair of leaves whose features are tested, with its task.
struct TaskLeaves {
  Index task;
  LeafPair leaves;
};

/// A pair of leaves in the front: their boxes overlap, or did in an earlier step.
struct NearLeafPair {
  LeafPair leaves;
  SlotIndex
      slot;  ///< Of their patch. kNoIndex when they have no common vertex, or when fronts are not stored.
};

}  // namespace foldproof::inline internal
