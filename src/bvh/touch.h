/// Which pairs of features cannot touch, in single precision (docs/soundness.md, B5). Highway includes this
/// file once per instruction set.

#include "bvh/kinetic_bvh.h"

#if defined(FOLDPROOF_BVH_TOUCH_H) == defined(HWY_TARGET_TOGGLE)
#ifdef FOLDPROOF_BVH_TOUCH_H
#undef FOLDPROOF_BVH_TOUCH_H
#else
#define FOLDPROOF_BVH_TOUCH_H
#endif

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace foldproof::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Eight floats, laid out like MovingVertex: in one vector, or a vector per end.
struct Ends {
  using D = hn::CappedTag<float, 8>;
  using V = hn::Vec<D>;
  static constexpr int kParts = 8 / hn::MaxLanes(D());
  V part[kParts];

  static HWY_INLINE Ends Load(const MovingVertex& vertex) {
    Ends e;
    for (int i = 0; i < kParts; ++i) e.part[i] = hn::Load(D(), vertex.x + i * hn::MaxLanes(D()));
    return e;
  }
  static HWY_INLINE Ends Number(float x) {
    Ends e;
    for (auto& part : e.part) part = hn::Set(D(), x);
    return e;
  }
  template <class Function>
  static HWY_INLINE Ends Each(const Ends& a, Function f) {
    Ends e;
    for (int i = 0; i < kParts; ++i) e.part[i] = f(a.part[i]);
    return e;
  }
  template <class Function>
  static HWY_INLINE Ends Each(const Ends& a, const Ends& b, Function f) {
    Ends e;
    for (int i = 0; i < kParts; ++i) e.part[i] = f(a.part[i], b.part[i]);
    return e;
  }
  friend HWY_INLINE Ends operator+(const Ends& a, const Ends& b) {
    return Each(a, b, [](V x, V y) HWY_ATTR { return hn::Add(x, y); });
  }
  friend HWY_INLINE Ends operator-(const Ends& a, const Ends& b) {
    return Each(a, b, [](V x, V y) HWY_ATTR { return hn::Sub(x, y); });
  }
  friend HWY_INLINE Ends operator*(const Ends& a, const Ends& b) {
    return Each(a, b, [](V x, V y) HWY_ATTR { return hn::Mul(x, y); });
  }
  static HWY_INLINE Ends Min(const Ends& a, const Ends& b) {
    return Each(a, b, [](V x, V y) HWY_ATTR { return hn::Min(x, y); });
  }
  static HWY_INLINE Ends Max(const Ends& a, const Ends& b) {
    return Each(a, b, [](V x, V y) HWY_ATTR { return hn::Max(x, y); });
  }
#if HWY_TARGET == HWY_SCALAR
  /// y z x at each end.
  HWY_INLINE Ends Next() const {
    return {{part[1], part[2], part[0], part[3], part[5], part[6], part[4], part[7]}};
  }
  /// The other end in each end's place.
  HWY_INLINE Ends Swapped() const {
    return {{part[4], part[5], part[6], part[7], part[0], part[1], part[2], part[3]}};
  }
#else
  HWY_INLINE Ends Next() const {
    alignas(16) static constexpr std::uint8_t kBytes[16] = {4, 5, 6, 7, 8,  9,  10, 11,
                                                            0, 1, 2, 3, 12, 13, 14, 15};
    const hn::Repartition<std::uint8_t, D> d8;
    const auto bytes = hn::LoadDup128(d8, kBytes);
    return Each(*this, [&](V x) HWY_ATTR {
      return hn::BitCast(D(), hn::TableLookupBytes(hn::BitCast(d8, x), bytes));
    });
  }
  HWY_INLINE Ends Swapped() const {
#if HWY_MAX_BYTES == 16
    return {{part[1], part[0]}};
#else
    return {{hn::ConcatLowerUpper(D(), part[0], part[0])}};
#endif
  }
#endif
  /// Bit k is set where number k is above that of `other`.
  HWY_INLINE unsigned Above(const Ends& other) const {
    unsigned above = 0;
    for (int i = 0; i < kParts; ++i) {
      std::uint8_t bits[8] = {};
      hn::StoreMaskBits(D(), hn::Gt(part[i], other.part[i]), bits);
      above |= unsigned{bits[0]} << (i * hn::MaxLanes(D()));
    }
    return above;
  }
};

/// x + y + z in all places.
HWY_INLINE Ends Sum(const Ends& e) { return e + e.Next() + e.Next().Next(); }

HWY_INLINE Ends CrossNext(const Ends& a, const Ends& b) { return a * b.Next() - a.Next() * b; }  // z x y

/// Theorem 1 along the axes and the diagonals between two of them. The differences of two features' points
/// are the convex hull of N corners: true where none is within the margin of the origin.
template <int N>
HWY_INLINE bool ApartAlongDiagonals(const Ends (&d)[N], float margin) {
  const auto beyond = [&](auto along) HWY_ATTR {
    Ends low = along(d[0]), high = low;
    for (int k = 1; k < N; ++k) {
      const Ends x = along(d[k]);
      low = Ends::Min(low, x);
      high = Ends::Max(high, x);
    }
    return Ends::Max(Ends::Min(low, low.Swapped()), Ends::Number(0) - Ends::Max(high, high.Swapped()));
  };
  const Ends axis = beyond([](const Ends& x) HWY_ATTR { return x; });
  const Ends sum = beyond([](const Ends& x) HWY_ATTR { return x + x.Next(); });
  const Ends difference = beyond([](const Ends& x) HWY_ATTR { return x - x.Next(); });
  return (axis.Above(Ends::Number(margin)) | Ends::Max(sum, difference).Above(Ends::Number(2 * margin))) != 0;
}

/// N3 in single precision: true where the first three corners are never coplanar with the origin, wherever
/// within the margin they are.
HWY_INLINE bool NeverCoplanar(const Ends& d0, const Ends& d1, const Ends& d2, float margin) {
  const auto abs = [](Ends::V x) HWY_ATTR { return hn::Abs(x); };
  const Ends largest = Ends::Max(Ends::Max(Ends::Each(d0, abs), Ends::Each(d1, abs)), Ends::Each(d2, abs));
  const Ends size = Ends::Max(largest, largest.Swapped()) + Ends::Number(margin);
  const Ends faces = size * size.Next();  // xy yz zx
  const Ends error =
      Ends::Number(6.25f * margin) * Sum(faces) + Ends::Number(0x1p-16f) * (faces * size.Next().Next());
  const Ends cross = CrossNext(d1, d2);
  const Ends mixed = CrossNext(d1, d2.Swapped()) + CrossNext(d1.Swapped(), d2);
  const Ends first = d0.Next().Next();  // z x y
  const Ends outer = Sum(first * cross);
  const Ends inner = Sum(first.Swapped() * cross + first * mixed);  // three times the coefficients
  const Ends three = Ends::Number(3) * error, zero = Ends::Number(0);
  const unsigned above = outer.Above(error) & inner.Above(three);
  const unsigned below = (zero - error).Above(outer) & (zero - three).Above(inner);
  constexpr unsigned kSums = 0x11;  // of x, y and z at both ends; the others are the same but for rounding
  return ((above & kSums) == kSums) | ((below & kSums) == kSums);  // no branch: it would be mispredicted
}

}  // namespace foldproof::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
