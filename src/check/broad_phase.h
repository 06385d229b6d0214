/// Stage 2 of the pipeline, broad phase: which leaves come near each other. Traverses the tiles of each BVH
/// with itself and with those of objects whose boxes are near, from the fronts of the last step; each tile
/// culls its pairs at once, while their boxes are in the processor's cache.
#pragma once

#include <memory>

#include "check/culling.h"
#include "check/sweep_and_prune.h"

namespace foldproof::inline internal {

class BroadPhase {
 public:
  /// Finds the pairs of leaves that come within `distance`, mesh units, and that remain after culling. Adds
  /// to `work`. Precondition: Culling::begin_step.
  void find(const StepMotion& motion, Culling& culling, const Filter& filter, const StepSettings& settings,
            double distance, Work& work);
  /// The result, in an order that depends on the input only.
  std::span<const TaskLeaves> leaf_pairs() const { return leaf_pairs_; }
  std::span<const TraversalTask> tasks() const { return tasks_; }

  /// The number of pairs of leaves without culling.
  std::uint64_t count_near_leaves(const StepMotion& motion, const Culling& culling, const Filter& filter,
                                  const StepSettings& settings, double distance);

 private:
  // Scratch of one thread.
  struct Local {
    std::vector<NodePair> stack;
    TraversalResult found;
    Front front;
    TraversalResult counted;  // of count_near_leaves
  };
  // A step, as its tiles see it.
  struct Step {
    const StepMotion& motion;
    Culling& culling;
    const Filter& filter;
    float margin;
    bool keeps_fronts;
  };

  TraversalTask task(const Step& step, Index a, Index b) const {
    return {{&step.motion.bvhs()[a], &step.motion.bvhs()[b], step.margin}, a, b};
  }
  std::span<const SweepAndPrune::Pair> near_objects(const StepMotion& motion, float margin);
  void list_within(const Step& step, Index object);
  void list_pairs(const Step& step, Index a, Index b, NodePair start);
  void choose_tiles();
  void run(const Step& step, const TraversalTask& task, Tile& tile);
  void run_part(const Step& step, const TraversalTask& task, NodeIndex node, NodePair start,
                const Front::Segment* last, Tile& tile);

  std::size_t steps_ = 0;
  SweepAndPrune sweep_;
  std::vector<SweptBox> object_boxes_;
  TraversalResult near_;  // subtrees of one or two objects
  std::vector<NodePair> stack_;
  std::vector<Tile::Key> keys_;                            // of this step
  std::vector<std::unique_ptr<Tile>> tiles_, next_tiles_;  // ascending by key, some from earlier steps
  std::vector<Tile*> active_;                              // in this step
  std::vector<TraversalTask> tasks_;                       // their objects
  std::vector<TaskLeaves> leaf_pairs_;
  PerThread<Local> locals_;
};

}  // namespace foldproof::inline internal
