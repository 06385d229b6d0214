/// SIMD geometry, one pair per lane. Every operation is one of IEEE arithmetic in a fixed order, so all
/// instruction sets give the same bits. Highway includes this file once per instruction set.
#include <limits>

#include "ccd/bounds.h"
#include "ccd/nearest_points.h"

#if defined(FOLDPROOF_CCD_LANES_H) == defined(HWY_TARGET_TOGGLE)
#ifdef FOLDPROOF_CCD_LANES_H
#undef FOLDPROOF_CCD_LANES_H
#else
#define FOLDPROOF_CCD_LANES_H
#endif

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace foldproof::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<double, 8>;
using V = hn::Vec<D>;
using M = hn::Mask<D>;

HWY_INLINE V Number(double x) { return hn::Set(D(), x); }
HWY_INLINE bool Any(M m) { return !hn::AllFalse(D(), m); }

struct Vector {
  V x, y, z;
};

HWY_INLINE Vector Minus(const Vector& a, const Vector& b) {
  return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}
HWY_INLINE Vector Plus(const Vector& a, const Vector& b) {
  return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z)};
}
HWY_INLINE Vector Times(const Vector& a, V s) { return {hn::Mul(a.x, s), hn::Mul(a.y, s), hn::Mul(a.z, s)}; }
HWY_INLINE Vector Over(const Vector& a, V s) { return {hn::Div(a.x, s), hn::Div(a.y, s), hn::Div(a.z, s)}; }
HWY_INLINE V Dot(const Vector& a, const Vector& b) {
  return hn::Add(hn::Add(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y)), hn::Mul(a.z, b.z));
}
HWY_INLINE Vector Cross(const Vector& a, const Vector& b) {
  return {hn::Sub(hn::Mul(a.y, b.z), hn::Mul(a.z, b.y)), hn::Sub(hn::Mul(a.z, b.x), hn::Mul(a.x, b.z)),
          hn::Sub(hn::Mul(a.x, b.y), hn::Mul(a.y, b.x))};
}
HWY_INLINE Vector Choose(M m, const Vector& yes, const Vector& no) {
  return {hn::IfThenElse(m, yes.x, no.x), hn::IfThenElse(m, yes.y, no.y), hn::IfThenElse(m, yes.z, no.z)};
}

/// Corners of the Minkowski difference of two features (MinkowskiBatch); N is 3 for vertex-face, 4 for
/// edge-edge.
template <int N>
struct Corners {
  Vector d[N];
};

template <int N>
HWY_INLINE Corners<N> At(const Corners<N>& a, const Corners<N>& e, V t) {
  const V s = hn::Sub(Number(1), t);
  Corners<N> c;
  for (int k = 0; k < N; ++k) c.d[k] = Plus(Times(a.d[k], s), Times(e.d[k], t));
  return c;
}

HWY_INLINE Vector Load(const double (&x)[3][8], std::size_t lane) {
  const D d;
  return {hn::Load(d, x[0] + lane), hn::Load(d, x[1] + lane), hn::Load(d, x[2] + lane)};
}
HWY_INLINE void Store(const Vector& v, double (&x)[3][8], std::size_t lane) {
  const D d;
  hn::Store(v.x, d, x[0] + lane);
  hn::Store(v.y, d, x[1] + lane);
  hn::Store(v.z, d, x[2] + lane);
}
template <int N>
HWY_INLINE Corners<N> Load(const double (&x)[4][3][8], std::size_t lane) {
  Corners<N> c;
  for (int k = 0; k < N; ++k) c.d[k] = Load(x[k], lane);
  return c;
}
HWY_INLINE unsigned Bits(M m) {
  std::uint8_t bits[8] = {};
  hn::StoreMaskBits(D(), m, bits);
  return bits[0];
}

template <int N>
HWY_INLINE Corners<N> Differences(const double (&x)[4][3][8], std::size_t lane) {
  const Vector p0 = Load(x[0], lane), p1 = Load(x[1], lane), p2 = Load(x[2], lane), p3 = Load(x[3], lane);
  if constexpr (N == 4) {
    return {{Minus(p0, p2), Minus(p1, p2), Minus(p0, p3), Minus(p1, p3)}};
  } else {
    return {{Minus(p0, p1), Minus(p0, p2), Minus(p0, p3)}};
  }
}

/// The signed volume that the origin spans with the first three corners while they move from a to e: the
/// Bernstein coefficients of a cubic over that interval.
struct Volume {
  V b[4];

  template <int N>
  HWY_INLINE Volume(const Corners<N>& a, const Corners<N>& e) {
    const Vector aa = Cross(a.d[1], a.d[2]), ee = Cross(e.d[1], e.d[2]);
    const Vector ae = Plus(Cross(a.d[1], e.d[2]), Cross(e.d[1], a.d[2]));
    const V three = Number(3);
    b[0] = Dot(a.d[0], aa);
    b[1] = hn::Div(hn::Add(Dot(e.d[0], aa), Dot(a.d[0], ae)), three);
    b[2] = hn::Div(hn::Add(Dot(e.d[0], ae), Dot(a.d[0], ee)), three);
    b[3] = Dot(e.d[0], ee);
  }

  /// N3. True where the sign never changes: the origin is never coplanar with the corners, so the features
  /// cannot touch.
  HWY_INLINE M KeepsSign(V error) const {
    const V min = hn::Min(hn::Min(b[0], b[1]), hn::Min(b[2], b[3])),
            max = hn::Max(hn::Max(b[0], b[1]), hn::Max(b[2], b[3]));
    return hn::Or(hn::Gt(min, error), hn::Lt(max, hn::Neg(error)));
  }
};

