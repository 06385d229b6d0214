/// Rounding bounds of the narrow phase; the letters are the statements of docs/soundness.md.
#pragma once

namespace foldproof {

inline constexpr double kUnit = 0x1p-53;

/// N1: what the evaluated difference of two moving points, projected on a direction no longer than 1 + 5
/// units, can be wrong by, per unit of the largest coordinate.
inline constexpr double kDotError = 32 * kUnit;
/// N3: the same for a determinant of three differences, per unit of the product of the axes' largest
/// coordinates.
inline constexpr double kDetError = 256 * kUnit;
/// N3: what underflow adds to it, for coordinates up to kLarge.
inline constexpr double kDetUnderflow = 1e-260;
/// N1: a vector is only divided by its length when the square of that is at least this, so that underflow is
/// far below its rounding error.
inline constexpr double kLeastSquare = 0x1p-900;

/// Pairs whose extent leaves [kSmall, kLarge) are scaled by a power of two first.
inline constexpr double kLarge = 1e30, kSmall = 1e-30;

/// Tolerances below this many units of the extent are raised to it.
inline constexpr double kResolution = 512 * kUnit;
/// Nor can distances be told apart among the last denormal numbers.
inline constexpr double kLeastTolerance = 0x1p-1060;

}  // namespace foldproof
