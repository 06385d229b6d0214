#include "ccd/conservative_advancement.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "ccd/bounds.h"
#include "ccd/nearest_points.h"

#undef HWY_TARGET_INCLUDE  // Highway compiles this file once per instruction set
#define HWY_TARGET_INCLUDE "ccd/conservative_advancement.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "ccd/lanes.h"

HWY_BEFORE_NAMESPACE();
namespace foldproof::HWY_NAMESPACE {

HWY_INLINE M FromBits(unsigned bits) {
  const std::uint8_t bytes[8] = {static_cast<std::uint8_t>(bits)};
  return hn::LoadMaskBits(D(), bytes);
}

// Computes the patches of a batch. Bit k is set when pair k is proven separated at thickness 0.
template <int N>
HWY_INLINE unsigned MakePatches(const PairBatch& pairs, MinkowskiBatch& patches) {
  const D tag;
  unsigned proven = 0;
  for (std::size_t lane = 0; lane < 8; lane += hn::Lanes(tag)) {
    const Corners<N> ends[2] = {Differences<N>(pairs.x[0], lane), Differences<N>(pairs.x[1], lane)};
    Vector size{hn::Zero(tag), hn::Zero(tag), hn::Zero(tag)};
    for (int end = 0; end < 2; ++end) {
      for (int k = 0; k < N; ++k) {
        const Vector& d = ends[end].d[k];
        size = {hn::Max(size.x, hn::Abs(d.x)), hn::Max(size.y, hn::Abs(d.y)), hn::Max(size.z, hn::Abs(d.z))};
        Store(d, patches.d[end][k], lane);
      }
    }
    const V volume = hn::Mul(hn::Mul(size.x, size.y), size.z);
    const V error = hn::Add(hn::Mul(Number(kDetError), volume), Number(kDetUnderflow));
    const V extent = hn::Max(hn::Max(size.x, size.y), size.z);
    hn::Store(extent, tag, patches.extent + lane);
    hn::Store(error, tag, patches.volume_error + lane);
    // Pairs of extreme size are rescaled first.
    const M usual = hn::And(hn::Lt(extent, Number(kLarge)), hn::Ge(extent, Number(kSmall)));
    const M separated = hn::And(usual, Volume(ends[0], ends[1]).KeepsSign(error));
    proven |= Bits(separated) << lane;
  }
  return proven;
}

template <int N>
HWY_INLINE unsigned NeverCoplanar(const MinkowskiBatch& patches) {
  unsigned proven = 0;
  for (std::size_t lane = 0; lane < 8; lane += hn::Lanes(D())) {
    const Volume volume(Load<N>(patches.d[0], lane), Load<N>(patches.d[1], lane));
    proven |= Bits(volume.KeepsSign(hn::Load(D(), patches.volume_error + lane))) << lane;
  }
  return proven;
}

// A cubic on [0,1], from its Bernstein form.
struct Cubic {
  V c0, c1, c2, c3;

