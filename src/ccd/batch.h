/// The narrow phase's first test on eight pairs at once.
#pragma once

#include "foldproof/ccd.h"

namespace foldproof {

/// Eight pairs of one kind, a lane each: [end][point][axis][lane], points as in FourPoints.
struct alignas(64) PairBatch {
  double x[2][4][3][8];

  void set(int lane, const FourPoints& x0, const FourPoints& x1) {
    for (int point = 0; point < 4; ++point) {
      for (int axis = 0; axis < 3; ++axis) {
        x[0][point][axis][lane] = x0[point][axis];
        x[1][point][axis][lane] = x1[point][axis];
      }
    }
  }
};

/// Bit k is set when pair k never becomes coplanar and is so proven apart (docs/soundness.md, N3). Thickness
/// 0 only. The same bits as vertex_face_ccd and edge_edge_ccd find in their first test, so it changes no
/// answer.
unsigned never_coplanar(const PairBatch& pairs, bool edge_edge);

}  // namespace foldproof
