/// Sums with a defined order. Eigen's is another where it has SIMD, and the last digits are then others, too.
#pragma once

#include <cmath>

#include "foldproof/base.h"

namespace foldproof::inline internal {

inline double dot(const Vec3& a, const Vec3& b) { return a.x() * b.x() + a.y() * b.y() + a.z() * b.z(); }
inline double square_length(const Vec3& a) { return dot(a, a); }
inline double length(const Vec3& a) { return std::sqrt(square_length(a)); }
/// Of length 1, if it has a length.
inline Vec3 direction(const Vec3& a) { return square_length(a) > 0 ? Vec3(a / length(a)) : a; }

}  // namespace foldproof::inline internal