  explicit HWY_INLINE Cubic(const V (&b)[4]) {
    const V three = Number(3);
    c0 = b[0];
    c1 = hn::Mul(three, hn::Sub(b[1], b[0]));
    c2 = hn::Mul(three, hn::Add(hn::Sub(b[2], hn::Mul(Number(2), b[1])), b[0]));
    c3 = hn::Sub(hn::Sub(b[3], hn::Mul(three, hn::Sub(b[2], b[1]))), b[0]);
  }
  HWY_INLINE V Value(V t) const {
    return hn::Add(c0, hn::Mul(t, hn::Add(c1, hn::Mul(t, hn::Add(c2, hn::Mul(t, c3))))));
  }
  HWY_INLINE V Slope(V t) const {
    const V inner = hn::Add(hn::Mul(Number(2), c2), hn::Mul(hn::Mul(t, Number(3)), c3));
    return hn::Add(c1, hn::Mul(t, inner));
  }
  HWY_INLINE M SignAsAtStart(V value) const { return hn::Gt(hn::Mul(value, c0), hn::Zero(D())); }
};

struct Interval {
  V low, high;
  M found;
};

// The first interval between zeros of the derivative at whose ends the cubic's signs differ.
HWY_INLINE Interval FirstCrossing(const Cubic& f) {
  const V zero = hn::Zero(D()), one = Number(1);
  const V q = hn::Sub(hn::Mul(f.c2, f.c2), hn::Mul(hn::Mul(Number(3), f.c1), f.c3));
  const V w = hn::Neg(hn::Add(f.c2, hn::CopySign(hn::Sqrt(q), f.c2)));
  const V s0 = hn::Div(w, hn::Mul(Number(3), f.c3)), s1 = hn::Div(f.c1, w);
  const M swap = hn::Lt(s1, s0), turns = hn::Gt(q, zero);
  const V r0 = hn::IfThenElse(swap, s1, s0), r1 = hn::IfThenElse(swap, s0, s1);
  const M in0 = hn::And(turns, hn::And(hn::Gt(r0, zero), hn::Lt(r0, one)));
  const M in1 = hn::And(turns, hn::And(hn::Gt(r1, zero), hn::Lt(r1, one)));
  const V e0 = hn::IfThenElse(in0, r0, hn::IfThenElse(in1, r1, one));
  const V e1 = hn::IfThenElse(hn::And(in0, in1), r1, one);
  const M past0 = f.SignAsAtStart(f.Value(e0));
  const M past1 = hn::And(past0, f.SignAsAtStart(f.Value(e1)));
  const M past2 = hn::And(past1, f.SignAsAtStart(f.Value(one)));
  return {hn::IfThenElse(past1, e1, hn::IfThenElseZero(past0, e0)),
          hn::IfThenElse(past1, one, hn::IfThenElse(past0, e1, e0)), hn::Not(past2)};
}

// An estimate of the cubic's first zero, by safeguarded Newton iteration; 1 when it seems to have none. The
// caller proves the time before it, so an estimate suffices. Lanes that are not active get anything.
HWY_INLINE V EstimateFirstZero(const Cubic& f, M active, V accuracy) {
  auto [low, high, found] = FirstCrossing(f);
  V t = hn::Mul(hn::Add(low, high), Number(0.5));
  M open = hn::And(active, found);
  for (int i = 0; i < 40; ++i) {
    open = hn::And(open, hn::Gt(hn::Sub(high, low), Number(1e-16)));
    if (!Any(open)) break;
    const V value = f.Value(t);
    const M before = f.SignAsAtStart(value);
    low = hn::IfThenElse(before, t, low);
    high = hn::IfThenElse(before, high, t);
    const V newton = hn::Sub(t, hn::Div(value, f.Slope(t)));
    const M good = hn::And(hn::Gt(newton, low), hn::Lt(newton, high));
    const V next = hn::IfThenElse(good, newton, hn::Mul(hn::Add(low, high), Number(0.5)));
    const V step = hn::Sub(next, t);
    const M close = hn::Lt(hn::Mul(step, step), accuracy);
    t = hn::IfThenElse(open, next, t);
    open = hn::AndNot(close, open);
  }
  return hn::IfThenElse(found, t, Number(1));
}

// One iteration of conservative advancement: increases the times before which nothing touches (N4).
template <int N>
class Iteration {
 public:
  HWY_INLINE Iteration(ConservativeAdvancement::Lanes& lanes, std::size_t lane, unsigned busy)
      : lanes_(lanes),
        lane_(lane),
        open_(FromBits(busy)),
        a_(Load<N>(lanes.patch.d[0], lane)),
        e_(Load<N>(lanes.patch.d[1], lane)),
        t_(Row(lanes.t)),
        left_(hn::Sub(Number(1), t_)),
        tolerance_(Row(lanes.tolerance)),
        error_(Row(lanes.patch.volume_error)),
        now_(At(a_, e_, t_)) {
    const V thickness = Row(lanes.thickness);
    without_thickness_ = hn::Eq(thickness, hn::Zero(D()));
    min_projection_ = hn::Add(hn::Mul(thickness, Number(1 + 8 * kUnit)),
                              hn::Mul(Number(kDotError), Row(lanes.patch.extent)));
    // A plane is followed to slightly below `hit_`, so that the next iteration decides.
    target_ = hn::Add(thickness, hn::Mul(tolerance_, Number(0.25)));
    hit_ = hn::Add(thickness, hn::Mul(tolerance_, Number(0.5)));
  }

