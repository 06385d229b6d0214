/// Stage 3 of the pipeline, culling: pairs that certificates prove separated need no test.
#pragma once

#include "base/parallel.h"
#include "certificate/chart_cache.h"
#include "certificate/separating_plane.h"
#include "check/culling_policy.h"
#include "check/filter.h"
#include "check/motion.h"

namespace foldproof::inline internal {

/// Two kinds of certificates: charts, which prove that the patch of a node or of two neighboring leaves does
/// not touch itself, and planes that separate two leaves. Learns from step to step where they hold and
/// whether to use them at all.
class Culling {
 public:
  explicit Culling(std::span<const Object> objects);

  /// Begins a step, after an update of the motion. Error: StepSettings::declared_free is not of these nodes.
  Result<void> begin_step(const StepMotion& motion, const StepSettings& settings, double distance);
  /// Whether later steps may use certificates on the pairs that this one finds.
  bool may_cull_later() const { return certificates_ && (uses_certificates_ || steps_ > 1); }

  /// The pairs of an object's nodes with themselves, from the root down to proven ones. Valid until the next
  /// call.
  struct SelfPairs {
    std::vector<std::uint8_t> proven;    ///< Per node, or ignored; unspecified below such a node.
    std::vector<Index> unproven_leaves;  ///< Leaves that remain paired with themselves.
  };
  const SelfPairs& cull_self_pairs(const StepMotion& motion, Index object, const Filter& filter, Work& work);

  /// The result for the pairs of leaves of one task.
  struct Culled {
    std::vector<NodePair> remaining;  ///< Pairs whose features are to be tested.
    struct Plane {
      NodePair leaves;
      PlaneNormal normal;
    };
    std::vector<Plane> planes;  ///< Of the pairs that a plane separates.
    std::uint64_t node_tests = 0;
    void clear() {
      remaining.clear();
      planes.clear();
      node_tests = 0;
    }
  };
  /// Adds to `out`. `boxes_overlap`: known from the traversal, so boxes are not tested. Thread-safe, after
  /// cull_self_pairs of the task's objects.
  void cull_leaves(const TraversalTask& task, std::span<const NearLeafPair> near, bool boxes_overlap,
                   Culled& out);
  const PatchSlots& slots(Index object) const { return charts_[object]->slots(); }

  /// For later steps: caches planes, requests charts for a pair that remains, and backs off from planes that
  /// fail.
  void cache_planes(const TraversalTask& task, std::span<const Culled::Plane> planes);
  void note_remaining(const TraversalTask& task, NodePair leaves);
  /// Ends the step. `leaf_pairs`: the number of pairs that remain. Adds the work of certificates to `work`.
  void end_step(const StepMotion& motion, std::uint64_t node_tests, std::size_t leaf_pairs, Work& work);

  /// Explains the step, except for the number of pairs of leaves that certificates proved.
  void explain(const StepMotion& motion, std::span<const TraversalTask> tasks,
               std::span<const LeafPair> leaf_pairs, Explanation& out);

 private:
  // The proven patches of this step that contain a leaf. Two leaves with a common patch are proven separated.
  struct LeafProofs {
    std::array<Index, 8> patch;  // padded with kNoIndex
    Index count;
    LeafProofs() { clear(); }
    void clear() {
      patch.fill(kNoIndex);
      count = 0;
    }
    void add(Index proven_patch) {
      if (count < patch.size()) patch[count++] = proven_patch;
    }
    // Compares all of one side at once, without branches.
    bool has_common_patch(const LeafProofs& other) const {
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
    std::uint64_t new_planes = 0, new_planes_passed = 0;  // tests without a cached normal
    std::vector<NearLeafPair> unproven;                   // pairs of leaves without a common proven patch
    std::vector<NodePair> leaves;
    std::vector<std::uint8_t> separated;
  };
  // The history of planes between two leaves.
  struct CachedPlane {
    PlaneNormal normal{};                     // the last one that separated them
    std::uint8_t back_off = 0, failures = 0;  // steps until the next test; failures in a row
  };
  // A node that a chart proved, for explanations.
  struct ProvenNode {
    Index object, node, level;
    ChartCache::Proof proof;
  };
  Result<void> check_declared(const StepMotion& motion) const;
  std::size_t build_budget();
  void prove_nodes(const StepMotion& motion, Index object);
  bool is_proven(const TraversalTask& task, const NearLeafPair& pair, Local& local, PlaneNormal& normal);
  CachedPlane& cached_plane(const TraversalTask& task, NodePair leaves);
  bool should_test_plane(const TraversalTask& task, NodePair leaves, const CachedPlane& cached) const;
  Reason reason_of(const TraversalTask& task, NodePair leaves) const;

  std::vector<std::unique_ptr<ChartCache>> charts_;
  CullingPolicy policy_;
  bool certificates_ = false, explains_ = false;                           // as in the settings
  const std::vector<std::vector<std::uint8_t>>* declared_free_ = nullptr;  // as in the settings
  bool uses_certificates_ = false, uses_certificates_next_ = false;        // in this step, in the next one
  bool updates_policy_ = false;                                            // in this step
  double gap_ = 0;                                                         // to be proven, in the frame
  std::size_t steps_ = 0, last_leaf_pairs_ = 0;
  double built_ = 0, useful_ = 0;  // charts built in the last steps, and those of them that held

  SelfPairs self_pairs_;
  std::vector<Index> level_, next_level_;
  std::vector<ChartCache::Proof> level_proofs_;
  std::vector<std::vector<LeafProofs>> leaf_proofs_;  // per object and leaf
  std::vector<ProvenNode> proven_nodes_;              // only when explanations are wanted

  // Tests of planes without a cached normal, in the last steps.
  struct {
    double tests = 0, passes = 0;
    bool pay = false;
  } new_planes_;
  bool tests_planes_ = false;  // not in the first step, in which no pair has a history
  std::vector<CachedPlane> plane_cache_;
  PerThread<Local> locals_;
};

}  // namespace foldproof::inline internal
