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

/// Frames of the input, rounded as they are written; keeps the last ones that were read.
class Frames {
 public:
  Frames(const RepairInput& input, const RepairScene& scene, bool single_precision)
      : input_(&input), scene_(&scene), single_precision_(single_precision) {}
  Index count() const { return input_->frame_count; }
  /// At a time between frames, vertices are on the straight line. Valid until three more were asked for.
  Result<std::span<const double>> at_time(double time);

 private:
  struct Kept {
    double time = -1;
    std::uint64_t used = 0;
    std::vector<double> x;
  };
  Result<std::span<const double>> read(Index k);
  Kept& make_room();
  Kept* find(double time);

  const RepairInput* input_;
  const RepairScene* scene_;
  bool single_precision_;
  std::array<Kept, 6> kept_;
  std::uint64_t uses_ = 0;
};

/// Averages corrections in time, with a Gaussian.
class Smoother {
 public:
  static constexpr int kRadius = 5;  ///< How far it reaches, in frames.
  explicit Smoother(const RepairScene& scene) : sum_(scene.size(), 0.0) {}
  /// Adds to the frame `x` the average of the corrections around number `k`, except below `negligible`.
  /// `loops`: the last one is the first.
  void add(std::span<const Correction> corrections, std::size_t k, bool loops, double negligible,
           std::span<double> x);

 private:
  std::vector<double> sum_;
};

}  // namespace foldproof::inline internal