struct PatchClosest {
  V distance;         ///< Length of `difference`.
  Vector difference;  ///< The point of the patch nearest to the origin, up to rounding.
  Vector normal;      ///< Unit direction along which the patch is farthest from the origin (N6).
  V side, u, v;       ///< Where `difference` is: see NearestBatch.
};

/// The nearest point of the border so far, with its side.
struct BorderPoint {
  Vector point, from, side;
  V distance2, number, fraction;
  M at_corner;

  HWY_INLINE void Consider(const Vector& p, const Vector& q, double side_number) {
    const V zero = hn::Zero(D()), one = Number(1);
    const Vector along = Minus(q, p);
    const V length2 = Dot(along, along);
    V s = hn::Div(hn::Neg(Dot(p, along)), length2);
    s = hn::IfThenElse(hn::Lt(s, zero), zero, hn::IfThenElse(hn::Lt(one, s), one, s));
    s = hn::IfThenElseZero(hn::Gt(length2, zero), s);
    const Vector candidate = Choose(hn::Lt(s, one), Plus(p, Times(along, s)), q);
    const V candidate2 = Dot(candidate, candidate);
    const M nearer = hn::Lt(candidate2, distance2);
    point = Choose(nearer, candidate, point);
    from = Choose(nearer, p, from);
    side = Choose(nearer, along, side);
    distance2 = hn::IfThenElse(nearer, candidate2, distance2);
    number = hn::IfThenElse(nearer, Number(side_number), number);
    fraction = hn::IfThenElse(nearer, s, fraction);
    const M ends = hn::Or(hn::Eq(s, zero), hn::Eq(s, one));
    at_corner = hn::Or(hn::And(nearer, ends), hn::AndNot(nearer, at_corner));
  }

  /// Inside a side, cancellation would leave `point` with a random direction; computed from the side itself,
  /// the direction is perpendicular to it to the last digits.
  HWY_INLINE Vector Direction() const {
    const V zero = hn::Zero(D());
    const V length2 = Dot(side, side);
    const Vector unit = Choose(hn::Gt(length2, zero), Over(side, hn::Sqrt(length2)), side);
    const Vector along = Choose(at_corner, point, Cross(unit, Cross(from, unit)));
    const V square = Dot(along, along);
    return Choose(hn::Ge(square, Number(kMinSquare)), Over(along, hn::Sqrt(square)), {Number(1), zero, zero});
  }
};

template <int N>
HWY_INLINE BorderPoint NearestOnBorder(const Corners<N>& c) {
  const V zero = hn::Zero(D());
  const Vector none{zero, zero, zero};
  BorderPoint best{
      none, none, none, Number(std::numeric_limits<double>::infinity()), zero, zero, hn::FirstN(D(), 0)};
  best.Consider(c.d[0], c.d[1], 0);
  best.Consider(c.d[0], c.d[2], 1);
  best.Consider(c.d[1], c.d[N == 4 ? 3 : 2], 2);
  if constexpr (N == 4) best.Consider(c.d[2], c.d[3], 3);
  return best;
}

template <int N>
HWY_INLINE V SmallestProjection(const Vector& n, const Corners<N>& c) {
  V min = Dot(n, c.d[0]);
  for (int k = 1; k < N; ++k) min = hn::Min(min, Dot(n, c.d[k]));
  return min;
}

template <int N>
HWY_INLINE PatchClosest ClosestToOrigin(const Corners<N>& c) {
  const V zero = hn::Zero(D());
  const Vector e1 = Minus(c.d[1], c.d[0]), e2 = Minus(c.d[2], c.d[0]);
  const Vector across = Cross(e1, e2);
  const V across2 = Dot(across, across);
  const V beta = Dot(Cross(e2, c.d[0]), across), gamma = Dot(Cross(c.d[0], e1), across);
  const M within =
      N == 4 ? hn::And(hn::Le(beta, across2), hn::Le(gamma, across2)) : hn::Le(hn::Add(beta, gamma), across2);
  const M inside = hn::And(hn::And(hn::Ge(beta, zero), hn::Ge(gamma, zero)),
                           hn::And(within, hn::Ge(across2, Number(kMinSquare))));
  // On slivers the barycentric coordinates are noise, so the border is tested as well.
  const M broad = hn::Gt(across2, hn::Mul(hn::Mul(Number(1e-12), Dot(e1, e1)), Dot(e2, e2)));

  PatchClosest best;
  best.side = Number(kInside);
  best.u = hn::Div(beta, across2);
  best.v = hn::Div(gamma, across2);
  best.difference = Plus(Plus(c.d[0], Times(e1, best.u)), Times(e2, best.v));
  best.distance = hn::Sqrt(Dot(best.difference, best.difference));
  const V sign = hn::IfThenElse(hn::Lt(Dot(across, c.d[0]), zero), Number(-1), Number(1));
  best.normal = Times(across, hn::Div(sign, hn::Sqrt(across2)));
  const M done = hn::And(inside, broad);
  if (hn::AllTrue(D(), done)) return best;

  const BorderPoint border = NearestOnBorder(c);
  const V border_distance = hn::Sqrt(border.distance2);
  const Vector border_normal = border.Direction();
  const M on_border = hn::AndNot(done, hn::Or(hn::Not(inside), hn::Le(border_distance, best.distance)));
  const M straighter =
      hn::AndNot(done, hn::Gt(SmallestProjection(border_normal, c), SmallestProjection(best.normal, c)));
  best.normal = Choose(hn::Or(on_border, straighter), border_normal, best.normal);
  best.difference = Choose(on_border, border.point, best.difference);
  best.distance = hn::IfThenElse(on_border, border_distance, best.distance);
  best.side = hn::IfThenElse(on_border, border.number, best.side);
  best.u = hn::IfThenElse(on_border, border.fraction, best.u);
  return best;
}

}  // namespace foldproof::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
