#include "solver/near_boxes.h"

#undef HWY_TARGET_INCLUDE  // Highway compiles this file once per instruction set
#define HWY_TARGET_INCLUDE "solver/near_boxes.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace foldproof::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<double, 4>;
constexpr D d;

// Four numbers, in as many vectors as the instruction set needs. Minima, maxima and negation are exact,
// whatever the sign of zero (tests/arithmetic, Order).
template <class Visit>
HWY_INLINE void EachPart(Visit visit) {
  for (std::size_t lane = 0; lane < 4; lane += hn::Lanes(d)) visit(lane);
}

template <int Ends, std::size_t N>
HWY_ATTR void FitBoxes(const PointAtEnds<Ends>* points, std::span<const std::array<Index, N>> corners,
                       BoxAtEnds<Ends>* boxes) {
  for (std::size_t k = 0; k < corners.size(); ++k) {
    for (int end = 0; end < Ends; ++end) {
      EachPart([&](std::size_t lane) HWY_ATTR {
        auto low = hn::Load(d, points[corners[k][0]].x[end] + lane), high = low;
        for (std::size_t i = 1; i < N; ++i) {
          const auto p = hn::Load(d, points[corners[k][i]].x[end] + lane);
          low = hn::Min(low, p);
          high = hn::Max(high, p);
        }
        hn::Store(low, d, boxes[k].x[end][0] + lane);
        hn::Store(hn::Neg(high), d, boxes[k].x[end][1] + lane);
      });
    }
  }
}

template <int Ends>
HWY_ATTR void FitMoving(const PointAtEnds<Ends>* points, const PointAtEnds<Ends>* last_points,
                        std::span<const Index> indices, BoxAtEnds<Ends>& box, double (&displacement)[2][4]) {
  EachPart([&](std::size_t lane) HWY_ATTR {
    auto min = hn::Set(d, std::numeric_limits<double>::infinity()), max = hn::Neg(min);
    for (int end = 0; end < Ends; ++end) {
      auto low = hn::Load(d, points[indices[0]].x[end] + lane), high = low;
      for (const Index i : indices) {
        const auto p = hn::Load(d, points[i].x[end] + lane);
        const auto moved = hn::Sub(p, hn::Load(d, last_points[i].x[end] + lane));
        low = hn::Min(low, p);
        high = hn::Max(high, p);
        min = hn::Min(min, moved);
        max = hn::Max(max, moved);
      }
      hn::Store(low, d, box.x[end][0] + lane);
      hn::Store(hn::Neg(high), d, box.x[end][1] + lane);
    }
    hn::StoreU(min, d, displacement[0] + lane);
    hn::StoreU(hn::Neg(max), d, displacement[1] + lane);
  });
}

// Whether the separation of two boxes is <= distance. The fourth lanes are 0, so never above the distance.
template <int Ends>
HWY_INLINE bool AreNear(const BoxAtEnds<Ends>& a, const BoxAtEnds<Ends>& b, hn::Vec<D> distance) {
  auto largest = hn::Zero(d);
  for (int side = 0; side < 2; ++side) {
    EachPart([&](std::size_t lane) HWY_ATTR {
      const auto gap_at = [&](int end) HWY_ATTR {
        return hn::Add(hn::Load(d, a.x[end][side] + lane), hn::Load(d, b.x[end][1 - side] + lane));
      };
      auto gap = gap_at(0);
      if (Ends == 2) gap = hn::Min(gap, gap_at(Ends - 1));
      largest = hn::Max(largest, gap);
    });
  }
  return hn::AllTrue(d, hn::Le(largest, distance));
}

template <int Ends>
HWY_ATTR std::size_t KeepNearPairs(const BoxAtEnds<Ends>* boxes, std::span<const BoxPair> pairs,
                                   double distance, BoxPair* kept) {
  const auto limit = hn::Set(d, distance);
  std::size_t count = 0;
  for (const BoxPair pair : pairs) {
    kept[count] = pair;
    count += AreNear(boxes[pair.a], boxes[pair.b], limit);
  }
  return count;
}

template <int Ends>
HWY_ATTR std::size_t KeepNearOne(const BoxAtEnds<Ends>* boxes, Index begin, Index end,
                                 const BoxAtEnds<Ends>& box, double distance, Index* kept) {
  const auto limit = hn::Set(d, distance);
  std::size_t count = 0;
  for (Index k = begin; k < end; ++k) {
    kept[count] = k;
    count += AreNear(boxes[k], box, limit);
  }
  return count;
}

template <int Ends>
constexpr BoxOperations<Ends> kOperations = {FitBoxes<Ends, 1>, FitBoxes<Ends, 2>,   FitBoxes<Ends, 3>,
                                             FitMoving<Ends>,   KeepNearPairs<Ends>, KeepNearOne<Ends>};

// Highway exports functions, but no templates.
const BoxOperations<1>& OperationsOnPoses() { return kOperations<1>; }
const BoxOperations<2>& OperationsOnSteps() { return kOperations<2>; }

}  // namespace foldproof::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace foldproof::internal {

HWY_EXPORT(OperationsOnPoses);
HWY_EXPORT(OperationsOnSteps);

template <>
const BoxOperations<1>& box_operations() {
  return HWY_DYNAMIC_DISPATCH(OperationsOnPoses)();
}

template <>
const BoxOperations<2>& box_operations() {
  return HWY_DYNAMIC_DISPATCH(OperationsOnSteps)();
}

}  // namespace foldproof::internal
#endif
