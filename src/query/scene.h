/// What all queries on a set of objects share: validated input, the scene's frame, and the pairs of leaves.
#pragma once

#include <deque>

#include "base/parallel.h"
#include "certificate/book.h"
#include "certificate/separating_plane.h"
#include "query/beliefs.h"
#include "query/broad_phase.h"
#include "query/narrow.h"

namespace foldproof {

/// Two leaves that were near each other.
struct NearLeaves {
  NodePair leaves;
  Index slot;  ///< Of their patch; kNoIndex when they have no vertex in common.
};

/// Where the traversal of one object with itself or of two objects stopped in the step before. The next step
/// goes on from there.
struct Front {
  /// From `pairs` and `near` on, up to where the next run begins, what lies between the two children of one
  /// node that was not proven; of two objects there is one run.
  struct Run {
    Index node, pairs, near;
  };
  std::vector<Run> runs;         ///< Ascending by node.
  std::vector<NodePair> pairs;   ///< Nodes that were apart.
  std::vector<NearLeaves> near;  ///< Leaves that were not, at some time since the run was made anew.
  void clear() {
    runs.clear();
    pairs.clear();
    near.clear();
  }
};

/// What one task traverses and proves. Tasks run in parallel; what they find does not depend on the threads.
struct TraversalShare {
  struct Part {
    Index node;  ///< As Front::Run.
    bool fresh;  ///< Starts from the pair of the node's children.
    std::span<const NodePair> starts;
    std::span<const NearLeaves> near;
  };
  std::vector<Part> parts;
  std::vector<NodePair> starts;  ///< Of two objects.
  Front front;                   ///< Where it stopped.
  TraversalResult found;
  std::vector<NodePair> unproven;  ///< Pairs of leaves whose features are to be tested.
  struct Plane {
    NodePair leaves;
    PlaneNormal normal;
  };
  std::vector<Plane> planes;  ///< Pairs of leaves that a plane separates.

  /// What most need, so that few of many shares ever grow.
  void reserve() {
    constexpr std::size_t kMostly = 32;
    front.pairs.reserve(kMostly);
    front.near.reserve(kMostly);
    found.leaf_pairs.reserve(kMostly);
    unproven.reserve(kMostly);
  }
};

/// Which proven patches of this step a leaf belongs to. Two leaves with a patch in common are proven apart.
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

/// The largest side of the box around everything; finite.
double side_of(const Bounds& bounds);

class Scene {
 public:
  Scene(std::vector<std::shared_ptr<const Hierarchy>> objects,
        std::vector<std::shared_ptr<const ChartLibrary>> charts,
        std::vector<std::shared_ptr<const Learned>> learned);

  const Hierarchy& hierarchy(Index object) const { return *trees_[object].hierarchy; }

  /// Checks sizes and numbers, then refits every object. After it `largest_side` is valid. Mode::Paper: makes
  /// its predictions, or says what is missing.
  /// `ahead`: for so many steps, of which this is the first and all others go on as it does.
  Result<void> update(Positions x0, Positions x1, const StepSettings& settings, Index ahead = 1);

  /// Error: not as many numbers as there are vertices, or one that is not finite.
  Result<void> check(Positions x0, Positions x1) const;
  /// Error: a vertex of no triangle has coordinates that are not finite. All others are looked at when they
  /// are used. Precondition: fits.
  Result<void> check_unused(Positions x0, Positions x1) const;

  /// Finds the pairs of leaves that come closer than `distance` and that no certificate proves apart, and
  /// fills their features. Adds to `work`.
  void traverse(const StepSettings& settings, double distance, Work& work);

  /// Says what certificates did in the last traversal, which had the same settings and distance.
  void explain(const StepSettings& settings, double distance, Explanation& out);

  /// Of the last traversal, in an order that depends on the input only.
  std::span<const LeafPairRef> leaf_pairs() const { return leaf_pairs_; }
  std::span<const TraversalTask> tasks() const { return tasks_; }
  std::span<const KineticTree> trees() const { return trees_; }

  /// The largest side of the box around everything during the step, in mesh units.
  double largest_side() const { return largest_side_; }
  /// How many steps the last update looked ahead: as many as were asked for, unless they lead beyond all
  /// numbers; then 1.
  Index ahead() const { return ahead_; }
  /// The largest side during all of them.
  double reach() const { return reach_; }

  /// Whether there are as many numbers as the objects have.
  bool fits(Positions x0, Positions x1) const;
  /// Where a step lies in the motion of the last update, which went from 0 to 1: the times that fit its ends
  /// best, and how far, in the frame, vertices are from where they should be then. `way`: how far the motion
  /// took them; `stride`: how far the step does. All along any axis. Looks at few vertices.
  struct Course {
    float times[2];
    float off, way, stride;
  };
  Course course_of(Positions x0, Positions x1) const;
  /// KineticTree::stray of all objects.
  KineticTree::Strayed stray(Positions x0, Positions x1, const float (&times)[2]) const;
  /// The mean length of an edge of the object whose edges are the shortest, at the begin of the last update;
  /// mesh units, from a sample.
  double mean_edge() const;
  const Frame& frame() const { return frame_; }

