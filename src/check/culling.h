/// Stage 3 of the pipeline, culling: pairs that certificates prove separated need no test.
#pragma once

#include "base/parallel.h"
#include "certificate/chart_cache.h"
#include "check/culling_policy.h"
#include "check/filter.h"
#include "check/hubs.h"
#include "check/motion.h"
#include "check/tile.h"

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
  bool keeps_fronts() const { return certificates_ && (uses_certificates_ || steps_ > 1); }

  /// Proves nodes of all objects, from the roots down to proven ones.
  void prove_nodes(const StepMotion& motion, const Filter& filter, Work& work);
  /// Per node of an object, whether it was proven or is ignored; unspecified below such a node.
  std::span<const std::uint8_t> proven(Index object) const { return objects_[object].proven; }
  /// The leaves of a subtree that remain paired with themselves; empty where a node above it was proven.
  std::span<const LeafIndex> unproven_leaves(Index object, Index subtree) const {
    return objects_[object].subtrees[subtree].unproven_leaves;
  }
  /// Whether a node above a subtree was proven or is ignored.
  bool is_covered(Index object, Index subtree) const { return objects_[object].subtrees[subtree].is_covered; }

  /// Adds those pairs of leaves of a tile that no certificate separates to `remaining` and learns for its
  /// later steps. `boxes_overlap`: known from the traversal, so boxes are not tested. Threads may do
  /// different tiles at once.
  void cull_leaves(const TraversalTask& task, std::span<const NearLeafPair> near, bool boxes_overlap,
                   Tile& tile);
  /// What separates nodes around a hub in this step; null where the objects have none in common. Of the
  /// calling thread, until it asks again.
  NodeCertificate* hub_planes(const TraversalTask& task);
  const Hubs& hubs(Index object) const { return *hubs_[object]; }
  const PatchSlots& slots(Index object) const { return charts_[object]->slots(); }
  /// Requests charts of pairs that remain.
  void request_charts(const Tile& tile) { charts_[tile.key.object_a]->request_pairs(tile.requests); }
  /// Ends the step. `leaf_pairs`: the number of pairs that remain. Adds the work of certificates to `work`.
  void end_step(const StepMotion& motion, std::uint64_t node_tests, std::size_t leaf_pairs, Work& work);

  /// Explains the step, except for the number of pairs of leaves that certificates proved.
  void explain(const StepMotion& motion, std::span<const TraversalTask> tasks,
               std::span<const TaskLeaves> leaf_pairs, Explanation& out);

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
    HubPlanes hub_planes;
    std::uint64_t tests = 0, passes = 0, failed_planes = 0;
    std::uint64_t new_planes = 0, new_planes_passed = 0;  // tests without a cached normal
    std::vector<NearLeafPair> unproven;                   // pairs of leaves without a common proven patch
    std::vector<LeafPair> leaves;
    std::vector<std::uint8_t> separated;
  };
  // A node that a chart proved.
  struct ProvenNode {
    Index object;
    NodeIndex node;
    ChartCache::Proof proof;
  };
  struct OnLeaf {
    LeafIndex leaf;
    Index patch;
  };
  // What was found in a subtree.
  struct SubtreeProofs {
    bool is_covered = false;
    Index patch = kNoIndex;  // the proven node above it
    std::vector<LeafIndex> unproven_leaves;
    std::vector<NodeIndex> requests;
    std::vector<OnLeaf> rings;       // leaves in the rings of proven nodes
    std::vector<ProvenNode> proven;  // only when explanations are wanted
    std::uint64_t node_tests = 0;
    void clear() {
      unproven_leaves.clear();
      requests.clear();
      rings.clear();
      proven.clear();
      node_tests = 0;
    }
  };
  struct ObjectProofs {
    std::vector<std::uint8_t> proven;  // per node
    std::vector<LeafProofs> leaves;
    std::vector<SubtreeProofs> subtrees;
    SubtreeProofs top;
  };
  Result<void> check_declared(const StepMotion& motion) const;
  std::size_t build_budget();
  ChartCache::Proof prove(const StepMotion& motion, Index object, NodeIndex node, Local& local);
  bool add_node(Index object, NodeIndex node, ChartCache::Proof proof, SubtreeProofs& out);
  void prove_top(const StepMotion& motion, const Filter& filter, Index object);
  void prove_subtree(const StepMotion& motion, const Filter& filter, Index object, Index subtree);
  void gather(Index object, Work& work);
  bool plane_separates_leaves(const TraversalTask& task, LeafPair leaves, CachedPlane& cached, Local& local);
  bool should_test_plane(std::uint64_t hash, const CachedPlane& cached) const;
  Reason reason_of(const TraversalTask& task, LeafPair leaves) const;

  std::vector<std::unique_ptr<ChartCache>> charts_;
  std::vector<std::shared_ptr<const Hubs>> hubs_;
  CullingPolicy policy_;
  bool certificates_ = false, explains_ = false;                           // as in the settings
  const std::vector<std::vector<std::uint8_t>>* declared_free_ = nullptr;  // as in the settings
  bool uses_certificates_ = false, uses_certificates_next_ = false;        // in this step, in the next one
  bool updates_policy_ = false;                                            // in this step
  double gap_ = 0;                                                         // to be proven, in the frame
  std::size_t steps_ = 0, last_leaf_pairs_ = 0;
  double built_ = 0, useful_ = 0;  // charts built in the last steps, and those of them that held

  std::vector<ObjectProofs> objects_;
  std::vector<std::array<Index, 2>> all_subtrees_;  // of all objects: object and subtree
  std::vector<NodeIndex> level_, next_level_;
  std::vector<ChartCache::Proof> level_proofs_;
  std::vector<ProvenNode> proven_nodes_;  // only when explanations are wanted

  // Tests of planes without a cached normal, in the last steps.
  struct {
    double tests = 0, passes = 0;
    bool pay = false;
  } new_planes_;
  bool tests_planes_ = false;  // not in the first step, in which no pair has a history
  PerThread<Local> locals_;
};

}  // namespace foldproof::inline internal
