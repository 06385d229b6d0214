#include "arithmetic/ops.h"

#include <algorithm>
#include <cstring>

#undef HWY_TARGET_INCLUDE  // Highway compiles this file once per instruction set
#define HWY_TARGET_INCLUDE "arithmetic/ops.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "bvh/grid.h"
#include "ccd/lanes.h"

HWY_BEFORE_NAMESPACE();
namespace foldproof::HWY_NAMESPACE {
using testing::ByteOps;
using testing::MaskOps;
using testing::Op;
using testing::Operands;

template <class T>
void Apply(Op op, const Operands<T>& operands) {
  const hn::CappedTag<T, 8> d;
  const auto each = [&](auto function) {
    for (std::size_t i = 0; i < operands.a.size(); i += hn::Lanes(d)) {
      hn::StoreU(function(hn::LoadU(d, &operands.a[i]), hn::LoadU(d, &operands.b[i])), d, &operands.out[i]);
    }
  };
  const auto one = hn::Set(d, T{1});
  using X = hn::Vec<decltype(d)>;
  switch (op) {
    case Op::Add:
      return each([](X a, X b) HWY_ATTR { return hn::Add(a, b); });
    case Op::Sub:
      return each([](X a, X b) HWY_ATTR { return hn::Sub(a, b); });
    case Op::Mul:
      return each([](X a, X b) HWY_ATTR { return hn::Mul(a, b); });
    case Op::Div:
      return each([](X a, X b) HWY_ATTR { return hn::Div(a, b); });
    case Op::Min:
      return each([](X a, X b) HWY_ATTR { return hn::Min(a, b); });
    case Op::Max:
      return each([](X a, X b) HWY_ATTR { return hn::Max(a, b); });
    case Op::CopySign:
      return each([](X a, X b) HWY_ATTR { return hn::CopySign(a, b); });
    case Op::Gt:
      return each([&](X a, X b) HWY_ATTR { return hn::IfThenElseZero(hn::Gt(a, b), one); });
    case Op::Ge:
      return each([&](X a, X b) HWY_ATTR { return hn::IfThenElseZero(hn::Ge(a, b), one); });
    case Op::Lt:
      return each([&](X a, X b) HWY_ATTR { return hn::IfThenElseZero(hn::Lt(a, b), one); });
    case Op::Le:
      return each([&](X a, X b) HWY_ATTR { return hn::IfThenElseZero(hn::Le(a, b), one); });
    case Op::Eq:
      return each([&](X a, X b) HWY_ATTR { return hn::IfThenElseZero(hn::Eq(a, b), one); });
    case Op::Sqrt:
      return each([](X a, X) HWY_ATTR { return hn::Sqrt(a); });
    case Op::Abs:
      return each([](X a, X) HWY_ATTR { return hn::Abs(a); });
    case Op::Neg:
      return each([](X a, X) HWY_ATTR { return hn::Neg(a); });
  }
}
void ApplyDouble(Op op, const Operands<double>& x) { Apply(op, x); }
void ApplyFloat(Op op, const Operands<float>& x) { Apply(op, x); }

void DotAndCross(std::span<const double> a, std::span<const double> b, std::span<const double> c,
                 std::span<double> dot, std::span<double> cross) {
  const D d;
  for (std::size_t i = 0; i < a.size(); i += hn::Lanes(d)) {
    const V x = hn::LoadU(d, &a[i]), y = hn::LoadU(d, &b[i]), z = hn::LoadU(d, &c[i]);
    hn::StoreU(Dot({Number(1), x, y}, {z, x, y}), d, &dot[i]);
    hn::StoreU(Cross({x, x, z}, {x, z, y}).x, d, &cross[i]);
  }
}

void FloatToInt(std::span<const float> from, std::span<std::int32_t> to) {
  const hn::CappedTag<float, 8> d;
  const hn::Rebind<std::int32_t, decltype(d)> di;
  for (std::size_t i = 0; i < from.size(); i += hn::Lanes(d))
    hn::StoreU(hn::ConvertTo(di, hn::LoadU(d, &from[i])), di, &to[i]);
}

void IntToByte(std::span<const std::int32_t> from, std::span<std::uint8_t> to) {
  const hn::CappedTag<std::int32_t, 8> d;
  const hn::Rebind<std::uint8_t, decltype(d)> d8;
  for (std::size_t i = 0; i < from.size(); i += hn::Lanes(d))
    hn::StoreU(hn::DemoteTo(d8, hn::LoadU(d, &from[i])), d8, &to[i]);
}

void DoubleToFloat(std::span<const double> from, std::span<float> to) {
  const hn::CappedTag<double, 4> d;
  const hn::Rebind<float, decltype(d)> df;
  for (std::size_t i = 0; i < from.size(); i += hn::Lanes(d))
    hn::StoreU(hn::DemoteTo(df, hn::LoadU(d, &from[i])), df, &to[i]);
}

void FloatToDouble(std::span<const float> from, std::span<double> to) {
  const hn::CappedTag<double, 4> d;
  const hn::Rebind<float, decltype(d)> df;
  for (std::size_t i = 0; i < from.size(); i += hn::Lanes(d))
    hn::StoreU(hn::PromoteTo(d, hn::LoadU(df, &from[i])), d, &to[i]);
}

void OnBytes(const std::uint8_t (&a)[32], const std::uint8_t (&b)[32], ByteOps& out) {
  const hn::CappedTag<std::uint8_t, 32> d;
  out.equal = 0;
  for (std::size_t lane = 0; lane < 32; lane += hn::Lanes(d)) {
    const auto x = hn::LoadU(d, a + lane), y = hn::LoadU(d, b + lane);
    hn::StoreU(hn::SaturatedSub(x, y), d, out.difference + lane);
    hn::StoreU(hn::Min(x, y), d, out.min + lane);
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(d, hn::Eq(x, y), bits);
    std::uint32_t some;
    std::memcpy(&some, bits, 4);
    out.equal |= some << lane;
  }
}

void OnMasks(unsigned a_bits, unsigned b_bits, MaskOps& out) {
  const D d;
  out = {};
  out.all = true;
  for (std::size_t lane = 0; lane < 8; lane += hn::Lanes(d)) {
    const auto bits = [&](M m) HWY_ATTR {
      std::uint8_t bytes[8] = {};
      hn::StoreMaskBits(d, m, bytes);
      return unsigned{bytes[0]} << lane;
    };
    const auto mask = [&](unsigned all) HWY_ATTR {
      const std::uint8_t bytes[8] = {static_cast<std::uint8_t>(all >> lane & ((1u << hn::MaxLanes(d)) - 1))};
      return hn::LoadMaskBits(d, bytes);
    };
    const M a = mask(a_bits), b = mask(b_bits);
    const V yes = Number(1), no = Number(2);
    out.same |= bits(a);
    out.inverted |= bits(hn::Not(a));
    out.both |= bits(hn::And(a, b));
    out.either |= bits(hn::Or(a, b));
    out.first_only |= bits(hn::AndNot(b, a));
    out.chosen |= bits(hn::Eq(hn::IfThenElse(a, yes, no), yes));
    out.zeroed |= bits(hn::Eq(hn::IfThenElseZero(a, yes), hn::Zero(d)));
    out.any |= Any(a);
    out.all &= hn::AllTrue(d, a);
  }
}

unsigned FirstLanes(unsigned n) {
  const hn::CappedTag<double, 4> d;
  unsigned all = 0;
  for (std::size_t lane = 0; lane < 4; lane += hn::Lanes(d)) {
    alignas(32) double one[4];
    hn::Store(hn::IfThenElseZero(hn::FirstN(d, lane < n ? n - lane : 0), hn::Set(d, 1)), d, one);
    for (std::size_t k = 0; k < hn::Lanes(d); ++k) all |= unsigned{one[k] != 0} << (lane + k);
  }
  return all;
}

bool Permute(const testing::Permuted& out) {
  const hn::CappedTag<float, 8> d;
  const std::size_t n = hn::Lanes(d);
  alignas(32) float numbers[32];
  for (int i = 0; i < 32; ++i) numbers[i] = static_cast<float>(i);
  for (std::size_t row = 0; row < 8; row += n) {
    hn::Vec<decltype(d)> x, y, z, w;
    hn::LoadInterleaved4(d, numbers + 4 * row, x, y, z, w);
    hn::StoreU(x, d, &out.interleaved4[row]);
    hn::StoreU(y, d, &out.interleaved4[8 + row]);
    hn::StoreU(z, d, &out.interleaved4[16 + row]);
    hn::StoreU(w, d, &out.interleaved4[24 + row]);
    hn::StoreInterleaved2(hn::LoadU(d, numbers + row), hn::LoadU(d, numbers + 8 + row), d,
                          &out.interleaved2[2 * row]);
  }
#if HWY_TARGET == HWY_SCALAR
  return false;
#else
  const hn::CappedTag<double, 4> dd;
  alignas(32) static constexpr double kA[4] = {0, 1, 2, 3}, kB[4] = {10, 11, 12, 13};
  for (std::size_t lane = 0; lane < 4; lane += hn::Lanes(dd)) {
    const auto a = hn::Load(dd, kA + lane), b = hn::Load(dd, kB + lane);
    hn::StoreU(hn::InterleaveLower(dd, a, b), dd, &out.lower[lane]);
    hn::StoreU(hn::InterleaveUpper(dd, a, b), dd, &out.upper[lane]);
    hn::StoreU(hn::Shuffle01(a), dd, &out.swapped[lane]);
  }
  return true;
#endif
}

template <std::size_t kWidth>
void QuantizeAll(const testing::OneGrid& one, std::span<const float> x, std::span<std::uint8_t> lower,
                 std::span<std::uint8_t> upper) {
  const hn::CappedTag<float, kWidth> d;
  LeafGrid grid;
  std::fill_n(grid.origin, 8, one.origin);
  std::fill_n(grid.scale, 8, one.scale);
  ByteBox box;
  for (std::size_t i = 0; i < x.size(); i += 8) {
    for (std::size_t lane = 0; lane < 8; lane += hn::Lanes(d)) {
      const auto v = hn::LoadU(d, &x[i + lane]);
      Quantize(v, v, one.margin, grid, lane, box);
    }
    std::copy_n(box.x[0], 8, &lower[i]);
    std::copy_n(box.x[1], 8, &upper[i]);
  }
}
void QuantizeFeatures(const testing::OneGrid& grid, std::span<const float> x, std::span<std::uint8_t> lower,
                      std::span<std::uint8_t> upper) {
  QuantizeAll<8>(grid, x, lower, upper);
}
void QuantizeNodes(const testing::OneGrid& grid, std::span<const float> x, std::span<std::uint8_t> lower,
                   std::span<std::uint8_t> upper) {
  QuantizeAll<4>(grid, x, lower, upper);
}

const char* TargetInUse() { return hwy::TargetName(HWY_TARGET); }

}  // namespace foldproof::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace foldproof {

