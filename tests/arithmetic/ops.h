/// The Highway operations that proofs rely on, one at a time, on the chosen instruction set
/// (oracle/one_target.h).
#pragma once

#include <cstdint>
#include <span>

#include "bvh/kinetic_bvh.h"

namespace foldproof::testing {

/// Binary operations, and unary ones on the first operand. Comparisons return 1 or 0.
enum class Op { Add, Sub, Mul, Div, Min, Max, CopySign, Gt, Ge, Lt, Le, Eq, Sqrt, Abs, Neg };

/// All arrays have the same length, a multiple of 8.
template <class T>
struct Operands {
  std::span<const T> a, b;
  std::span<T> out;
};
void apply(Op op, const Operands<double>& x);
void apply(Op op, const Operands<float>& x);

/// ccd/lanes.h: (1, a, b) . (c, a, b), products in order, and the first coordinate of a cross product,
/// a b - c c.
void dot_and_cross(std::span<const double> a, std::span<const double> b, std::span<const double> c,
                   std::span<double> dot, std::span<double> cross);

void float_to_int(std::span<const float> from, std::span<std::int32_t> to);
void int_to_byte(std::span<const std::int32_t> from, std::span<std::uint8_t> to);
void double_to_float(std::span<const double> from, std::span<float> to);
void float_to_double(std::span<const float> from, std::span<double> to);

/// 32 bytes at a time: the saturated difference, the minimum, and a bit per pair that is set where both are
/// equal.
struct ByteOps {
  std::uint8_t difference[32], min[32];
  std::uint32_t equal;
};
ByteOps on_bytes(const std::uint8_t (&a)[32], const std::uint8_t (&b)[32]);

/// Masks of eight doubles, converted from bits and back.
struct MaskOps {
  unsigned same, inverted, both, either, first_only;  // of a, b
  unsigned chosen, zeroed;                            // lanes that took `yes`, lanes that became 0
  bool any, all;                                      // of a, per register: Any of any, AllTrue of all
};
MaskOps on_masks(unsigned a, unsigned b);
/// FirstN of four doubles, in as many registers as they take.
unsigned first_lanes(unsigned n);

/// Permutations of 0, 1, 2...: each result names the source. Returns false, and leaves `lower`, `upper` and
/// `swapped` unset, where the instruction set has no such operations; there the library does not use them.
struct Permuted {
  std::span<float> interleaved4, interleaved2;  // 32 numbers deinterleaved, and 16 interleaved
  std::span<double> lower, upper, swapped;      // two at a time, of 0 1 2 3 and 10 11 12 13
};
bool permute(const Permuted& out);

/// Quantize of each x as lower and as upper corner; `wide`: as for features, else as for nodes. All eight
/// lanes have the same grid.
struct OneGrid {
  float origin, scale, margin;
};
void quantize(const OneGrid& grid, bool wide, std::span<const float> x, std::span<std::uint8_t> lower,
              std::span<std::uint8_t> upper);

/// The instruction set in use, and all that the build has.
const char* target_in_use();
std::int64_t targets_of_build();

}  // namespace foldproof::testing
