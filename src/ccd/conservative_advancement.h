/// The narrow phase on eight pairs at once, one per lane. A lane's answer depends neither on the other lanes
/// nor on the instruction set (docs/soundness.md, "Narrow phase").
#pragma once

#include "foldproof/ccd.h"

namespace foldproof::inline internal {

/// Eight pairs of one kind: [end][point][axis][lane], points as in FourPoints.
struct alignas(64) PairBatch {
  double x[2][4][3][8];

  /// x y z of one point at both ends.
  void set(int lane, int point, const double* x0, const double* x1) {
    for (int axis = 0; axis < 3; ++axis) {
      x[0][point][axis][lane] = x0[axis];
      x[1][point][axis][lane] = x1[axis];
    }
  }
  void set(int lane, const FourPoints& x0, const FourPoints& x1) {
    for (int point = 0; point < 4; ++point) set(lane, point, x0[point].data(), x1[point].data());
  }
};

/// The moving Minkowski differences of eight pairs, called patches: corner k goes from d[0][k] to d[1][k].
/// Two features touch when the origin is in the convex hull of the corners. Vertex-face: a triangle, v - f0,
/// v - f1, v - f2. Edge-edge: a parallelogram, a0 - b0, a1 - b0, a0 - b1, a1 - b1.
struct alignas(64) MinkowskiBatch {
  double d[2][4][3][8];    ///< [end][corner][axis][lane]
  double extent[8];        ///< Largest coordinate of any corner at either end.
  double volume_error[8];  ///< N3
};

/// What the start of the step adds to the settings of a pair (docs/soundness.md, V3).
struct PairSettings {
  /// The tolerance is at least this times the pair's extent at the start.
  double relative_tolerance = 0;
  /// Let g be by how much the pair's distance at the start exceeds the thickness. The thickness of the pair
  /// is larger by the smaller of min_gap_share * g and max_gap, less the tolerance; if that is above twice
  /// the tolerance.
  double min_gap_share = 0, max_gap = 0;
};

/// Conservative advancement (Mirtich 1996) of pairs of one kind through the step.
class ConservativeAdvancement {
 public:
  ConservativeAdvancement(bool edge_edge, const CcdSettings& settings, const PairSettings& pairs = {})
      : edge_edge_(edge_edge), settings_(settings), pairs_(pairs) {}

  /// Loads the first `count` pairs of a batch, at most eight. Bit k is set unless a first test proves pair k
  /// separated.
  unsigned load(const PairBatch& pairs, int count);
  /// Starts pair k of the loaded batch in a free lane, which is returned. `latest`: see CcdSettings.
  int start(int k, double latest);
  bool full() const { return busy_ == 0xff; }
  bool busy() const { return busy_ != 0; }
  /// One iteration of all lanes. Bit k is set when lane k has a result; it is free again.
  unsigned iterate();
  /// The result of a lane that finished in the last iteration.
  const CcdResult& result(int lane) const { return results_[lane]; }

  struct alignas(64) Lanes {
    MinkowskiBatch patch;
    double thickness[8], tolerance[8], latest[8];
    double t[8];         ///< Proven free of contact before.
    double interval[8];  ///< Length of the next time interval to be proven free as a whole.
  };
  /// Bits of the lanes that finished, by answer. `stuck`: cannot advance.
  struct Answers {
    unsigned separated, hit, stuck;
  };

 private:
  double tolerance(int k) const;
  void add_gaps(const PairBatch& pairs, int count);

  bool edge_edge_;
  CcdSettings settings_;
  PairSettings pairs_;
  MinkowskiBatch loaded_;
  double scale_[8], thickness_[8];  // of the loaded pairs; the thickness is scaled
  Lanes lanes_ = {};
  int iterations_[8];
  unsigned busy_ = 0;
  CcdResult results_[8];
};

/// Computes the patches of a batch. Bit k is set when pair k is proven separated at thickness 0.
unsigned make_patches(const PairBatch& pairs, bool edge_edge, MinkowskiBatch& patches);

/// Scales a pair's differences by a power of two, which is returned, so that products neither overflow nor
/// underflow. Points are not scaled: beside a large common coordinate digits of the others would be lost.
double scale_differences(const PairBatch& pairs, bool edge_edge, int lane, double thickness,
                         MinkowskiBatch& patches);

}  // namespace foldproof::inline internal