HWY_EXPORT(ApplyDouble);
HWY_EXPORT(ApplyFloat);
HWY_EXPORT(DotAndCross);
HWY_EXPORT(FloatToInt);
HWY_EXPORT(IntToByte);
HWY_EXPORT(DoubleToFloat);
HWY_EXPORT(FloatToDouble);
HWY_EXPORT(OnBytes);
HWY_EXPORT(OnMasks);
HWY_EXPORT(FirstLanes);
HWY_EXPORT(Permute);
HWY_EXPORT(QuantizeFeatures);
HWY_EXPORT(QuantizeNodes);
HWY_EXPORT(TargetInUse);

namespace testing {

void apply(Op op, const Operands<double>& x) { HWY_DYNAMIC_DISPATCH(ApplyDouble)(op, x); }
void apply(Op op, const Operands<float>& x) { HWY_DYNAMIC_DISPATCH(ApplyFloat)(op, x); }
void dot_and_cross(std::span<const double> a, std::span<const double> b, std::span<const double> c,
                   std::span<double> dot, std::span<double> cross) {
  HWY_DYNAMIC_DISPATCH(DotAndCross)(a, b, c, dot, cross);
}
void float_to_int(std::span<const float> from, std::span<std::int32_t> to) {
  HWY_DYNAMIC_DISPATCH(FloatToInt)(from, to);
}
void int_to_byte(std::span<const std::int32_t> from, std::span<std::uint8_t> to) {
  HWY_DYNAMIC_DISPATCH(IntToByte)(from, to);
}
void double_to_float(std::span<const double> from, std::span<float> to) {
  HWY_DYNAMIC_DISPATCH(DoubleToFloat)(from, to);
}
void float_to_double(std::span<const float> from, std::span<double> to) {
  HWY_DYNAMIC_DISPATCH(FloatToDouble)(from, to);
}
ByteOps on_bytes(const std::uint8_t (&a)[32], const std::uint8_t (&b)[32]) {
  ByteOps out;
  HWY_DYNAMIC_DISPATCH(OnBytes)(a, b, out);
  return out;
}
MaskOps on_masks(unsigned a, unsigned b) {
  MaskOps out;
  HWY_DYNAMIC_DISPATCH(OnMasks)(a, b, out);
  return out;
}
unsigned first_lanes(unsigned n) { return HWY_DYNAMIC_DISPATCH(FirstLanes)(n); }
bool permute(const Permuted& out) { return HWY_DYNAMIC_DISPATCH(Permute)(out); }
void quantize(const OneGrid& grid, bool wide, std::span<const float> x, std::span<std::uint8_t> lower,
              std::span<std::uint8_t> upper) {
  (wide ? HWY_DYNAMIC_DISPATCH(QuantizeFeatures) : HWY_DYNAMIC_DISPATCH(QuantizeNodes))(grid, x, lower,
                                                                                        upper);
}
const char* target_in_use() { return HWY_DYNAMIC_DISPATCH(TargetInUse)(); }
std::int64_t targets_of_build() { return HWY_TARGETS; }

}  // namespace testing
}  // namespace foldproof
#endif  // HWY_ONCE
