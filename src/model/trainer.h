/// Builds charts pose by pose, where the existing ones prove too little.
#pragma once

#include "base/parallel.h"
#include "certificate/chart_builder.h"
#include "certificate/chart_holds.h"
#include "foldproof/model.h"

namespace foldproof::inline internal {

class Trainer {
 public:
  Trainer(std::shared_ptr<const PatchSlots> slots, const TrainSettings& settings);

  /// Builds charts of what the existing ones do not prove in this pose. `positions`: finite, by the user's
  /// vertex ids.
  void learn(Index pose, std::span<const double> positions);
  /// The share of neighborhoods (TrainedPose::proven) that the charts prove in this pose.
  float prove(std::span<const double> positions);

  const std::shared_ptr<ChartLibrary>& charts() const { return charts_; }
  std::vector<HardLeaf> hard_leaves() const;

 private:
  struct Local {
    explicit Local(std::shared_ptr<const PatchSlots> slots) : builder(*slots), trial(std::move(slots)) {}
    ChartBuilder builder;
    ChartLibrary trial;  // a single chart, to test it before it is kept
    ChartScratch scratch;
  };
  // The result of testing a slot and, where no chart holds, building one.
  struct SlotResult {
    Index known_chart = kNoIndex;  // the library's chart that holds
    bool built_holds = false;
    Obstacle obstacle = Obstacle::TooCurved;
    BuiltChart built;
    bool is_proven() const { return known_chart != kNoIndex || built_holds; }
  };
  void prove_pose(std::span<const double> positions);
  template <class Visit>
  void process(std::span<const Index> slots, Visit visit);
  void process(Index slot, SlotResult& out);
  Index first_that_holds(const ChartLibrary& library, Index first, ChartScratch& scratch) const;
  void keep(const SlotResult& result, bool spare);
  void prove_nodes();
  void prove_pairs();
  void mark_proven(Index node, std::span<const Index> ring);
  void build_spares();

  std::shared_ptr<const PatchSlots> slots_;
  TrainSettings settings_;
  std::shared_ptr<ChartLibrary> charts_;
  KineticBvh bvh_;
  std::vector<HardLeaf> hard_leaves_;  // one per leaf; hard if it has references

  std::int64_t budget_ = 0;  // bytes that charts may still take

  // State of the current pose.
  Index pose_ = kNoIndex;              // kNoIndex: nothing is built
  std::size_t proven_ = 0;             // neighborhoods
  std::vector<std::uint8_t> covered_;  // per slot of a pair: a proven node's patch contains it
  std::vector<Index> last_patch_;      // per leaf: the last proven node whose patch has it
  std::vector<Index> proven_nodes_;
  std::vector<Index> level_, next_level_;  // slots to process
  std::vector<SlotResult> results_;
  PerThread<Local> locals_;
};

}  // namespace foldproof::inline internal
