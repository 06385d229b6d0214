/// The charts that a query uses on one object: those that were trained, and those that it draws on the way.
#pragma once

#include "base/parallel.h"
#include "certificate/chart_test.h"
#include "certificate/patch_drawer.h"

namespace foldproof {

/// Scratch of whoever tests: one per thread.
struct ChartTester {
  ChartScratch scratch;
  std::uint64_t tests = 0, triangles = 0;  // charts, and triangles in them
  std::uint64_t of_use = 0;                // charts that held for the first time since they were drawn
};

struct BookSettings {
  Index most_triangles = 4096;   ///< Of a patch; larger ones hardly ever lie in one plane.
  std::uint8_t most_charts = 2;  ///< Of a slot; further ones replace the oldest.
};

class ChartBook {
 public:
  ChartBook(std::shared_ptr<const PatchSlots> slots, std::shared_ptr<const ChartLibrary> trained,
            const BookSettings& settings = {});

  const PatchSlots& slots() const { return *own_.slots(); }
  const ChartLibrary& own() const { return own_; }

  /// The first of a slot's charts that proves its patch, collar included, during the step of `vertices` (see
  /// chart_holds). Different slots may be asked by different threads.
  struct Proof {
    const ChartLibrary* library = nullptr;  ///< null: none of them does
    Index chart = 0;
    explicit operator bool() const { return library != nullptr; }
    std::span<const Index> collar() const { return library->collar(library->charts()[chart]); }
  };
  Proof prove(Index slot, std::span<const MovingVertex> vertices, double gap, ChartTester& tester);

  /// chart_margin of the chart that proved, in the step of `vertices`.
  double margin(const Proof& proof, std::span<const MovingVertex> vertices, ChartScratch& scratch) const {
    return chart_margin(view_of(*proof.library, proof.library->charts()[proof.chart]), vertices, scratch);
  }

  /// The first of a slot's trained charts, untested; false where there is none.
  Proof trained(Index slot) const {
    const Index chart = trained_ ? trained_->first(slot) : kNoIndex;
    return chart == kNoIndex ? Proof{} : Proof{trained_.get(), chart};
  }

  bool has_charts(Index slot) const {
    return own_.first(slot) != kNoIndex || (trained_ && trained_->first(slot) != kNoIndex);
  }
  /// Why the last attempt to draw a slot that has no charts came to nothing; Made when there was none.
  ChartOutcome last_drawing(Index slot) const { return memory_[slot].outcome; }

  /// Says that a node or a pair was not proven and would have saved work. One thread only.
  void want_node(Index node);
  void want_pair(Index slot);

  /// Begins a step. Draws charts of what was wanted in the step before, in the pose halfway through this one:
  /// the larger patches first, as long as their triangles together do not exceed `budget`.
  void begin_step(std::span<const MovingVertex> vertices, std::size_t budget);
  /// How many charts that took.
  std::size_t drawings() const { return drawings_; }
  bool is_trained() const { return trained_ != nullptr; }

 private:
  // What is known about a slot from earlier steps.
  struct Memory {
    std::uint32_t draw_from = 0, test_from = 0;  // not drawn, not tested before these steps
    std::uint8_t vain_draws = 0, vain_tests = 0;
    std::uint8_t drawn = 0;  // own charts
    bool last_was_trained : 1 = false;
    ChartOutcome outcome : 2 = ChartOutcome::Made;  // of the last drawing, if there was one
    Index last = kNoIndex;                          // the chart that held last
  };
  struct LeafNormal {
    Eigen::Vector3f direction;
    std::uint32_t step = 0;
  };
  void draw_nodes(std::span<const MovingVertex> vertices, std::size_t& budget);
  void draw_pairs(std::span<const MovingVertex> vertices, std::size_t& budget);
  const Eigen::Vector3f& leaf_normal(Index leaf, std::span<const MovingVertex> vertices);
  bool looks_flat(Index node, std::span<const MovingVertex> vertices);
  void order(Index slot);
  void draw_orders(std::span<const MovingVertex> vertices);
  void enter(const DrawnPatch& order);
  void rest_from_drawing(Index slot, ChartOutcome outcome);
  bool holds(const ChartLibrary& library, Index chart, std::span<const MovingVertex> vertices, double gap,
             ChartTester& tester) const;

  BookSettings settings_;
  std::shared_ptr<const ChartLibrary> trained_;
  ChartLibrary own_;
  std::vector<Memory> memory_;
  std::vector<Index> wanted_nodes_, wanted_pairs_;
  std::vector<DrawnPatch> orders_;
  std::size_t order_count_ = 0, drawings_ = 0;
  std::vector<std::uint8_t> drawn_;  // per leaf: a node above it has been drawn in this step
  std::vector<LeafNormal> leaf_normals_;
  PerThread<PatchDrawer> drawers_;
  std::uint32_t step_ = 0;
};

}  // namespace foldproof
