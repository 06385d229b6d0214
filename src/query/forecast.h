/// Searching ahead: while a motion goes on as it did, one search serves many steps.
#pragma once

#include "query/meetings.h"
#include "query/outlook.h"
#include "query/scene.h"

namespace foldproof {

/// Keeps what a search that looks ahead found, and says which steps it serves.
///
/// A search that looks ahead finds the pairs of features that may come near each other while every vertex
/// goes on as in the first step, with some room to stray. Where both ends of a later step lie in that room,
/// its collisions are among these pairs (docs/soundness.md, F1), and it needs no search of its own. How far
/// to look is Outlook's guess.
class Forecast {
 public:
  /// Whether the last search serves this step; one for which a search would be made without a forecast is
  /// not. Then `side` is what Scene::largest_side says after an update.
  bool serves(const Scene& scene, Positions x0, Positions x1, const StepSettings& settings, double& side);

  /// For a step that it does not serve: how many steps, this one included, to look ahead.
  Index steps_ahead() const { return ahead_; }

  /// A search begins for a scene that was updated so many steps ahead. Gives the distance, mesh units, below
  /// which pairs are to be found; `distance` is enough for the step alone.
  double begin(const Scene& scene, const StepSettings& settings, double distance);
  /// Keeps the candidates among the pairs of leaves that were found.
  void gather(const NarrowStep& motion, std::span<const LeafPairRef> pairs, std::vector<Chunk>& chunks);
  /// What the search took, candidates included.
  void note_search(const Work& work);
  /// The narrow phase on the step at hand.
  void test(const NarrowStep& step, std::vector<Chunk>& chunks, StepResult& out) const {
    meetings_.test(step, times_, chunks, out);
  }

  /// The next step needs a search.
  void forget() { open_ = false; }

 private:
  bool same_search(const StepSettings& settings) const;

  bool open_ = false;
  StepSettings settings_;
  Index ahead_ = 1;          // steps to look ahead
  double steps_ = 1;         // that the search looked ahead
  double distance_ = 0;      // that it was for, room left out
  double reach_ = 0;         // the same and room, in the frame
  float room_ = 0;           // along any axis, in the frame; 0 where it did not look ahead
  double edge_ = 0;          // mean length, in the frame
  float times_[2] = {0, 1};  // of the step at hand, in the motion that was searched
  Outlook outlook_;
  Meetings meetings_;
};

}  // namespace foldproof
