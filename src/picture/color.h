/// Conversion between sRGB and linear color values, which is where colors are averaged.
#pragma once

#include "picture/picture.h"

namespace foldproof::picture {

/// Linear red, green and blue; 1 is white.
using LinearColor = Eigen::Array3f;

LinearColor to_linear(Color color);
/// Clamps to [0,1] and rounds.
Color to_color(const LinearColor& light);

}  // namespace foldproof::picture