  // `use_volume`: where the thickness is 0, the sign of the volume is a proof as well.
  HWY_INLINE ConservativeAdvancement::Answers Iterate(bool use_volume) {
    const PatchClosest here = ClosestToOrigin(now_);
    const M hit = hn::And(open_, hn::Le(here.distance, hit_));
    open_ = hn::AndNot(hit, open_);
    MarkSeparated(hn::And(open_, hn::Ge(t_, Number(1))));
    FollowPlane(here.normal);
    if (use_volume && Any(open_)) FollowVolume();
    Advance(hn::And(open_, far_), plane_end_);
    M stuck = hn::FirstN(D(), 0);
    if (Any(open_)) stuck = ProveInterval(here.normal, use_volume);
    hn::Store(t_, D(), lanes_.t + lane_);
    separated_ = hn::Or(separated_, hn::AndNot(hit, hn::Gt(t_, Row(lanes_.latest))));
    return {Bits(separated_), Bits(hit), Bits(hn::AndNot(separated_, stuck))};
  }

 private:
  HWY_INLINE V Row(const double* row) const { return hn::Load(D(), row + lane_); }

  // These lanes are proven free until the end of the step.
  HWY_INLINE void MarkSeparated(M free) {
    separated_ = hn::Or(separated_, free);
    open_ = hn::AndNot(free, open_);
  }
  // These lanes are proven free until `t`, which is enough for this iteration.
  HWY_INLINE void Advance(M free, V t) {
    t_ = hn::IfThenElse(free, t, t_);
    open_ = hn::AndNot(free, open_);
  }

  HWY_INLINE M BeyondPlane(const Vector& normal, const Corners<N>& c) const {
    M beyond = hn::Gt(Dot(normal, c.d[0]), min_projection_);
    for (int k = 1; k < N; ++k) beyond = hn::And(beyond, hn::Gt(Dot(normal, c.d[k]), min_projection_));
    return beyond;
  }

  // N2. Advances to the latest time until which one plane with this normal separates. Sets plane_end_: t_
  // where none separates now.
  HWY_INLINE void FollowPlane(const Vector& normal) {
    V fraction = Number(1);
    M now = open_, end = open_;
    for (int k = 0; k < N; ++k) {
      const V g0 = Dot(normal, now_.d[k]), g1 = Dot(normal, e_.d[k]);
      const M beyond = hn::Gt(g1, min_projection_);
      now = hn::And(now, hn::Gt(g0, min_projection_));
      end = hn::And(end, beyond);
      const V until = hn::Div(hn::Sub(g0, target_), hn::Sub(g0, g1));
      fraction = hn::IfThenElse(hn::AndNot(beyond, hn::Lt(until, fraction)), until, fraction);
    }
    MarkSeparated(hn::And(now, end));
    plane_end_ = t_;
    far_ = hn::FirstN(D(), 0);
    now = hn::And(now, open_);
    if (!Any(now)) return;
    const V t = hn::Add(t_, hn::Mul(left_, fraction));
    now = hn::And(now, hn::And(hn::Gt(t, t_), hn::Lt(t, Number(1))));
    now = hn::And(now, BeyondPlane(normal, At(a_, e_, t)));
    plane_end_ = hn::IfThenElse(now, t, t_);
    far_ = hn::And(now, hn::Ge(hn::Sub(t, t_), hn::Mul(left_, Number(0.125))));
  }

