#include "check/triangles_apart.h"

#include <cstdint>
#include <limits>

#undef HWY_TARGET_INCLUDE  // Highway compiles this file once per instruction set
#define HWY_TARGET_INCLUDE "check/triangles_apart.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace foldproof::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<double, 8>;
using V = hn::Vec<D>;
using M = hn::Mask<D>;

struct PairCorner {
  V x[3];
  M is_common;  // a vertex of the other triangle
};

HWY_INLINE void LoadCorner(const TrianglePairs::Corner& from, const TrianglePairs::Corner (&other)[3],
                           std::size_t lane, PairCorner& to) {
  const D d;
  for (int axis = 0; axis < 3; ++axis) to.x[axis] = hn::Load(d, from.x[axis] + lane);
  const V number = hn::Load(d, from.number + lane);
  const auto same = [&](int k) HWY_ATTR { return hn::Eq(number, hn::Load(d, other[k].number + lane)); };
  to.is_common = hn::Or(hn::Or(same(0), same(1)), same(2));
}

// Whether the corners of t that are not common lie on one side of the plane of s, by the filter of E1.
HWY_INLINE M BeyondPlane(const PairCorner (&s)[3], const PairCorner (&t)[3]) {
  const D d;
  V b[3], c[3], size[3];
  for (int axis = 0; axis < 3; ++axis) {
    b[axis] = hn::Sub(s[1].x[axis], s[0].x[axis]);
    c[axis] = hn::Sub(s[2].x[axis], s[0].x[axis]);
    size[axis] = hn::Max(hn::Abs(b[axis]), hn::Abs(c[axis]));
  }
  const V x = hn::Sub(hn::Mul(b[1], c[2]), hn::Mul(b[2], c[1]));
  const V y = hn::Sub(hn::Mul(b[0], c[2]), hn::Mul(b[2], c[0]));
  const V z = hn::Sub(hn::Mul(b[0], c[1]), hn::Mul(b[1], c[0]));
  const V smallest = hn::Set(d, 1e-97), largest = hn::Set(d, 1e97), rounding = hn::Set(d, 64 * 0x1p-53);
  M above = hn::Eq(rounding, rounding), below = above;
  for (const PairCorner& corner : t) {
    V a[3], with_a[3];
    for (int axis = 0; axis < 3; ++axis) {
      a[axis] = hn::Sub(corner.x[axis], s[0].x[axis]);
      with_a[axis] = hn::Max(size[axis], hn::Abs(a[axis]));
    }
    const V det = hn::Add(hn::Sub(hn::Mul(a[0], x), hn::Mul(a[1], y)), hn::Mul(a[2], z));
    const V error = hn::Mul(rounding, hn::Mul(hn::Mul(with_a[0], with_a[1]), with_a[2]));
    const M applies = hn::And(hn::Gt(hn::Min(hn::Min(with_a[0], with_a[1]), with_a[2]), smallest),
                              hn::Lt(hn::Max(hn::Max(with_a[0], with_a[1]), with_a[2]), largest));
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

// Whether along an axis all other corners of s come before those of t, and a single common one between them.
HWY_INLINE M BeforeAlongAxis(const PairCorner (&s)[3], const PairCorner (&t)[3]) {
  const D d;
  const V infinity = hn::Set(d, std::numeric_limits<double>::infinity());
  M before = hn::Lt(infinity, infinity);
  for (int axis = 0; axis < 3; ++axis) {
    V end_s = hn::Neg(infinity), begin_t = infinity, first_common = infinity, last_common = end_s;
    for (int k = 0; k < 3; ++k) {
      const V of_s = s[k].x[axis], of_t = t[k].x[axis];
      end_s = hn::Max(end_s, hn::IfThenElse(s[k].is_common, end_s, of_s));
      first_common = hn::IfThenElse(s[k].is_common, of_s, first_common);
      last_common = hn::IfThenElse(s[k].is_common, of_s, last_common);
      begin_t = hn::Min(begin_t, hn::IfThenElse(t[k].is_common, begin_t, of_t));
    }
    before = hn::Or(before, hn::And(hn::Lt(end_s, begin_t),
                                    hn::And(hn::Lt(end_s, first_common), hn::Lt(last_common, begin_t))));
  }
  return hn::AndNot(hn::Or(HasTwoCommon(s), HasTwoCommon(t)), before);
}

unsigned TrianglesApart(const TrianglePairs& pairs) {
  unsigned apart = 0;
  for (std::size_t lane = 0; lane < 8; lane += hn::Lanes(D())) {
    PairCorner s[3], t[3];
    for (int k = 0; k < 3; ++k) {
      LoadCorner(pairs.corners[0][k], pairs.corners[1], lane, s[k]);
      LoadCorner(pairs.corners[1][k], pairs.corners[0], lane, t[k]);
    }
    const M by_plane = hn::Or(BeyondPlane(s, t), BeyondPlane(t, s));
    const M by_axis = hn::Or(BeforeAlongAxis(s, t), BeforeAlongAxis(t, s));
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(D(), hn::Or(by_plane, by_axis), bits);
    apart |= unsigned{bits[0]} << lane;
  }
  return apart;
}

}  // namespace foldproof::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace foldproof::internal {

HWY_EXPORT(TrianglesApart);

unsigned triangles_apart(const TrianglePairs& pairs) { return HWY_DYNAMIC_DISPATCH(TrianglesApart)(pairs); }

}  // namespace foldproof::internal
#endif
