/// The pipeline's second stage: which leaves come near each other. Each tree against itself and, of objects
/// whose boxes are near each other, tree against tree, from the front of the step before. The third stage,
/// culling, is called before a tree is traversed and in every task.
#pragma once

#include <deque>

#include "check/culling.h"
#include "check/sweep_and_prune.h"

namespace foldproof {

/// Finds pairs of leaves. Each task culls what it found at once, while boxes are in the processor's cache.
class BroadPhase {
 public:
  explicit BroadPhase(const StepMotion& motion);

  /// Finds the pairs of leaves that come closer than `distance`, mesh units, and that the culling, which has
  /// begun the step, leaves. Adds to `work`.
  void find(const StepMotion& motion, Culling& culling, const StepSettings& settings, double distance,
            Work& work);
  /// What it found, in an order that depends on the input only.
  std::span<const LeafPairRef> leaf_pairs() const { return leaf_pairs_; }
  std::span<const TraversalTask> tasks() const { return tasks_; }

  /// How many pairs of leaves there are when nothing is culled.
  std::uint64_t count_near_leaves(const StepMotion& motion, const StepSettings& settings, double distance);

 private:
  // The front of the traversal of one object with itself, or of two objects: where it stopped in the step
  // before, and where the next one resumes.
  struct Front {
    // The front between the two children of one unproven node: `pairs` and `near` from these indices up to
    // those of the next segment. A pair of objects has a single segment.
    struct Segment {
      Index node, pairs, near;
    };
    std::vector<Segment> segments;  // ascending by node
    std::vector<NodePair> pairs;    // nodes that were apart
    std::vector<NearLeaves> near;   // leaves that were not, at some time since the segment was made anew
    void clear() {
      segments.clear();
      pairs.clear();
      near.clear();
    }
  };
  // The pairs of nodes between the two children of an unproven node, or a part of them.
  struct WorkItem {
    Index node;  // as Front::Segment
    bool fresh;  // starts from the pair of the node's children
    std::span<const NodePair> starts;
    std::span<const NearLeaves> near;
    std::size_t weight(Index leaves) const;  // about how much there is to do, below a node of so many leaves
  };
  // What one task traverses, and what it finds. Tasks run in parallel; what they find does not depend on the
  // threads.
  struct TaskData {
    std::vector<WorkItem> items;
    std::vector<NodePair> starts;  // of two objects
    Front front;                   // where it stopped
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
  void make_self_tasks(const StepMotion& motion, Index object, const Culling::SelfPairs& selves,
                       float margin);
  void make_pair_tasks(const StepMotion& motion, Index a, Index b, float margin);
  TaskData& add_task(const StepMotion& motion, Index a, Index b, float margin);
  Front* front_of(Index a, Index b);
  void keep_fronts();
  void run_task(Index task, Culling& culling);

  std::size_t objects_;
  std::size_t steps_ = 0;
  SweepAndPrune sweep_;
  std::vector<SweptBox> object_boxes_;
  std::vector<TraversalTask> tasks_;
  std::deque<TaskData> task_data_;  // one per task; more may stand behind, from earlier steps
  std::vector<Front> fronts_;
  bool keeps_fronts_ = false;
  std::vector<WorkItem> items_;  // of the object at hand
  std::vector<NodePair> descent_, descent_below_;
  std::vector<LeafPairRef> leaf_pairs_;
  PerThread<Local> locals_;
};

}  // namespace foldproof
