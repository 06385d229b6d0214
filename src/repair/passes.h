/// Repairs frame after frame: the first pass follows the motion away from where it begins, the second makes
/// the corrections calm in time.
#pragma once

#include "repair/analysis.h"

namespace foldproof::inline internal {

/// A frame and its correction.
struct SolvedFrame {
  double time = 0;
  Correction correction = {};
  bool late = false;
  bool held_back = false;  ///< The input's frame is free, and yet it is far from there.
  RepairLimit limit = RepairLimit::None;
  /// Pairs on which the barrier acts on the way to this frame from the one before it in time.
  std::vector<FeaturePair> way = {};
};

/// What a repair works with.
struct RepairTools {
  const RepairScene* scene;
  Frames* frames;
  Analysis* analysis;
  FrameSolver* solver;
  double thickness, range, edge, accuracy;
  std::span<const double> rest;  ///< BarrierRange::rest.
  FrameProblem problem(std::span<const double> before, std::span<const double> begin,
                       std::span<const double> target, std::span<const double> frame, double time) const;
};

/// From one target to the next, that of the input's frame `frame` at a time.
struct Way {
  std::span<const double> last_target, target, frame;
  double time;
};

class Passes {
 public:
  /// `in_betweens`: how many frames may be added between two. `tick`: called once per frame and pass; an
  /// error ends the pass.
  Passes(const RepairTools& tools, Index in_betweens, std::function<Result<void>()> tick)
      : tools_(tools), in_betweens_(in_betweens), tick_(std::move(tick)) {}

  void set_thickness(double thickness) { tools_.thickness = thickness; }
  /// What follow finds is refined later.
  void set_rough(bool rough) { rough_ = rough; }
  /// From a free pose near the last target to a pose `x` near the target, on a way that is proven; `parts`:
  /// in so many parts.
  Result<FrameOutcome> follow(std::span<const double> from, const Way& way, int parts,
                              std::vector<double>& x);

  /// The first pass, from a free pose at a frame forwards, and backwards.
  /// `rough`: the second pass follows. After an error, frames() are those that are done.
  Result<void> follow_motion(Index start, std::span<const double> x, bool rough);
  /// The second pass: each frame again between those before and after it.
  Result<void> relax();

  std::span<const SolvedFrame> frames() const { return frames_; }

 private:
  Result<void> sweep(Index from, int direction, std::span<const double> x);
  Result<bool> advance(double from, double to, std::vector<double>& x, int halvings);
  Result<void> relax_frame(std::size_t i);
  bool is_held_back(double time, const Correction& correction) const;
  Result<void> close_loop();
  Result<std::vector<double>> pose(std::size_t i);

  RepairTools tools_;
  Index in_betweens_;
  std::function<Result<void>()> tick_;
  std::vector<SolvedFrame> frames_;
  bool rough_ = false;
  bool loops_ = false;              // the last frame is the first one
  std::vector<Correction> smooth_;  // of the frames before this pass
};

}  // namespace foldproof::inline internal
