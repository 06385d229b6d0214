#include "ccd/nearest_points.h"

#include <algorithm>
#include <limits>

#include "ccd/bounds.h"
#include "ccd/conservative_advancement.h"

#undef HWY_TARGET_INCLUDE  // Highway compiles this file once per instruction set
#define HWY_TARGET_INCLUDE "ccd/nearest_points.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "ccd/lanes.h"

HWY_BEFORE_NAMESPACE();
namespace foldproof::HWY_NAMESPACE {

template <int N>
HWY_INLINE V Extent(const Corners<N>& c) {
  V extent = hn::Zero(D());
  for (int k = 0; k < N; ++k)
    extent = hn::Max(extent, hn::Max(hn::Max(hn::Abs(c.d[k].x), hn::Abs(c.d[k].y)), hn::Abs(c.d[k].z)));
  return extent;
}

// A computed projection on a unit vector above this is proven to exceed the distance (N1).
HWY_INLINE V MinProjection(V distance, V extent) {
  return hn::Add(hn::Mul(distance, Number(1 + 8 * kUnit)), hn::Mul(Number(kDotError), extent));
}

template <int N>
HWY_INLINE unsigned MaybeNear(const PairBatch& pairs, double distance) {
  unsigned near = 0;
  for (std::size_t lane = 0; lane < 8; lane += hn::Lanes(D())) {
    const Corners<N> c = Differences<N>(pairs.x[0], lane);
    const V extent = Extent(c);
    const V least = MinProjection(Number(distance), extent);
    const Vector center = N == 4 ? Plus(c.d[0], c.d[N - 1]) : Plus(Plus(c.d[0], c.d[1]), c.d[2]);
    // Along the line between the centers, as far as it is perpendicular to a side.
    const auto is_beyond = [&](const Vector& side) HWY_ATTR {
      const Vector n = Minus(center, Times(side, hn::Div(Dot(center, side), Dot(side, side))));
      const V square = Dot(n, n);
      return hn::And(hn::Ge(square, Number(kMinSquare)),
                     hn::Gt(SmallestProjection(n, c), hn::Mul(least, hn::Sqrt(square))));
    };
    const M beyond = hn::Or(is_beyond(Minus(c.d[1], c.d[0])), is_beyond(Minus(c.d[2], c.d[0])));
    const M far = hn::And(beyond, hn::Lt(extent, Number(kLarge)));
    near |= Bits(hn::Not(far)) << lane;
  }
  return near;
}

template <int N>
HWY_INLINE void MakeCorners(const PairBatch& pairs, MinkowskiBatch& patches) {
  for (std::size_t lane = 0; lane < 8; lane += hn::Lanes(D())) {
    const Corners<N> c = Differences<N>(pairs.x[0], lane);
    for (int k = 0; k < N; ++k) Store(c.d[k], patches.d[0][k], lane);
    hn::Store(Extent(c), D(), patches.extent + lane);
  }
}

// `distance`: per lane, in the units of its patch.
template <int N>
HWY_INLINE unsigned Nearest(const MinkowskiBatch& patches, const double (&distance)[8], NearestBatch& out) {
  const D d;
  unsigned near = 0;
  for (std::size_t lane = 0; lane < 8; lane += hn::Lanes(d)) {
    const Corners<N> c = Load<N>(patches.d[0], lane);
    const PatchClosest p = ClosestToOrigin(c);
    hn::Store(p.distance, d, out.distance + lane);
    Store(p.difference, out.difference, lane);
    Store(p.normal, out.normal, lane);
    hn::Store(p.side, d, out.side + lane);
    hn::Store(p.u, d, out.u + lane);
    hn::Store(p.v, d, out.v + lane);
    const V least = MinProjection(hn::Load(d, distance + lane), hn::Load(d, patches.extent + lane));
    near |= Bits(hn::Not(hn::Gt(SmallestProjection(p.normal, c), least))) << lane;
  }
  return near;
}

unsigned MaybeNear3(const PairBatch& pairs, double distance) { return MaybeNear<3>(pairs, distance); }
unsigned MaybeNear4(const PairBatch& pairs, double distance) { return MaybeNear<4>(pairs, distance); }
void MakeCorners3(const PairBatch& pairs, MinkowskiBatch& patches) { MakeCorners<3>(pairs, patches); }
void MakeCorners4(const PairBatch& pairs, MinkowskiBatch& patches) { MakeCorners<4>(pairs, patches); }
unsigned Nearest3(const MinkowskiBatch& patches, const double (&distance)[8], NearestBatch& out) {
  return Nearest<3>(patches, distance, out);
}
unsigned Nearest4(const MinkowskiBatch& patches, const double (&distance)[8], NearestBatch& out) {
  return Nearest<4>(patches, distance, out);
}

}  // namespace foldproof::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace foldproof::internal {

HWY_EXPORT(MaybeNear3);
HWY_EXPORT(MaybeNear4);
HWY_EXPORT(MakeCorners3);
HWY_EXPORT(MakeCorners4);
HWY_EXPORT(Nearest3);
HWY_EXPORT(Nearest4);

unsigned maybe_near(const PairBatch& pairs, int count, bool edge_edge, double distance) {
  const unsigned near = edge_edge ? HWY_DYNAMIC_DISPATCH(MaybeNear4)(pairs, distance)
                                  : HWY_DYNAMIC_DISPATCH(MaybeNear3)(pairs, distance);
  return near & ((1u << count) - 1);
}

unsigned nearest_points(const PairBatch& pairs, int count, bool edge_edge, double distance,
                        NearestBatch& out) {
  MinkowskiBatch patches;
  (edge_edge ? HWY_DYNAMIC_DISPATCH(MakeCorners4) : HWY_DYNAMIC_DISPATCH(MakeCorners3))(pairs, patches);
  alignas(64) double scale[8], scaled_distance[8];
  for (int lane = 0; lane < 8; ++lane) {
    scale[lane] = 1;
    scaled_distance[lane] = distance;
    if (lane >= count || (patches.extent[lane] < kLarge && patches.extent[lane] >= kSmall)) continue;
    PairBatch still = pairs;  // the same at both ends
    std::copy_n(&pairs.x[0][0][0][0], sizeof(pairs.x[0]) / sizeof(double), &still.x[1][0][0][0]);
    for (auto& corner : patches.d[1]) {
      for (auto& axis : corner) axis[lane] = 0;
    }
    scale[lane] = scale_differences(still, edge_edge, lane, 0, patches);
    scaled_distance[lane] = distance * scale[lane];
  }
  const unsigned near = edge_edge ? HWY_DYNAMIC_DISPATCH(Nearest4)(patches, scaled_distance, out)
                                  : HWY_DYNAMIC_DISPATCH(Nearest3)(patches, scaled_distance, out);
  for (int lane = 0; lane < count; ++lane) {
    out.distance[lane] /= scale[lane];
    for (auto& axis : out.difference) axis[lane] /= scale[lane];
  }
  return near & ((1u << count) - 1);
}

}  // namespace foldproof::internal
#endif  // HWY_ONCE
