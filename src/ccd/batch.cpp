#include "ccd/batch.h"

#include "ccd/bounds.h"

#undef HWY_TARGET_INCLUDE  // Highway compiles this file once per instruction set
#define HWY_TARGET_INCLUDE "ccd/batch.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace foldproof::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<double, 8>;
using V = hn::Vec<D>;

struct Vector {
  V x, y, z;
};

// Each in the order of operations that the scalar code has, so that every bit agrees.
HWY_INLINE Vector Minus(const Vector& a, const Vector& b) {
  return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}
HWY_INLINE Vector Plus(const Vector& a, const Vector& b) {
  return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z)};
}
HWY_INLINE V Dot(const Vector& a, const Vector& b) {
  return hn::Add(hn::Add(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y)), hn::Mul(a.z, b.z));
}
HWY_INLINE Vector Cross(const Vector& a, const Vector& b) {
  return {hn::Sub(hn::Mul(a.y, b.z), hn::Mul(a.z, b.y)), hn::Sub(hn::Mul(a.z, b.x), hn::Mul(a.x, b.z)),
          hn::Sub(hn::Mul(a.x, b.y), hn::Mul(a.y, b.x))};
}

HWY_INLINE void Grow(Vector& size, const Vector& d) {
  size.x = hn::Max(size.x, hn::Abs(d.x));
  size.y = hn::Max(size.y, hn::Abs(d.y));
  size.z = hn::Max(size.z, hn::Abs(d.z));
}

// Corners 0, 1, 2 of the moving patch at one end; `size` also takes in corner 3.
template <bool kEdgeEdge>
HWY_INLINE void Corners(const double (&x)[4][3][8], std::size_t lane, Vector (&d)[3], Vector& size) {
  const D tag;
  const auto point = [&](int k) {
    return Vector{hn::Load(tag, x[k][0] + lane), hn::Load(tag, x[k][1] + lane),
                  hn::Load(tag, x[k][2] + lane)};
  };
  const Vector p0 = point(0), p1 = point(1), p2 = point(2), p3 = point(3);
  if constexpr (kEdgeEdge) {
    d[0] = Minus(p0, p2);
    d[1] = Minus(p1, p2);
    d[2] = Minus(p0, p3);
    Grow(size, Minus(p1, p3));
  } else {
    d[0] = Minus(p0, p1);
    d[1] = Minus(p0, p2);
    d[2] = Minus(p0, p3);
  }
  for (const Vector& corner : d) Grow(size, corner);
}

template <bool kEdgeEdge>
HWY_INLINE unsigned NeverCoplanar(const PairBatch& pairs) {
  const D tag;
  unsigned proven = 0;
  for (std::size_t lane = 0; lane < 8; lane += hn::Lanes(tag)) {
    Vector a[3], e[3], size{hn::Zero(tag), hn::Zero(tag), hn::Zero(tag)};
    Corners<kEdgeEdge>(pairs.x[0], lane, a, size);
    Corners<kEdgeEdge>(pairs.x[1], lane, e, size);
    const Vector aa = Cross(a[1], a[2]), ee = Cross(e[1], e[2]);
    const Vector ae = Plus(Cross(a[1], e[2]), Cross(e[1], a[2]));
    const V three = hn::Set(tag, 3.0);
    const V b0 = Dot(a[0], aa), b1 = hn::Div(hn::Add(Dot(e[0], aa), Dot(a[0], ae)), three);
    const V b2 = hn::Div(hn::Add(Dot(e[0], ae), Dot(a[0], ee)), three), b3 = Dot(e[0], ee);
    const V volume = hn::Mul(hn::Mul(size.x, size.y), size.z);
    const V error = hn::Add(hn::Mul(hn::Set(tag, kDetError), volume), hn::Set(tag, kDetUnderflow));
    const V extent = hn::Max(hn::Max(size.x, size.y), size.z);
    const V least = hn::Min(hn::Min(b0, b1), hn::Min(b2, b3)),
            most = hn::Max(hn::Max(b0, b1), hn::Max(b2, b3));
    // Pairs of extreme size are rescaled first, elsewhere.
    const auto usual = hn::And(hn::Lt(extent, hn::Set(tag, kLarge)), hn::Ge(extent, hn::Set(tag, kSmall)));
    const auto apart = hn::And(usual, hn::Or(hn::Gt(least, error), hn::Lt(most, hn::Neg(error))));
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(tag, apart, bits);
    proven |= static_cast<unsigned>(bits[0]) << lane;
  }
  return proven;
}

unsigned NeverCoplanarVertexFace(const PairBatch& pairs) { return NeverCoplanar<false>(pairs); }
unsigned NeverCoplanarEdgeEdge(const PairBatch& pairs) { return NeverCoplanar<true>(pairs); }

}  // namespace foldproof::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace foldproof {

HWY_EXPORT(NeverCoplanarVertexFace);
HWY_EXPORT(NeverCoplanarEdgeEdge);

unsigned never_coplanar(const PairBatch& pairs, bool edge_edge) {
  return edge_edge ? HWY_DYNAMIC_DISPATCH(NeverCoplanarEdgeEdge)(pairs)
                   : HWY_DYNAMIC_DISPATCH(NeverCoplanarVertexFace)(pairs);
}

}  // namespace foldproof
#endif  // HWY_ONCE
