/// Motions that are made here, so that the bench runs without any data.
#pragma once

#include <memory>

#include "foldproof/io.h"

namespace foldproof::bench {

/// A closed tube with 20,608 triangles that bends until its two ends cross.
std::unique_ptr<Motion> bending_cylinder();

/// A closed sphere with 81,920 triangles that is pressed flat and swells sideways; nothing touches.
std::unique_ptr<Motion> squashed_sphere();

/// A square sheet with 89,888 triangles that is folded in half over a narrow bend; nothing touches.
std::unique_ptr<Motion> folding_cloth();

/// Two sheets that lie on each other and slide: the bumps of the one touch the other in some hundred places.
std::unique_ptr<Motion> pressed_cloths();

/// Sixty-four balls that are pressed together until all neighbors touch and flatten each other.
std::unique_ptr<Motion> ball_heap();

/// A square sheet with waves that run over it, 2 * side^2 triangles. It never touches itself.
std::unique_ptr<Motion> waving_cloth(Index side);

}  // namespace foldproof::bench
