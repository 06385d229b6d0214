/// What all queries on a set of objects share: validated input, the scene's frame, and the pairs of leaves.
#pragma once

#include <tbb/enumerable_thread_specific.h>

#include "bvh/traverse.h"
#include "foldproof/query.h"

namespace foldproof {

/// One object with itself or two objects, cut into tasks that run in parallel and in a fixed order.
struct TraversalTask {
  Traversal traversal;
  Index object_a, object_b;
  NodePair start;
  TraversalResult found;
};

/// A leaf pair to be tested, with the task it came from.
struct LeafPairRef {
  Index task;
  NodePair leaves;
};

class Scene {
 public:
  explicit Scene(std::vector<std::shared_ptr<const Hierarchy>> objects);

  const Hierarchy& hierarchy(Index object) const { return *trees_[object].hierarchy; }

  /// Checks sizes and numbers, then refits every object. After it `largest_side` is valid.
  Result<void> update(Positions x0, Positions x1);

  /// Finds the pairs of leaves that come closer than `distance` and fills their features.
  /// Adds to `work.node_tests` and `work.leaf_pairs`.
  void traverse(const StepSettings& settings, double distance, Work& work);

  /// Of the last traversal, in an order that depends on the input only.
  std::span<const LeafPairRef> leaf_pairs() const { return leaf_pairs_; }
  const TraversalTask& task(Index k) const { return tasks_[k]; }

  /// The largest side of the box around everything during the step, in mesh units.
  double largest_side() const { return largest_side_; }

 private:
  void start_tasks(const StepSettings& settings, float margin, Work& work);
  void fill_features();

  std::vector<KineticTree> trees_;
  Frame frame_;
  double largest_side_ = 0;
  std::vector<TraversalTask> tasks_;
  std::size_t task_count_ = 0;
  std::vector<LeafPairRef> leaf_pairs_;
  std::vector<std::vector<std::uint8_t>> leaf_needed_;
  std::vector<std::pair<Index, Index>> leaves_to_fill_;
  std::vector<NodePair> front_, below_;
  TraversalResult above_;
  tbb::enumerable_thread_specific<std::vector<NodePair>> stacks_;
};

}  // namespace foldproof