  // N3. Advances to just before the volume is zero.
  HWY_INLINE void FollowVolume() {
    const Volume volume(now_, e_);
    const M able = hn::And(open_, without_thickness_);
    MarkSeparated(hn::And(able, volume.KeepsSign(error_)));
    if (!Any(hn::And(open_, able))) return;
    V speed2 = hn::Zero(D());
    for (int k = 0; k < N; ++k) {
      const Vector displacement = Minus(e_.d[k], a_.d[k]);
      speed2 = hn::Max(speed2, Dot(displacement, displacement));
    }
    // The time in which nothing moves farther than an eighth of the tolerance.
    const V backward = hn::Div(tolerance_, hn::Mul(Number(8), hn::Sqrt(speed2)));
    const V zero =
        EstimateFirstZero(Cubic(volume.b), open_, hn::Mul(hn::Div(backward, left_), Number(0x1p-6)));
    const V t = hn::Sub(hn::Add(t_, hn::Mul(left_, zero)), backward);
    const M on = hn::And(hn::And(open_, able), hn::And(hn::Gt(t, plane_end_), hn::Lt(t, Number(1))));
    if (Any(on)) Advance(hn::And(on, Volume(now_, At(a_, e_, t)).KeepsSign(error_)), t);
  }

  // Where one fixed plane advances little, the pair turns: proves a whole interval with proofs that turn
  // along. Its length doubles after a success and shrinks after a failure. Returns the lanes that cannot
  // advance.
  HWY_INLINE M ProveInterval(const Vector& normal, bool use_volume) {
    const V interval = Row(lanes_.interval);
    const V t = hn::IfThenElse(hn::Ge(interval, left_), Number(1), hn::Add(t_, interval));
    const M tried = hn::And(open_, hn::Gt(t, plane_end_));
    const M free = Any(tried) ? hn::And(tried, FreeUntil(t, normal, use_volume)) : tried;
    const V shorter = hn::Mul(hn::Sub(t, t_), Number(0.25));
    V next = hn::IfThenElse(free, hn::Mul(interval, Number(2)), hn::IfThenElse(tried, shorter, interval));
    const M unproven = hn::AndNot(free, open_), plane = hn::And(unproven, hn::Gt(plane_end_, t_));
    const M stuck = hn::AndNot(hn::Or(plane, hn::Gt(t, t_)), unproven);
    next = hn::IfThenElse(plane, hn::Max(next, Number(0x1p-50)), next);
    hn::Store(hn::IfThenElse(open_, next, interval), D(), lanes_.interval + lane_);
    Advance(free, t);
    MarkSeparated(hn::And(free, hn::Ge(t_, Number(1))));
    Advance(plane, plane_end_);
    return stuck;
  }

  // N3 and N5 on [t_, end].
  HWY_INLINE M FreeUntil(V end, const Vector& normal, bool use_volume) const {
    const Corners<N> then = At(a_, e_, end);
    M free = hn::And(BeyondPlane(normal, now_), open_);
    if (Any(free)) {
      const Vector other = ClosestToOrigin(then).normal;
      free = hn::And(free, BeyondPlane(other, then));
      for (int k = 0; k < N; ++k) {
        const V middle = hn::Mul(hn::Add(Dot(normal, then.d[k]), Dot(other, now_.d[k])), Number(0.5));
        free = hn::And(free, hn::Gt(middle, min_projection_));
      }
    }
    if (!use_volume) return free;
    return hn::Or(free, hn::And(without_thickness_, Volume(now_, then).KeepsSign(error_)));
  }

