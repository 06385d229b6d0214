// The assumptions of every rounding bound in docs/soundness.md: one rounding to nearest per operation,
// denormals included; and those about signs, comparisons, minima and masks.
#include <cmath>
#include <random>

#include "arithmetic/everything.h"
#include "arithmetic/exact.h"

namespace foldproof::testing {
namespace {

using Rng = std::mt19937_64;

double random_bits(Rng& rng) { return std::bit_cast<double>(rng()); }

// Pairs whose sums and products are hard: near in exponent, near the ends of the range, one unit apart.
struct Pairs {
  std::vector<double> a, b;
};
Pairs hard_pairs(std::size_t count) {
  const std::vector<double> edges = edge_numbers<double>();
  Rng rng(5);
  Pairs p;
  const auto exponent = [](double x) { return std::isfinite(x) && x != 0 ? std::ilogb(x) : 0; };
  while (p.a.size() < count) {
    const double a = rng() % 2 ? edges[rng() % edges.size()] : random_bits(rng);
    double b = rng() % 2 ? edges[rng() % edges.size()] : random_bits(rng);
    const int near = static_cast<int>(rng() % 120) - 60;
    switch (rng() % 6) {
      case 0:
        b = std::ldexp(b, exponent(a) - exponent(b) + near);
        break;  // sums
      case 1:
        b = std::ldexp(b, -1074 - exponent(a) - exponent(b) + near);
        break;  // products underflow
      case 2:
        b = std::ldexp(b, 1023 - exponent(a) - exponent(b) + near / 8);
        break;  // and overflow
      case 3:
        b = std::ldexp(b, exponent(a) + 1074 - exponent(b) + near);
        break;  // quotients underflow
      case 4:
        b = std::nextafter(rng() % 2 ? a : -a, random_bits(rng));
        break;  // cancellation
      default:
        break;
    }
    p.a.push_back(a);
    p.b.push_back(b);
  }
  return p;
}

double scalar(Op op, double a, double b) {
  switch (op) {
    case Op::Add:
      return a + b;
    case Op::Sub:
      return a - b;
    case Op::Mul:
      return a * b;
    case Op::Div:
      return a / b;
    case Op::Sqrt:
      return std::sqrt(a);
    default:
      return 0;
  }
}

bool rounded_once(Op op, double a, double b) {
  const double r = scalar(op, a, b);
  if (!std::isfinite(a) || !std::isfinite(b) || r != r) return true;
  if (op == Op::Div && b == 0) return true;
  return is_nearest(r, [&](const Dyadic& m) {
    if (op == Op::Add) return (Dyadic(a) + b - m).sign();
    if (op == Op::Sub) return (Dyadic(a) - b - m).sign();
    if (op == Op::Mul) return (Dyadic(a) * b - m).sign();
    if (op == Op::Div) return (Dyadic(a) - m * b).sign() * (b < 0 ? -1 : 1);
    return m.sign() < 0 ? 1 : (Dyadic(a) - m * m).sign();
  });
}

TEST(Rounding, OfDoublesIsToNearestEvenOnce) {
  const Pairs p = hard_pairs(60000);
  for (const Op op : {Op::Add, Op::Sub, Op::Mul, Op::Div, Op::Sqrt}) {
    for (std::size_t i = 0; i < p.a.size(); ++i)
      ASSERT_TRUE(rounded_once(op, p.a[i], p.b[i])) << p.a[i] << ' ' << p.b[i];
  }
}

TEST(Rounding, OfAllSquareRootsExponentsIsToNearest) {
  for (const double x : edge_numbers<double>()) ASSERT_TRUE(rounded_once(Op::Sqrt, x, 0)) << x;
}

// The lanes are compared with the scalar operations, which the tests above check.
TEST(Rounding, LanesRoundLikeScalars) {
  Pairs p = hard_pairs(1 << 20);
  const std::vector<double> edges = edge_numbers<double>();
  for (std::size_t i = 0; i < edges.size() / 8 * 8; ++i) p.a[i] = edges[i];
  on_every_target([&] {
    std::vector<double> out(p.a.size());
    for (const Op op : {Op::Add, Op::Sub, Op::Mul, Op::Div, Op::Sqrt}) {
      apply(op, Operands<double>{p.a, p.b, out});
      for (std::size_t i = 0; i < out.size(); ++i)
        ASSERT_TRUE(identical(out[i], scalar(op, p.a[i], p.b[i]))) << p.a[i] << ' ' << p.b[i];
    }
  });
}

// Floats: computing one operation in double and rounding the result equals rounding once.
TEST(Rounding, OfFloatsIsToNearestOnce) {
  const std::vector<float> edges = edge_numbers<float>();
  Rng rng(6);
  std::vector<float> a, b;
  const auto random_float = [&] {
    return rng() % 2 ? edges[rng() % edges.size()] : std::bit_cast<float>(std::uint32_t(rng()));
  };
  while (a.size() < 1 << 20) {
    a.push_back(random_float());
    b.push_back(rng() % 2 ? random_float() : std::ldexp(random_float(), static_cast<int>(rng() % 300) - 150));
  }
  on_every_target([&] {
    std::vector<float> out(a.size());
    for (const Op op : {Op::Add, Op::Sub, Op::Mul, Op::Div}) {
      apply(op, Operands<float>{a, b, out});
      for (std::size_t i = 0; i < out.size(); ++i)
        ASSERT_TRUE(identical(out[i], static_cast<float>(scalar(op, a[i], b[i])))) << a[i] << ' ' << b[i];
    }
  });
}

// x = 1 + 2^-30 and 1 - 2^-30: x y loses its last digit, which a fused operation would keep.
TEST(Rounding, ProductsAreRoundedBeforeTheyAreAdded) {
  const double x = 1 + 0x1p-30, y = 1 - 0x1p-30;
  ASSERT_NE(std::fma(x, y, -1.0), x * y - 1);
  Rng rng(7);
  std::uniform_real_distribution<double> unit(-2, 2);
  std::vector<double> a{x}, b{y}, c{1};
  while (a.size() < 4096) {
    for (auto* list : {&a, &b, &c}) list->push_back(unit(rng));
  }
  on_every_target([&] {
    std::vector<double> dot(a.size()), cross(a.size());
    dot_and_cross(a, b, c, dot, cross);
    int fused = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
      const volatile double aa = a[i] * a[i], bb = b[i] * b[i], ab = a[i] * b[i], cc = c[i] * c[i];
      const volatile double sum = c[i] + aa;
      ASSERT_EQ(dot[i], sum + bb);
      ASSERT_EQ(cross[i], ab - cc);
      fused += std::fma(a[i], b[i], -cc) != ab - cc;
    }
    EXPECT_GT(fused, 500);  // fused operations would fail this test
  });
}

// A minimum of both zeros may be either of them. Nothing is assumed of minima of NaN.
template <class T>
void expect_orders(const std::vector<T>& numbers) {
  std::vector<T> a, b;
  Rng rng(8);
  while (a.size() < 1 << 18) {
    a.push_back(numbers[rng() % numbers.size()]);
    b.push_back(rng() % 8 ? numbers[rng() % numbers.size()] : rng() % 2 ? -a.back() : a.back());
  }
  on_every_target([&] {
    std::vector<T> out(a.size());
    const auto each = [&](Op op, const auto& good) {
      apply(op, Operands<T>{a, b, out});
      for (std::size_t i = 0; i < out.size(); ++i)
        ASSERT_TRUE(good(a[i], b[i], out[i])) << int(op) << ": " << a[i] << ' ' << b[i] << ' ' << out[i];
    };
    const auto none = [](T x, T y) { return std::isnan(x) || std::isnan(y); };
    const auto one_of = [](T x, T y, T r) { return identical(r, x) || identical(r, y); };
    each(Op::Min, [&](T x, T y, T r) { return none(x, y) || (r <= x && r <= y && one_of(x, y, r)); });
    each(Op::Max, [&](T x, T y, T r) { return none(x, y) || (r >= x && r >= y && one_of(x, y, r)); });
    // Comparisons are false for NaN.
    each(Op::Gt, [](T x, T y, T r) { return r == (x > y); });
    each(Op::Ge, [](T x, T y, T r) { return r == (x >= y); });
    each(Op::Lt, [](T x, T y, T r) { return r == (x < y); });
    each(Op::Le, [](T x, T y, T r) { return r == (x <= y); });
    each(Op::Eq, [](T x, T y, T r) { return r == (x == y); });
    each(Op::Abs, [](T x, T, T r) { return identical(r, std::abs(x)) && !std::signbit(r); });
    each(Op::Neg, [](T x, T, T r) { return identical(r, -x); });
    each(Op::CopySign, [](T x, T y, T r) { return identical(r, std::copysign(x, y)); });
  });
}
TEST(Order, OfDoubles) { expect_orders(edge_numbers<double>()); }
TEST(Order, OfFloats) { expect_orders(edge_numbers<float>()); }

TEST(Bytes, AllPairs) {
  on_every_target([] {
    for (int x = 0; x < 256; ++x) {
      for (int first = 0; first < 256; first += 31) {  // every y, in every lane at some time
        std::uint8_t a[32], b[32];
        for (int k = 0; k < 32; ++k) {
          a[k] = static_cast<std::uint8_t>(x);
          b[k] = static_cast<std::uint8_t>(first + k);
        }
        const ByteOps out = on_bytes(a, b);
        for (int k = 0; k < 32; ++k) {
          ASSERT_EQ(out.difference[k], std::max(a[k] - b[k], 0));
          ASSERT_EQ(out.min[k], std::min(a[k], b[k]));
          ASSERT_EQ(out.equal >> k & 1, a[k] == b[k]);
        }
      }
    }
  });
}

TEST(Masks, AllPairs) {
  on_every_target([] {
    for (unsigned a = 0; a < 256; ++a) {
      for (unsigned b = 0; b < 256; ++b) {
        const MaskOps out = on_masks(a, b);
        ASSERT_EQ(out.same, a);
        ASSERT_EQ(out.inverted, ~a & 255);
        ASSERT_EQ(out.both, a & b);
        ASSERT_EQ(out.either, a | b);
        ASSERT_EQ(out.first_only, a & ~b);
        ASSERT_EQ(out.chosen, a);
        ASSERT_EQ(out.zeroed, ~a & 255);
        ASSERT_EQ(out.any, a != 0);
        ASSERT_EQ(out.all, a == 255);
      }
    }
    for (unsigned n = 0; n <= 8; ++n) ASSERT_EQ(first_lanes(n), (1u << std::min(n, 4u)) - 1);
  });
}

TEST(Permutations, MoveEachNumberToItsLane) {
  on_every_target([] {
    std::vector<float> four(32), two(16);
    std::vector<double> lower(4), upper(4), swapped(4);
    const bool crosses = permute({four, two, lower, upper, swapped});
    for (int i = 0; i < 32; ++i) ASSERT_EQ(four[i], 4 * (i % 8) + i / 8);
    // Per register: x y x y...
    for (int i = 0; i < 16; ++i) ASSERT_EQ(two[i], i / 2 + 8 * (i % 2));
    if (!crosses) return;
    for (int i = 0; i < 4; ++i) {  // two by two
      const int pair = i / 2 * 2;
      ASSERT_EQ(lower[i], pair + 10 * (i % 2));
      ASSERT_EQ(upper[i], pair + 1 + 10 * (i % 2));
      ASSERT_EQ(swapped[i], i ^ 1);
    }
  });
}

}  // namespace
}  // namespace foldproof::testing
