#include "check/separated_triangles.h"

#include <algorithm>
#include <cstdint>
#include <limits>

#undef HWY_TARGET_INCLUDE  // Highway compiles this file once per instruction set
#define HWY_TARGET_INCLUDE "check/separated_triangles.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "ccd/lanes.h"

HWY_BEFORE_NAMESPACE();
namespace foldproof::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

struct PairCorner {
  Vector x;
  M is_common;  // a vertex of the other triangle
};

HWY_INLINE PairCorner LoadCorner(const TrianglePairs::Corner& corner, const TrianglePairs::Corner (&other)[3],
                                 std::size_t lane) {
  const V number = hn::Load(D(), corner.number + lane);
  const auto same = [&](int k) HWY_ATTR { return hn::Eq(number, hn::Load(D(), other[k].number + lane)); };
  return {Load(corner.x, lane), hn::Or(hn::Or(same(0), same(1)), same(2))};
}

HWY_INLINE Vector Abs(const Vector& a) { return {hn::Abs(a.x), hn::Abs(a.y), hn::Abs(a.z)}; }
HWY_INLINE Vector Max(const Vector& a, const Vector& b) {
  return {hn::Max(a.x, b.x), hn::Max(a.y, b.y), hn::Max(a.z, b.z)};
}

// Whether the corners of t that are not common lie on one side of the plane of s, by the filter of E1.
HWY_INLINE M BeyondPlane(const PairCorner (&s)[3], const PairCorner (&t)[3]) {
  const Vector b = Minus(s[1].x, s[0].x), c = Minus(s[2].x, s[0].x), normal = Cross(b, c);
  const Vector sides = Max(Abs(b), Abs(c));
  const V rounding = Number(kVolumeError);
  M above = hn::Eq(rounding, rounding), below = above;
  for (const PairCorner& corner : t) {
    const Vector a = Minus(corner.x, s[0].x), size = Max(Abs(a), sides);
    const V det = Dot(a, normal), error = hn::Mul(rounding, hn::Mul(hn::Mul(size.x, size.y), size.z));
    const M applies = hn::And(hn::Gt(hn::Min(hn::Min(size.x, size.y), size.z), Number(kSmallestFiltered)),
                              hn::Lt(hn::Max(hn::Max(size.x, size.y), size.z), Number(kLargestFiltered)));
    above = hn::And(above, hn::Or(corner.is_common, hn::And(applies, hn::Gt(det, error))));
    below = hn::And(below, hn::Or(corner.is_common, hn::And(applies, hn::Lt(det, hn::Neg(error)))));
  }
  const M all_common = hn::And(hn::And(t[0].is_common, t[1].is_common), t[2].is_common);
  return hn::AndNot(all_common, hn::Or(above, below));
}

HWY_INLINE M HasTwoCommon(const PairCorner (&s)[3]) {
  return hn::Or(hn::Or(hn::And(s[0].is_common, s[1].is_common), hn::And(s[1].is_common, s[2].is_common)),
                hn::And(s[2].is_common, s[0].is_common));
}

// Whether along one of the axes all other corners of s come before those of t, and a common one between them.
HWY_INLINE M BeforeAlongAxis(const PairCorner (&s)[3], const PairCorner (&t)[3]) {
  const V infinity = Number(std::numeric_limits<double>::infinity());
  const auto before_along = [&](V Vector::*axis) HWY_ATTR {
    V end_s = hn::Neg(infinity), begin_t = infinity, first_common = infinity, last_common = end_s;
    for (int k = 0; k < 3; ++k) {
      const V of_s = s[k].x.*axis, of_t = t[k].x.*axis;
      end_s = hn::Max(end_s, hn::IfThenElse(s[k].is_common, end_s, of_s));
      first_common = hn::IfThenElse(s[k].is_common, of_s, first_common);
      last_common = hn::IfThenElse(s[k].is_common, of_s, last_common);
      begin_t = hn::Min(begin_t, hn::IfThenElse(t[k].is_common, begin_t, of_t));
    }
    return hn::And(hn::Lt(end_s, begin_t),
                   hn::And(hn::Lt(end_s, first_common), hn::Lt(last_common, begin_t)));
  };
  const M before =
      hn::Or(hn::Or(before_along(&Vector::x), before_along(&Vector::y)), before_along(&Vector::z));
  return hn::AndNot(hn::Or(HasTwoCommon(s), HasTwoCommon(t)), before);
}

unsigned SeparatedTriangles(const TrianglePairs& pairs) {
  unsigned separated = 0;
  for (std::size_t lane = 0; lane < 8; lane += hn::Lanes(D())) {
    PairCorner s[3], t[3];
    for (int k = 0; k < 3; ++k) {
      s[k] = LoadCorner(pairs.corners[0][k], pairs.corners[1], lane);
      t[k] = LoadCorner(pairs.corners[1][k], pairs.corners[0], lane);
    }
    const M by_plane = hn::Or(BeyondPlane(s, t), BeyondPlane(t, s));
    const M by_axis = hn::Or(BeforeAlongAxis(s, t), BeforeAlongAxis(t, s));
    separated |= Bits(hn::Or(by_plane, by_axis)) << lane;
  }
  return separated;
}

}  // namespace foldproof::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace foldproof::internal {

HWY_EXPORT(SeparatedTriangles);

unsigned separated_triangles(const TrianglePairs& pairs) {
  return HWY_DYNAMIC_DISPATCH(SeparatedTriangles)(pairs);
}

}  // namespace foldproof::internal
#endif
