/// Rounding bounds of the narrow phase; the letters are the statements of docs/soundness.md.
#pragma once

namespace foldproof::inline internal {

inline constexpr double kUnit = 0x1p-53;

/// N1: error of the difference of two moving points, projected on a direction no longer than 1 + 5 units,
/// relative to the largest coordinate.
inline constexpr double kDotError = 23 * kUnit;
/// N3: error of a determinant of three differences, relative to the product of the axes' largest coordinates.
inline constexpr double kDetError = 139 * kUnit;
/// N3: underflow adds this to it, for coordinates up to kLarge.
inline constexpr double kDetUnderflow = 1e-260;
/// N1: a vector is only normalized when its squared length is at least this, so that underflow is far below
/// its rounding error.
inline constexpr double kMinSquare = 0x1p-900;

/// E1: error of a determinant of three differences of doubles, relative to the product of the largest
/// difference along each axis.
inline constexpr double kVolumeError = 64 * 0x1p-53;
/// E1: outside of this range a product of three differences may overflow or lose its last digits
/// (tests/ccd/filter_limits_test.cpp).
inline constexpr double kSmallestFiltered = 1e-97, kLargestFiltered = 1e97;

/// Pairs whose extent is outside [kSmall, kLarge) are scaled by a power of two first.
inline constexpr double kLarge = 1e30, kSmall = 1e-30;

/// Smaller tolerances, relative to the extent, are raised to this.
inline constexpr double kResolution = 512 * kUnit;
/// The smallest tolerance of all: distances near the smallest denormals cannot be resolved.
inline constexpr double kMinTolerance = 0x1p-1060;

}  // namespace foldproof::inline internal
