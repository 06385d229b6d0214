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

// Four numbers, in as many parts as the instruction set makes of them. Minima and maxima are exact, whichever
// zero they give, and negation is (tests/arithmetic, Order).
template <class Visit>
HWY_INLINE void EachPart(Visit visit) {
  for (std::size_t lane = 0; lane < 4; lane += hn::Lanes(d)) visit(lane);
}

template <int Ends, std::size_t N>
HWY_ATTR void FitBoxes(const PlacedPoint<Ends>* points, std::span<const std::array<Index, N>> corners,
                       PlacedBox<Ends>* boxes) {
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
HWY_ATTR void FitMoving(const PlacedPoint<Ends>* points, const PlacedPoint<Ends>* before,
                        std::span<const Index> places, PlacedBox<Ends>& box, double (&went)[2][4]) {
  EachPart([&](std::size_t lane) HWY_ATTR {
    auto least = hn::Set(d, std::numeric_limits<double>::infinity()), most = hn::Neg(least);
    for (int end = 0; end < Ends; ++end) {
      auto low = hn::Load(d, points[places[0]].x[end] + lane), high = low;
      for (const Index place : places) {
        const auto p = hn::Load(d, points[place].x[end] + lane);
        const auto step = hn::Sub(p, hn::Load(d, before[place].x[end] + lane));
        low = hn::Min(low, p);
        high = hn::Max(high, p);
        least = hn::Min(least, step);
        most = hn::Max(most, step);
      }
      hn::Store(low, d, box.x[end][0] + lane);
      hn::Store(hn::Neg(high), d, box.x[end][1] + lane);
    }
    hn::StoreU(least, d, went[0] + lane);
    hn::StoreU(hn::Neg(most), d, went[1] + lane);
  });
}

// Whether on one axis and side more than `distance` lies between two boxes, at all ends. The fourth lanes are
// 0, and never more.
template <int Ends>
HWY_INLINE bool AreNear(const PlacedBox<Ends>& a, const PlacedBox<Ends>& b, hn::Vec<D> distance) {
  auto most = hn::Zero(d);
  for (int side = 0; side < 2; ++side) {
    EachPart([&](std::size_t lane) HWY_ATTR {
      const auto between = [&](int end) HWY_ATTR {
        return hn::Add(hn::Load(d, a.x[end][side] + lane), hn::Load(d, b.x[end][1 - side] + lane));
      };
      auto least = between(0);
      if (Ends == 2) least = hn::Min(least, between(Ends - 1));
      most = hn::Max(most, least);
    });
  }
  return hn::AllTrue(d, hn::Le(most, distance));
}

template <int Ends>
HWY_ATTR std::size_t KeepNearPairs(const PlacedBox<Ends>* boxes, std::span<const BoxPair> pairs,
                                   double distance, BoxPair* kept) {
  const auto most = hn::Set(d, distance);
  std::size_t count = 0;
  for (const BoxPair pair : pairs) {
    kept[count] = pair;
    count += AreNear(boxes[pair.a], boxes[pair.b], most);
  }
  return count;
}

template <int Ends>
HWY_ATTR std::size_t KeepNearOne(const PlacedBox<Ends>* boxes, Index begin, Index end,
                                 const PlacedBox<Ends>& box, double distance, Index* kept) {
  const auto most = hn::Set(d, distance);
  std::size_t count = 0;
  for (Index k = begin; k < end; ++k) {
    kept[count] = k;
    count += AreNear(boxes[k], box, most);
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
namespace foldproof {

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

}  // namespace foldproof
#endif
