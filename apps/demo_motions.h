/// A generated motion: two legs that walk and brush against each other.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "foldproof/io.h"

namespace foldproof {

/// How the legs stand.
struct Stride {
  double phase = 0;   ///< Of the gait, in periods of 1.
  double swing = 0;   ///< How far a leg swings, radians.
  double narrow = 0;  ///< How far the feet come inwards: 0 straight down, 1 on top of each other.
};

/// The legs, one surface; a frame per stride.
std::unique_ptr<Motion> legs(std::string name, const std::vector<Stride>& strides);

/// A skirt around the legs that sways with them.
std::unique_ptr<Motion> skirt(std::string name, const std::vector<Stride>& strides);

/// The part of each triangle of the legs: leg_L, hips or leg_R.
std::vector<std::string> leg_parts();

}  // namespace foldproof