  ConservativeAdvancement::Lanes& lanes_;
  const std::size_t lane_;
  M open_;  // lanes that have not advanced in this iteration
  M separated_ = hn::FirstN(D(), 0), without_thickness_, far_;
  const Corners<N> a_, e_;
  V t_;
  const V left_, tolerance_, error_;
  const Corners<N> now_;
  V min_projection_;  // a computed projection above this is proven to exceed the thickness
  V target_, hit_, plane_end_;
};

template <int N>
HWY_INLINE ConservativeAdvancement::Answers Iterate(ConservativeAdvancement::Lanes& lanes, unsigned busy,
                                                    bool use_volume) {
  ConservativeAdvancement::Answers all{0, 0, 0};
  constexpr unsigned kChunk = (1u << hn::MaxLanes(D())) - 1;
  for (std::size_t lane = 0; lane < 8; lane += hn::Lanes(D())) {
    const unsigned here = busy >> lane & kChunk;
    if (here == 0) continue;
    const ConservativeAdvancement::Answers some = Iteration<N>(lanes, lane, here).Iterate(use_volume);
    all.separated |= some.separated << lane;
    all.hit |= some.hit << lane;
    all.stuck |= some.stuck << lane;
  }
  return all;
}

unsigned MakePatches3(const PairBatch& pairs, MinkowskiBatch& patches) {
  return MakePatches<3>(pairs, patches);
}
unsigned MakePatches4(const PairBatch& pairs, MinkowskiBatch& patches) {
  return MakePatches<4>(pairs, patches);
}
unsigned NeverCoplanar3(const MinkowskiBatch& patches) { return NeverCoplanar<3>(patches); }
unsigned NeverCoplanar4(const MinkowskiBatch& patches) { return NeverCoplanar<4>(patches); }
ConservativeAdvancement::Answers Iterate3(ConservativeAdvancement::Lanes& lanes, unsigned busy,
                                          bool use_volume) {
  return Iterate<3>(lanes, busy, use_volume);
}
ConservativeAdvancement::Answers Iterate4(ConservativeAdvancement::Lanes& lanes, unsigned busy,
                                          bool use_volume) {
  return Iterate<4>(lanes, busy, use_volume);
}

}  // namespace foldproof::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace foldproof::internal {

HWY_EXPORT(MakePatches3);
HWY_EXPORT(MakePatches4);
HWY_EXPORT(NeverCoplanar3);
HWY_EXPORT(NeverCoplanar4);
HWY_EXPORT(Iterate3);
HWY_EXPORT(Iterate4);

namespace {

void copy_lane(const MinkowskiBatch& from, int from_lane, bool edge_edge, MinkowskiBatch& to, int lane) {
  for (int row = 0; row < (edge_edge ? 12 : 9); ++row) {
    for (int end = 0; end < 2; ++end)
      to.d[end][row / 3][row % 3][lane] = from.d[end][row / 3][row % 3][from_lane];
  }
  to.extent[lane] = from.extent[from_lane];
  to.volume_error[lane] = from.volume_error[from_lane];
}

}  // namespace

unsigned make_patches(const PairBatch& pairs, bool edge_edge, MinkowskiBatch& patches) {
  return edge_edge ? HWY_DYNAMIC_DISPATCH(MakePatches4)(pairs, patches)
                   : HWY_DYNAMIC_DISPATCH(MakePatches3)(pairs, patches);
}

double scale_differences(const PairBatch& pairs, bool edge_edge, int lane, double thickness,
                         MinkowskiBatch& patches) {
  double scale = 1;
  if (!std::isfinite(patches.extent[lane])) {
    // The differences overflow; those of a quarter of the points do not.
    scale = 0.25;
    PairBatch quarter = pairs;
    for (auto& end : quarter.x) {
      for (auto& point : end) {
        for (auto& axis : point) axis[lane] *= scale;
      }
    }
    MinkowskiBatch smaller;
    make_patches(quarter, edge_edge, smaller);
    copy_lane(smaller, lane, edge_edge, patches, lane);
  }
  const double extent = std::max(patches.extent[lane], thickness * scale);
  if (extent == 0) return 1;
  // Clamped so that the scale itself is a finite normal number.
  const double factor = std::ldexp(1.0, -std::clamp(std::ilogb(extent), -1000, 1000));
  double size[3] = {};
  for (auto& end : patches.d) {
    for (int k = 0; k < (edge_edge ? 4 : 3); ++k) {
      for (int axis = 0; axis < 3; ++axis) {
        double& d = end[k][axis][lane];
        d *= factor;
        size[axis] = std::max(size[axis], std::abs(d));
      }
    }
  }
  patches.extent[lane] = std::max({size[0], size[1], size[2]});
  patches.volume_error[lane] = kDetError * (size[0] * size[1] * size[2]) + kDetUnderflow;
  return scale * factor;
}

