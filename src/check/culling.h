/// The pipeline's third stage: pairs that certificates separate need no test.
#pragma once

#include "base/parallel.h"
#include "certificate/book.h"
#include "certificate/separating_plane.h"
#include "check/gain.h"
#include "check/motion.h"

namespace foldproof {

/// Charts of patches, which prove that nodes do not meet themselves and leaves not their neighbours, and
/// planes between leaves. Learns from step to step where they hold and whether to use them at all.
class Culling {
 public:
  explicit Culling(std::span<const Object> objects);

  /// Begins a step for a motion that was updated. Error: Mode::Paper has nothing to predict from.
  Result<void> begin(const StepMotion& motion, Positions x0, Positions x1, const StepSettings& settings,
                     double distance);
  /// Whether later steps may use certificates on what this one finds.
  bool may_use_later() const { return certificates_ && (uses_certificates_ || steps_ > 1); }

  /// The pairs of an object's nodes with themselves, from the root down to those that are proven. Valid until
  /// the next call.
  struct SelfPairs {
    std::vector<std::uint8_t> proven;    ///< Per node; nothing is said of what lies below a proven one.
    std::vector<Index> unproven_leaves;  ///< Leaves with themselves that are left.
  };
  const SelfPairs& cull_self_pairs(const StepMotion& motion, Index object, Work& work);

  /// Of pairs of leaves of one task.
  struct Culled {
    std::vector<NodePair> remaining;  ///< Whose features are to be tested.
    struct Plane {
      NodePair leaves;
      PlaneNormal normal;
    };
    std::vector<Plane> planes;  ///< Pairs of leaves that a plane separates.
    std::uint64_t node_tests = 0;
    void clear() {
      remaining.clear();
      planes.clear();
      node_tests = 0;
    }
  };
  /// Adds to `out`. `just_found`: their boxes are known not to be apart. Different threads may ask, after
  /// cull_self_pairs of the task's objects.
  void cull_leaves(const TraversalTask& task, std::span<const NearLeaves> near, bool just_found, Culled& out);
  const PatchSlots& slots(Index object) const { return books_[object]->slots(); }

  /// Keeps for later steps what pairs of leaves were separated by, and which are left.
  void remember(const TraversalTask& task, std::span<const Culled::Plane> planes);
  void remember_remaining(const TraversalTask& task, NodePair leaves);
  /// Ends the step, in which so many nodes were tested and so many pairs of leaves remain. Adds to `work`
  /// what certificates did.
  void end(const StepMotion& motion, std::uint64_t node_tests, std::size_t leaf_pairs, Work& work);

  /// What certificates did in the step; not counted: pairs of leaves that they proved.
  void explain(const StepMotion& motion, std::span<const TraversalTask> tasks,
               std::span<const LeafPairRef> leaf_pairs, Explanation& out);

 private:
  // Which proven patches of this step a leaf belongs to. Two leaves with a patch in common are proven apart.
  struct LeafProofs {
    std::array<Index, 8> patch;  // the rest is kNoIndex
    Index count;
    LeafProofs() { clear(); }
    void clear() {
      patch.fill(kNoIndex);
      count = 0;
    }
    void add(Index proven_patch) {
      if (count < patch.size()) patch[count++] = proven_patch;
    }
    // All of one side at once, without branches.
    bool meets(const LeafProofs& other) const {
      Index same = 0;
      for (Index k = 0; k < other.count; ++k) {
        for (const Index p : patch) same |= static_cast<Index>(p == other.patch[k]);
      }
      return same != 0;
    }
  };
  // Scratch of one thread.
  struct Local {
    ChartTester tester;
    std::uint64_t tests = 0, passes = 0, failed_planes = 0;
    std::uint64_t new_planes = 0, new_planes_found = 0;  // asked for where none was known
    std::vector<NearLeaves> to_test;                     // pairs of leaves without a common proof
    std::vector<NodePair> leaves;
    std::vector<std::uint8_t> apart;
  };
  // What is known from earlier steps of a pair of leaves that was asked for a plane.
  struct PlaneMemory {
    PlaneNormal normal{};                     // the last that separated it
    std::uint8_t cooldown = 0, failures = 0;  // steps until it is tested again; failures so far
  };
  // A node that a chart proved, for explanations.
  struct ProvenNode {
    Index object, node, level;
    ChartBook::Proof proof;
  };
  Result<void> predict(Positions x0, Positions x1, const StepSettings& settings);
  std::size_t drawing_budget();
  void prove_nodes(const StepMotion& motion, Index object);
  bool is_proven(const TraversalTask& task, const NearLeaves& pair, Local& local, PlaneNormal& found);
  PlaneMemory& plane_memory(const TraversalTask& task, NodePair leaves);
  bool may_have_plane(const TraversalTask& task, NodePair leaves, const PlaneMemory& memory) const;
  Reason reason_of(const TraversalTask& task, NodePair leaves) const;

  std::vector<std::unique_ptr<ChartBook>> books_;
  std::vector<std::shared_ptr<const NodePredictor>> predictors_;  // null where there is none
  std::vector<std::vector<std::uint8_t>> predicted_free_;         // per object and node; Mode::Paper
  CullingGain gain_;
  bool certificates_ = false, explains_ = false;                     // as the settings say
  bool trusts_predictions_ = false;                                  // Mode::Paper
  bool uses_certificates_ = false, uses_certificates_next_ = false;  // in this step, in the next one
  bool measures_gain_ = false;                                       // in this step
  double gap_ = 0;                                                   // to be proven, in the frame
  std::size_t steps_ = 0, last_leaf_pairs_ = 0;
  double drawn_ = 0, of_use_ = 0;  // charts drawn in the last steps, and those of them that held

  SelfPairs selves_;
  std::vector<Index> level_, level_below_;
  std::vector<ChartBook::Proof> level_proofs_;
  std::vector<std::vector<LeafProofs>> leaf_proofs_;  // per object and leaf
  std::vector<ProvenNode> proven_nodes_;              // only when explanations are wanted

  struct {
    double asked = 0, found = 0;  // in the last steps, where none was known
    bool pay = false;
  } planes_;
  bool ask_for_planes_ = false;  // not in the first step: where few have one, it must be known which
  std::vector<PlaneMemory> plane_memory_;
  PerThread<Local> locals_;
};

}  // namespace foldproof
