/// Draws charts pose by pose, where those that exist prove too little.
#pragma once

#include "base/parallel.h"
#include "certificate/chart_test.h"
#include "certificate/patch_drawer.h"
#include "foldproof/model.h"

namespace foldproof {

class Trainer {
 public:
  Trainer(std::shared_ptr<const PatchSlots> slots, const TrainSettings& settings);

  /// Draws in this pose what it does not prove yet. `positions`: finite, by the user's vertex ids.
  void learn(Index pose, std::span<const double> positions);
  /// The share of neighbourhoods (TrainedPose::proven) that the charts prove in this pose.
  float prove(std::span<const double> positions);

  const std::shared_ptr<ChartLibrary>& charts() const { return charts_; }
  std::vector<HardLeaf> hard_leaves() const;

 private:
  struct Local {
    explicit Local(std::shared_ptr<const PatchSlots> slots) : drawer(*slots), trial(std::move(slots)) {}
    PatchDrawer drawer;
    ChartLibrary trial;  // of one chart
    ChartScratch scratch;
  };
  /// What came of looking at a slot.
  struct Finding {
    Index held = kNoIndex;  // the library's chart that holds
    bool drawn_holds = false;
    Obstacle obstacle = Obstacle::TooCurved;
    DrawnPatch drawn;
    bool holds() const { return held != kNoIndex || drawn_holds; }
  };
  void enter(std::span<const double> positions);
  template <class Visit>
  void look_at(std::span<const Index> slots, Visit visit);
  void look_at(Index slot, Finding& out);
  Index first_that_holds(const ChartLibrary& library, Index first, ChartScratch& scratch) const;
  void keep(const Finding& finding, bool spare);
  void cover_nodes();
  void cover_pairs();
  void cover(Index node, std::span<const Index> collar);
  void draw_spares();

  std::shared_ptr<const PatchSlots> slots_;
  TrainSettings settings_;
  std::shared_ptr<ChartLibrary> charts_;
  KineticTree tree_;
  std::vector<HardLeaf> hard_;  // one per leaf; without references not hard

  std::int64_t budget_ = 0;  // bytes that charts may still take

  // Of the current pose.
  Index pose_ = kNoIndex;                    // kNoIndex: nothing is drawn
  std::size_t proven_ = 0;                   // neighbourhoods
  std::vector<std::uint8_t> covered_;        // per slot of a pair, behind those of nodes
  std::vector<Index> patch_of_;              // per leaf: the proven node whose patch was covered last
  std::vector<Index> level_, below_, tops_;  // slots to look at; the proven nodes
  std::vector<Finding> findings_;
  PerThread<Local> locals_;
};

}  // namespace foldproof
