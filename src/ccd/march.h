/// The narrow phase on eight pairs at once, a lane each. What a lane answers does not depend on its
/// neighbours, nor on the instruction set (docs/soundness.md, "Narrow phase").
#pragma once

#include "foldproof/ccd.h"

namespace foldproof {

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

/// The Minkowski differences of eight pairs, moving: corner k goes from d[0][k] to d[1][k]. Two features
/// touch when the origin lies in the convex hull of their corners. Those are v - f0, v - f1, v - f2 for
/// vertex-face, a triangle, and a0 - b0, a1 - b0, a0 - b1, a1 - b1 for edge-edge, a parallelogram.
struct alignas(64) PatchBatch {
  double d[2][4][3][8];    ///< [end][corner][axis][lane]
  double extent[8];        ///< Largest coordinate of any corner at either end.
  double volume_error[8];  ///< N3
};

/// Follows pairs of one kind through the step.
class March {
 public:
  March(bool edge_edge, const CcdSettings& settings) : edge_edge_(edge_edge), settings_(settings) {}

  /// Takes the first `count` pairs of a batch, at most eight. Bit k is set unless the first test proves pair
  /// k apart.
  unsigned take(const PairBatch& pairs, int count);
  /// Lets pair k of those taken last start in a free lane, which is returned; until `latest`, as in
  /// CcdSettings.
  int start(int k, double latest);
  bool full() const { return busy_ == 0xff; }
  bool busy() const { return busy_ != 0; }
  /// One look for all lanes. Bit k is set when lane k is done, and free again.
  unsigned look();
  /// Of a lane that was done in the last look.
  const CcdResult& result(int lane) const { return results_[lane]; }

  struct alignas(64) Lanes {
    PatchBatch patch;
    double thickness[8], tolerance[8], latest[8];
    double t[8];       ///< Nothing touches before.
    double stride[8];  ///< Of what follows a turning pair.
  };
  /// Bits of lanes: who came to an answer, and to which.
  struct Answers {
    unsigned separated, hit, stuck;
  };

 private:
  void rescue(const PairBatch& pairs, int lane);

  bool edge_edge_;
  CcdSettings settings_;
  PatchBatch taken_;
  double scale_[8];  // of what was taken
  Lanes lanes_ = {};
  int iterations_[8];
  unsigned busy_ = 0;
  CcdResult results_[8];
};

/// A closest pair of points of the first pair of a batch, standing still where it is at t=0.
Closest closest_of_first(PairBatch& pairs, bool edge_edge);

}  // namespace foldproof
