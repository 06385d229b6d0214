/// Draws charts pose by pose, where those that exist prove too little.
#pragma once

#include <tbb/enumerable_thread_specific.h>

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
    std::span<const Index> collar;  // of the chart that holds
    bool holds = false;
    bool is_new = false;  // the chart that holds is the drawn one
    Obstacle obstacle = Obstacle::TooCurved;
    DrawnPatch drawn;
  };
  void enter(std::span<const double> positions);
  void look_at(std::span<const Index> slots);
  void look_at(Index slot, Finding& out);
  bool holds(const ChartLibrary& library, Index first, Local& local, Finding& out) const;
  void keep(const Finding& finding);
  void cover_nodes();
  void cover_pairs();
  void cover(Index node, std::span<const Index> collar);

  std::shared_ptr<const PatchSlots> slots_;
  TrainSettings settings_;
  std::shared_ptr<ChartLibrary> charts_;
  KineticTree tree_;
  std::vector<HardLeaf> hard_;  // one per leaf; without references not hard

  // Of the current pose.
  Index pose_ = kNoIndex;              // kNoIndex: nothing is drawn
  std::size_t proven_ = 0;             // neighbourhoods
  std::vector<std::uint8_t> covered_;  // per slot of a pair, behind those of nodes
  std::vector<Index> patch_of_;        // per leaf: the proven node whose patch was covered last
  std::vector<Index> level_, below_;   // slots to look at
  std::vector<Finding> findings_;      // of the slots that were looked at last
  tbb::enumerable_thread_specific<Local> locals_;
};

}  // namespace foldproof