 private:
  // Scratch of one thread.
  struct Local {
    std::vector<NodePair> stack;
    ChartTester tester;
    std::uint64_t tests = 0, passes = 0;
    std::uint64_t new_planes = 0, new_planes_found = 0;  // asked for where none was known
    TraversalResult counted;
    std::vector<NodePair> asked;  // pairs of leaves without a common proof, and what is known of them
    std::vector<Index> slots;
    std::vector<std::uint8_t> apart;
  };
  // What is known from earlier steps of a pair of leaves that was asked for a plane.
  struct PlaneMemory {
    PlaneNormal normal{};             // the last that separated it
    std::uint8_t rest = 0, vain = 0;  // not asked for so many steps; so often asked in vain
  };
  // A node that a chart proved, for explanations.
  struct ProvenNode {
    Index object, node, level;
    ChartBook::Proof proof;
  };
  Result<void> check_sizes(Positions x0, Positions x1) const;
  Result<void> move(Positions x0, Positions x1);
  Result<void> predict(Positions x0, Positions x1, const StepSettings& settings);
  void believe_selves(Index object);
  void begin_learning(const StepSettings& settings);
  void prove_selves(Index object, double gap);
  std::span<const BroadPhase::Pair> near_objects(float margin);
  std::size_t enough_tasks(Index a, Index b) const;
  void descend_selves(Index object, const StepSettings& settings, double gap, Work& work);
  std::size_t list_parts(Index object);
  void start_within(Index object, float margin);
  void start_between(Index a, Index b, float margin);
  TraversalShare& add_task(Index a, Index b, float margin);
  Front* front_of(Index a, Index b);
  void keep_fronts();
  void run_task(Index task, bool prove, double gap);
  void ask_near_leaves(Index task, std::span<const NearLeaves> near, bool just_found, double gap,
                       Local& local);
  void ask(Index task, NodePair leaves, Index slot, double gap, Local& local);
  bool proves(const LeafPairRef& pair, Index slot, double gap, Local& local, PlaneNormal& found);
  void remember_proofs();
  void make_plane_memory();
  void note_unproven(const LeafPairRef& pair);
  void fill_features();
  std::uint64_t count_near_leaves(const StepSettings& settings, double distance);
  Reason reason_of(const LeafPairRef& pair) const;
  std::uint64_t hash_of(const LeafPairRef& pair) const;
  PlaneMemory& plane_memory(const LeafPairRef& pair);
  bool may_have_plane(const LeafPairRef& pair, const PlaneMemory& memory) const;

  std::vector<KineticTree> trees_;
  std::vector<std::shared_ptr<const std::vector<Index>>> unused_;  // vertices of no triangle, per object
  std::vector<std::unique_ptr<ChartBook>> books_;
  std::vector<std::unique_ptr<Beliefs>> beliefs_;     // null where nothing was learned
  bool believes_ = false;                             // Mode::Paper
  std::vector<std::vector<LeafProofs>> leaf_proofs_;  // per object and leaf
  Frame frame_;
  double largest_side_ = 0, reach_ = 0;
  Index ahead_ = 1;
  std::size_t leaf_count_ = 0;  // of all objects
  std::size_t steps_ = 0, last_leaf_pairs_ = 0;
  double drawn_ = 0, of_use_ = 0;  // charts drawn in the last steps, and those of them that held
  struct {
    double asked = 0, found = 0;  // in the last steps, where none was known
    bool pay = false;
  } planes_;
  bool ask_for_planes_ =
      false;  // not in the first step: where few pairs have one, it only pays once it is known which

  BroadPhase broad_phase_;
  std::vector<SweptBox> object_boxes_;
  std::vector<TraversalTask> tasks_;
  std::deque<TraversalShare> shares_;  // one per task; more may stand behind, from earlier steps
  std::vector<Front> fronts_;
  bool keeps_fronts_ =
      false;  // only with certificates: without them a step's work is a matter of that step alone
  std::vector<TraversalShare::Part> parts_;  // of the object at hand
  std::vector<NodePair> spread_, spread_below_;
  std::vector<std::uint8_t> self_proven_;  // per node of the object at hand
  std::vector<Index> selves_, selves_below_;
  std::vector<ChartBook::Proof> self_proofs_;
  std::vector<Index> unproven_leaves_;
  std::vector<ProvenNode> proven_nodes_;  // only when explanations are wanted

  std::vector<LeafPairRef> leaf_pairs_;
  std::vector<PlaneMemory> plane_memory_;
  std::vector<std::vector<std::uint8_t>> leaf_needed_;
  std::vector<std::pair<Index, Index>> leaves_to_fill_;
  PerThread<Local> locals_;
};

}  // namespace foldproof
