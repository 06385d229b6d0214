/// Stage 2 of the pipeline, broad phase: which leaves come near each other. Traverses each BVH with itself
/// and with those of objects whose boxes are near, from the front of the last step. Calls stage 3, culling,
/// before it traverses an object and in every task.
#pragma once

#include <deque>

#include "check/culling.h"
#include "check/sweep_and_prune.h"

namespace foldproof::inline internal {

/// Finds pairs of leaves. Each task culls its pairs at once, while their boxes are in the processor's cache.
class BroadPhase {
 public:
  explicit BroadPhase(const StepMotion& motion);

  /// Finds the pairs of leaves that come within `distance`, mesh units, and that remain after culling. Adds
  /// to `work`. Precondition: Culling::begin_step.
  void find(const StepMotion& motion, Culling& culling, const Filter& filter, const StepSettings& settings,
            double distance, Work& work);
  /// The result, in an order that depends on the input only.
  std::span<const LeafPair> leaf_pairs() const { return leaf_pairs_; }
  std::span<const TraversalTask> tasks() const { return tasks_; }

  /// The number of pairs of leaves without culling.
  std::uint64_t count_near_leaves(const StepMotion& motion, const Filter& filter,
                                  const StepSettings& settings, double distance);

 private:
  // The front of the traversal of one object with itself, or of two objects: where it stopped in the last
  // step and the next one resumes.
  struct Front {
    // The front between the two children of one unproven node: `pairs` and `near` from these indices up to
    // those of the next segment. A pair of objects has a single segment.
    struct Segment {
      Index node;
      std::size_t pairs, near;
    };
    std::vector<Segment> segments;   // ascending by node
    std::vector<NodePair> pairs;     // separated nodes
    std::vector<NearLeafPair> near;  // leaves that came near since the segment was rebuilt
    void clear() {
      segments.clear();
      pairs.clear();
      near.clear();
    }
  };
  // The pairs of nodes between the two children of an unproven node, or a part of them.
  struct WorkItem {
    Index node;          // as in Front::Segment
    bool from_children;  // starts from the pair of the node's children, not from a front
    std::span<const NodePair> starts;
    std::span<const NearLeafPair> near;
    std::size_t weight(Index leaves) const;  // estimated work, for a node with this many leaves
  };
  // Input and result of one task. Tasks run in parallel; their results do not depend on the threads.
  struct TaskData {
    std::vector<WorkItem> items;
    std::vector<NodePair> starts;  // of two objects
    Front front;                   // where the traversal stopped
    TaskFilter filter;
    TraversalResult found;
    Culling::Culled culled;
    TaskData();
  };
  // Scratch of one thread.
  struct Local {
    std::vector<NodePair> stack;
    TraversalResult counted;
  };

  std::span<const SweepAndPrune::Pair> near_objects(const StepMotion& motion, float margin);
  std::size_t target_task_count(const StepMotion& motion, Index a, Index b) const;
  std::size_t list_items(const StepMotion& motion, Index object, std::span<const std::uint8_t> proven);
  void make_self_tasks(const StepMotion& motion, Index object, const Culling::SelfPairs& self_pairs,
                       float margin);
  void make_pair_tasks(const StepMotion& motion, Index a, Index b, float margin);
  TaskData& add_task(const StepMotion& motion, Index a, Index b, float margin);
  Front* front_of(Index a, Index b);
  void store_fronts();
  void run_task(Index task, Culling& culling);

  std::size_t objects_;
  const Filter* filter_ = nullptr;  // of the present call
  std::size_t steps_ = 0;
  SweepAndPrune sweep_;
  std::vector<SweptBox> object_boxes_;
  std::vector<TraversalTask> tasks_;
  std::deque<TaskData> task_data_;  // one per task, then unused ones of earlier steps
  std::vector<Front> fronts_;
  bool uses_fronts_ = false;
  std::vector<WorkItem> items_;  // of the present object
  std::vector<NodePair> descent_, descent_scratch_;
  std::vector<LeafPair> leaf_pairs_;
  PerThread<Local> locals_;
};

}  // namespace foldproof::inline internal
