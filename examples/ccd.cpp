// Prints: the vertex reaches the face at 0.500 of the step
// One vertex falls through one face that stands still.
#include <cstdio>

#include "foldproof/ccd.h"

int main() {
  using namespace foldproof;
  const Vec3 f0(0, 0, 0), f1(2, 0, 0), f2(0, 2, 0);
  const CcdResult found =
      vertex_face_ccd({Vec3(0.5, 0.5, 1), f0, f1, f2}, {Vec3(0.5, 0.5, -1), f0, f1, f2}, {.tolerance = 1e-6});
  if (found.answer != Answer::Hit) return 1;
  std::printf("the vertex reaches the face at %.3f of the step\n", found.toi);
}
