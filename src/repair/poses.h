/// Poses that differ from the frames of a motion at some vertices only.
#pragma once

#include "repair/scene.h"

namespace foldproof::inline internal {

/// What a repaired frame changes.
struct Correction {
  std::vector<Index> vertices;  ///< Ascending.
  std::vector<double> x;        ///< Their positions.
  std::vector<float> moved;     ///< How far they were moved.
  double largest = 0;           ///< The largest distance that one was moved.

  static Correction between(std::span<const double> frame, std::span<const double> x);
  void apply(std::span<double> frame) const;
};

/// As single precision holds them.
inline void round_to_single(std::span<double> x) {
  for (double& c : x) c = static_cast<float>(c);
}

/// Frames of the input, rounded as they are written.
class Frames {
 public:
  Frames(const RepairInput& input, const RepairScene& scene, bool single_precision)
      : input_(&input), scene_(&scene), single_precision_(single_precision) {}
  Index count() const { return input_->frame_count; }
  Result<std::vector<double>> read(Index k) const;
  /// At a time between frames, vertices are on the straight line.
  Result<std::vector<double>> at_time(double time) const;

 private:
  const RepairInput* input_;
  const RepairScene* scene_;
  bool single_precision_;
};

/// How far corrections are averaged in time, in frames.
constexpr int kSmoothingRadius = 5;
/// Adds to the frame `x` the average of the corrections around number `k`, weighted by a Gaussian, except
/// below `negligible`. `loops`: the last one is the first.
void add_average(std::span<const Correction> corrections, std::size_t k, bool loops, double negligible,
                 std::span<double> x);

}  // namespace foldproof::inline internal
