/// Light adds up in linear values, not in those that files hold.
#pragma once

#include "picture/picture.h"

namespace foldproof::picture {

/// Linear light, 1 is white.
using Light = Eigen::Array3f;

Light to_light(Colour colour);
/// Rounds, and cuts what is brighter than white.
Colour to_colour(const Light& light);

}  // namespace foldproof::picture
