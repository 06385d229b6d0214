#include "certificate/separating_plane.h"

#include <algorithm>
#include <cmath>

#undef HWY_TARGET_INCLUDE  // Highway compiles this file once per instruction set
#define HWY_TARGET_INCLUDE "certificate/separating_plane.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace foldproof::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// A patch at both ends in rows of x, y, z, each of `stride` points (the last one repeated), with the points
// that lie furthest against a direction.
struct Least {
  float along[2];
  std::size_t at[2];
};

// `sign` -1 turns the set round, so that both sets look for their smallest value.
void ToRows(std::span<const MovingVertex> vertices, std::span<const Index> ids, float sign,
            std::size_t stride, float* rows) {
  for (std::size_t i = 0; i < stride; ++i) {
    const float* p = vertices[ids[std::min(i, ids.size() - 1)]].x;
    for (int end = 0; end < 2; ++end) {
      for (int axis = 0; axis < 3; ++axis) rows[(3 * end + axis) * stride + i] = sign * p[4 * end + axis];
    }
  }
}

HWY_INLINE void FindLeast(const float (&n)[3], const float* rows, std::size_t stride, Least& out) {
  const hn::CappedTag<float, 8> d;
  for (int end = 0; end < 2; ++end, rows += 3 * stride) {
    auto least = hn::Set(d, 3e38f), at = hn::Zero(d);
    for (std::size_t i = 0; i < stride; i += hn::Lanes(d)) {
      const auto along = hn::Add(hn::Add(hn::Mul(hn::Load(d, rows + i), hn::Set(d, n[0])),
                                         hn::Mul(hn::Load(d, rows + stride + i), hn::Set(d, n[1]))),
                                 hn::Mul(hn::Load(d, rows + 2 * stride + i), hn::Set(d, n[2])));
      at = hn::IfThenElse(hn::Lt(along, least), hn::Iota(d, static_cast<float>(i)), at);
      least = hn::Min(least, along);
    }
    const auto smallest = hn::MinOfLanes(d, least);
    // The first of equals, whatever the number of lanes.
    const auto first = hn::MinOfLanes(d, hn::IfThenElse(hn::Eq(least, smallest), at, hn::Set(d, 1e9f)));
    out.along[end] = hn::GetLane(smallest);
    out.at[end] = static_cast<std::size_t>(hn::GetLane(first));
  }
}

// Gilbert's search for the point of the difference of both sets that is nearest to the origin; it stops as
// soon as its direction separates them at both ends.
bool Separates(const float* a, std::size_t stride_a, const float* b, std::size_t stride_b, float (&n)[3],
               float gap) {
  constexpr int kMostRounds = 8;
  for (int round = 0; round < kMostRounds; ++round) {
    Least least_a, least_b;
    FindLeast(n, a, stride_a, least_a);
    FindLeast(n, b, stride_b, least_b);
    const float along[2] = {least_a.along[0] + least_b.along[0], least_a.along[1] + least_b.along[1]};
    const float length2 = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
    const int worst = along[1] < along[0];
    // Theorem 1 along n.
    if (along[worst] > gap * std::sqrt(length2)) return true;
    // The point of the segment from n to the difference found that is nearest to the origin.
    float s[3], e[3], dot = 0, square = 0;
    for (int axis = 0; axis < 3; ++axis) {
      s[axis] = a[(3 * worst + axis) * stride_a + least_a.at[worst]] +
                b[(3 * worst + axis) * stride_b + least_b.at[worst]];
      e[axis] = s[axis] - n[axis];
      dot -= n[axis] * e[axis];
      square += e[axis] * e[axis];
    }
    if (!(dot > 0)) return false;  // as near as it gets
    const float t = std::min(1.f, dot / square);
    for (int axis = 0; axis < 3; ++axis) n[axis] += t * e[axis];
  }
  return false;
}

}  // namespace foldproof::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace foldproof {

HWY_EXPORT(ToRows);
HWY_EXPORT(Separates);

bool plane_separates(std::span<const MovingVertex> vertices_a, std::span<const Index> a,
                     std::span<const MovingVertex> vertices_b, std::span<const Index> b, double gap,
                     PlaneScratch& scratch) {
  const auto round_up = [](std::size_t n) { return (n + 7) / 8 * 8; };
  const std::size_t stride[2] = {round_up(a.size()), round_up(b.size())};
  for (int k = 0; k < 2; ++k) {
    const std::size_t eights = 6 * stride[k] / 8;
    if (scratch.rows[k].size() < eights) scratch.rows[k].resize(eights);
  }
  float *const rows_a = scratch.rows[0].data()->x, *const rows_b = scratch.rows[1].data()->x;
  HWY_DYNAMIC_DISPATCH(ToRows)(vertices_a, a, 1.f, stride[0], rows_a);
  HWY_DYNAMIC_DISPATCH(ToRows)(vertices_b, b, -1.f, stride[1], rows_b);
  // The way from a point of b to one of a, and what rounding may add (docs/soundness.md, S4).
  float n[3] = {};
  for (int row = 0; row < 6; ++row) {
    n[row % 3] += (rows_a[row * stride[0]] + rows_b[row * stride[1]]) / 2;
  }
  const float bound = static_cast<float>(gap * (1 + 0x1p-20) + 0x1p-19);
  return HWY_DYNAMIC_DISPATCH(Separates)(rows_a, stride[0], rows_b, stride[1], n, bound);
}

}  // namespace foldproof
#endif  // HWY_ONCE
