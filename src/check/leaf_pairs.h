/// What the broad phase hands on: pairs of leaves, and which objects they are of.
#pragma once

#include "bvh/traverse.h"

namespace foldproof {

/// A share of the traversal of one object with itself or of two objects.
struct TraversalTask {
  Traversal traversal;
  Index object_a, object_b;
};

/// A pair of leaves to be tested, with the task it came from.
struct LeafPairRef {
  Index task;
  NodePair leaves;
};

/// Two leaves that were near each other.
struct NearLeaves {
  NodePair leaves;
  Index slot;  ///< Of their patch; kNoIndex when they have no vertex in common, or fronts are not kept.
};

}  // namespace foldproof
