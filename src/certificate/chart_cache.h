/// The charts that a query uses on one object: those of its model, and those built from step to step.
#pragma once

#include "base/parallel.h"
#include "base/typed_index.h"
#include "certificate/chart_builder.h"
#include "certificate/chart_holds.h"

namespace foldproof::inline internal {

/// Scratch and work counters of tests: one per thread.
struct ChartTester {
  ChartScratch scratch;
  std::uint64_t tests = 0, triangles = 0;  // charts tested, and triangles in them
  std::uint64_t first_proofs = 0;          // charts that held for the first time since they were built
};

class ChartCache {
 public:
  /// `trained`: the model's charts, or null.
  ChartCache(std::shared_ptr<const PatchSlots> slots, std::shared_ptr<const ChartLibrary> trained);

  const PatchSlots& slots() const { return *own_.slots(); }

  /// A chart that proves its patch, ring included, during a step; false where there is none.
  struct Proof {
    const ChartLibrary* library = nullptr;
    Index chart = 0;
    explicit operator bool() const { return library != nullptr; }
    std::span<const Index> ring() const { return library->ring(library->charts()[chart]); }
  };
  /// Tests a slot's charts until one holds in the step of `vertices` (see chart_holds). Threads may call this
  /// at once for different slots.
  Proof prove(SlotIndex slot, std::span<const MovingVertex> vertices, double gap, ChartTester& tester);

  /// chart_margin of the proof's chart in the step of `vertices`.
  double margin(const Proof& proof, std::span<const MovingVertex> vertices, ChartScratch& scratch) const {
    return chart_margin(view_of(*proof.library, proof.library->charts()[proof.chart]), vertices, scratch);
  }

  /// The first of a slot's trained charts, untested.
  Proof trained(SlotIndex slot) const {
    const Index chart = trained_ ? trained_->first(slot) : kNoIndex;
    return chart == kNoIndex ? Proof{} : Proof{trained_.get(), chart};
  }

  bool has_charts(SlotIndex slot) const {
    return own_.first(slot) != kNoIndex || (trained_ && trained_->first(slot) != kNoIndex);
  }
  /// The outcome of the last build for a slot without charts; Made when none was tried.
  ChartOutcome last_outcome(SlotIndex slot) const { return states_[slot].outcome; }

  /// Whether a node or a pair of leaves that was not proven wants a chart, and requests for all that do.
  bool wants_node(NodeIndex node) const;
  bool wants_pair(SlotIndex slot) const { return states_[slot].build_from <= step_; }
  void request_nodes(std::span<const NodeIndex> nodes) { append(requested_nodes_, nodes); }
  void request_pairs(std::span<const SlotIndex> slots) { append(requested_pairs_, slots); }

  /// Begins a step. Builds the charts that were requested in the last step, in the pose halfway through this
  /// one, larger patches first, until their triangles would exceed `budget`.
  void begin_step(std::span<const MovingVertex> vertices, std::size_t budget);
  /// Begins a step in which nothing moves. Builds charts that nobody requested, from the root down, as long
  /// as most of them succeed: they hold at once.
  void begin_pose(std::span<const MovingVertex> vertices);
  /// Attempts at a chart in this step, failed ones included.
  std::size_t charts_built() const { return charts_built_; }
  bool is_trained() const { return trained_ != nullptr; }

 private:
  // The history of a slot.
  struct SlotState {
    std::uint32_t build_from = 0, test_from = 0;  // no build, no test before these steps
    std::uint8_t failed_builds = 0, failed_tests = 0;
    std::uint8_t built = 0;  // own charts
    bool last_was_trained : 1 = false;
    ChartOutcome outcome : 2 = ChartOutcome::Made;  // of the last build, if there was one
    Index last = kNoIndex;                          // the chart that held last
  };
  enum class Cover : std::uint8_t { None, MaybeBuilt, Built };
  struct LeafNormal {
    std::array<float, 3> direction{};
    std::uint32_t step = 0;
  };
  template <class T>
  static void append(std::vector<T>& all, std::span<const T> more) {
    all.insert(all.end(), more.begin(), more.end());
  }
  void build_nodes(std::span<const MovingVertex> vertices, std::size_t& budget, double least_made);
  void sort_requested_nodes();
  void choose_nodes(std::span<const MovingVertex> vertices, std::size_t& budget);
  void build_pairs(std::span<const MovingVertex> vertices, std::size_t& budget);
  void cover(NodeIndex node, Cover value);
  const std::array<float, 3>& leaf_normal(Index leaf, std::span<const MovingVertex> vertices);
  bool looks_flat(NodeIndex node, std::span<const MovingVertex> vertices);
  void add_build(SlotIndex slot);
  void run_builds(std::span<const MovingVertex> vertices);
  Index place(const BuiltChart& build);
  void back_off(SlotIndex slot, ChartOutcome outcome);
  bool holds(const ChartLibrary& library, Index chart, std::span<const MovingVertex> vertices, double gap,
             ChartTester& tester) const;

  std::shared_ptr<const ChartLibrary> trained_;
  ChartLibrary own_;
  std::vector<SlotState> states_;
  std::vector<NodeIndex> requested_nodes_, sorted_nodes_;
  std::vector<SlotIndex> requested_pairs_;
  std::vector<Index> size_begin_;   // scratch
  std::vector<BuiltChart> builds_;  // the first build_count_; the rest keep their buffers
  std::vector<Index> places_;       // where the library has their charts; parallel to builds_
  std::size_t build_count_ = 0, charts_built_ = 0;
  std::vector<Cover> covered_;  // per leaf: whether a chart of a node above it is built in this step
  std::vector<NodeIndex> maybe_flat_;
  std::vector<std::uint8_t> is_flat_;  // parallel to maybe_flat_
  std::vector<LeafNormal> leaf_normals_;
  PerThread<ChartBuilder> builders_;
  std::uint32_t step_ = 0;
};

}  // namespace foldproof::inline internal
