/// Highway's operations that proofs lean on, one at a time, on whichever instruction set is chosen
/// (oracle/one_target.h).
#pragma once

#include <cstdint>
#include <span>

#include "bvh/kinetic.h"

namespace foldproof::testing {

/// Of two numbers, or of the first alone. Comparisons give 1 or 0.
enum class Op { Add, Sub, Mul, Div, Min, Max, CopySign, Gt, Ge, Lt, Le, Eq, Sqrt, Abs, Neg };

/// All arrays are equally long, a multiple of 8.
template <class T>
struct Operands {
  std::span<const T> a, b;
  std::span<T> out;
};
void apply(Op op, const Operands<double>& x);
void apply(Op op, const Operands<float>& x);

/// ccd/lanes.h: (1, a, b) . (c, a, b) with the products one after the other, and the first number of a cross
/// product, a b - c c.
void dot_and_cross(std::span<const double> a, std::span<const double> b, std::span<const double> c,
                   std::span<double> dot, std::span<double> cross);

void float_to_int(std::span<const float> from, std::span<std::int32_t> to);
void int_to_byte(std::span<const std::int32_t> from, std::span<std::uint8_t> to);
void double_to_float(std::span<const double> from, std::span<float> to);
void float_to_double(std::span<const float> from, std::span<double> to);

/// 32 bytes at a time: a -| b, the smaller, and a bit per pair that says whether both are equal.
struct ByteOps {
  std::uint8_t difference[32], least[32];
  std::uint32_t equal;
};
ByteOps on_bytes(const std::uint8_t (&a)[32], const std::uint8_t (&b)[32]);

/// Eight doubles: what comes back of masks that are made of bits.
struct MaskOps {
  unsigned same, inverted, both, either, first_only;  // of a, b
  unsigned chosen, zeroed;                            // lanes that took `yes`, lanes that became 0
  bool any, all;                                      // of a, per register: Any of any, AllTrue of all
};
MaskOps on_masks(unsigned a, unsigned b);
/// The first n lanes of as many as a register of four doubles has; the lanes of each in turn.
unsigned first_lanes(unsigned n);

/// Numbers 0, 1, 2... moved about: names of where each came from. Empty where an instruction set has no such
/// operation, and the library another way.
struct Moved {
  std::span<float> interleaved4, interleaved2;  // 32 numbers apart and together again
  std::span<double> lower, upper, swapped;      // two at a time, of 0 1 2 3 and 10 11 12 13
};
bool move_about(const Moved& moved);

/// PlaceOnGrid of each x as lower and as upper corner, with `wide` as for features, else as for nodes. All
/// eight lanes have the same grid.
struct OneGrid {
  float origin, scale, margin;
};
void place_on_grid(const OneGrid& grid, bool wide, std::span<const float> x, std::span<std::uint8_t> lower,
                   std::span<std::uint8_t> upper);

/// The instruction set in use, and all that the build has.
const char* target_in_use();
std::int64_t targets_of_build();

}  // namespace foldproof::testing