unsigned ConservativeAdvancement::load(const PairBatch& pairs, int count) {
  const unsigned all = (1u << count) - 1;
  unsigned separated = make_patches(pairs, edge_edge_, loaded_);
  bool rescaled = false;
  for (int lane = 0; lane < count; ++lane) {
    scale_[lane] = 1;
    const double size = std::max(loaded_.extent[lane], settings_.thickness);
    if (size < kLarge && !(size < kSmall)) continue;
    scale_[lane] = scale_differences(pairs, edge_edge_, lane, settings_.thickness, loaded_);
    rescaled = true;
  }
  for (int lane = 0; lane < count; ++lane) thickness_[lane] = settings_.thickness * scale_[lane];
  if (pairs_.min_gap_share > 0) add_gaps(pairs, count);
  if (settings_.thickness > 0) return all;
  if (rescaled) {
    separated = edge_edge_ ? HWY_DYNAMIC_DISPATCH(NeverCoplanar4)(loaded_)
                           : HWY_DYNAMIC_DISPATCH(NeverCoplanar3)(loaded_);
  }
  for (int lane = 0; lane < count; ++lane) {
    if (thickness_[lane] > 0) separated &= ~(1u << lane);
  }
  return all & ~separated;
}

double ConservativeAdvancement::tolerance(int k) const {
  const double thickness = settings_.thickness * scale_[k];
  const double tolerance = std::max(std::max(settings_.tolerance, kMinTolerance) * scale_[k],
                                    kResolution * std::max(loaded_.extent[k], thickness));
  if (pairs_.relative_tolerance == 0) return tolerance;
  double extent = 0;
  for (int corner = 0; corner < (edge_edge_ ? 4 : 3); ++corner) {
    for (int axis = 0; axis < 3; ++axis) extent = std::max(extent, std::abs(loaded_.d[0][corner][axis][k]));
  }
  return std::max(tolerance, pairs_.relative_tolerance * extent);
}

void ConservativeAdvancement::add_gaps(const PairBatch& pairs, int count) {
  NearestBatch start;
  nearest_points(pairs, count, edge_edge_, std::numeric_limits<double>::infinity(), start);
  for (int k = 0; k < count; ++k) {
    const double gap =
        std::min(pairs_.min_gap_share * (start.distance[k] - settings_.thickness), pairs_.max_gap);
    const double scaled = gap * scale_[k];
    if (scaled > 2 * tolerance(k)) thickness_[k] += scaled - tolerance(k);
  }
}

int ConservativeAdvancement::start(int k, double latest) {
  const int lane = __builtin_ctz(~busy_);
  busy_ |= 1u << lane;
  copy_lane(loaded_, k, edge_edge_, lanes_.patch, lane);
  lanes_.thickness[lane] = thickness_[k];
  lanes_.tolerance[lane] = tolerance(k);
  lanes_.latest[lane] = latest;
  lanes_.t[lane] = 0;
  lanes_.interval[lane] = 1;
  iterations_[lane] = 0;
  return lane;
}

unsigned ConservativeAdvancement::iterate() {
  const bool use_volume = settings_.thickness == 0;
  const Answers answers = edge_edge_ ? HWY_DYNAMIC_DISPATCH(Iterate4)(lanes_, busy_, use_volume)
                                     : HWY_DYNAMIC_DISPATCH(Iterate3)(lanes_, busy_, use_volume);
  unsigned done = 0;
  for (unsigned left = busy_; left != 0; left &= left - 1) {
    const int lane = __builtin_ctz(left);
    const unsigned bit = 1u << lane;
    if (answers.separated & bit) {
      results_[lane] = {Answer::Separated, 1};
    } else if (answers.hit & bit) {
      results_[lane] = {Answer::Hit, lanes_.t[lane]};
    } else if ((answers.stuck & bit) != 0 || ++iterations_[lane] >= settings_.max_iterations) {
      results_[lane] = {Answer::Undecided, lanes_.t[lane]};
    } else {
      continue;
    }
    done |= bit;
  }
  busy_ &= ~done;
  return done;
}

}  // namespace foldproof::internal
#endif  // HWY_ONCE
