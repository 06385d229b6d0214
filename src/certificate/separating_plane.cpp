#include "certificate/separating_plane.h"

#include <algorithm>
#include <cmath>

#undef HWY_TARGET_INCLUDE  // Highway compiles this file once per instruction set
#define HWY_TARGET_INCLUDE "certificate/separating_plane.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef FOLDPROOF_SEPARATING_PLANE_ONCE
#define FOLDPROOF_SEPARATING_PLANE_ONCE
namespace foldproof {

struct VertexSet {
  std::span<const MovingVertex> vertices;
  std::span<const Index> ids;
  const MovingVertex& at(std::size_t i) const { return vertices[ids[i]]; }
};

}  // namespace foldproof
#endif

HWY_BEFORE_NAMESPACE();
namespace foldproof::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// The points of a set at both ends that lie furthest against a direction; the first of equals. Coordinates
// are finite (tests/arithmetic, Frame): where all products were NaN, nothing would be least.
struct Least {
  float along[2];
  std::size_t at[2];
};

#if HWY_TARGET == HWY_SCALAR
Least FindLeast(const VertexSet& set, const float (&n)[8]) {
  Least least{{INFINITY, INFINITY}, {0, 0}};
  for (std::size_t i = 0; i < set.ids.size(); ++i) {
    for (int end = 0; end < 2; ++end) {
      const float* x = set.at(i).x + 4 * end;
      // In the order of the sums below, so that the answer is the same on every machine.
      const float along = (x[0] * n[0] + x[2] * n[2]) + (x[1] * n[1] + x[3] * n[3]);
      if (along < least.along[end]) {
        least.along[end] = along;
        least.at[end] = i;
      }
    }
  }
  return least;
}
#else
Least FindLeast(const VertexSet& set, const float (&n)[8]) {
  const hn::CappedTag<float, 8> d;
  Least out{{INFINITY, INFINITY}, {0, 0}};
  const std::size_t last = set.ids.size() - 1;
  alignas(32) static constexpr float kNumbers[8] = {0, 1, 2, 3, 0, 1, 2, 3};
  for (std::size_t lane = 0; lane < 8; lane += hn::Lanes(d)) {  // both ends at once, or one after the other
    const auto direction = hn::LoadU(d, n + lane), four = hn::Set(d, 4);
    auto least = hn::Set(d, INFINITY), at = hn::Zero(d), number = hn::Load(d, kNumbers + lane);
    for (std::size_t i = 0; i <= last; i += 4) {
      const auto product = [&](std::size_t k) {
        return hn::Mul(hn::Load(d, set.at(std::min(i + k, last)).x + lane), direction);
      };
      // Four dot products: x + z and y + 0 side by side, then their sums.
      const auto p0 = product(0), p1 = product(1), p2 = product(2), p3 = product(3);
      const auto even = hn::Add(hn::InterleaveLower(d, p0, p2), hn::InterleaveUpper(d, p0, p2));
      const auto odd = hn::Add(hn::InterleaveLower(d, p1, p3), hn::InterleaveUpper(d, p1, p3));
      const auto along = hn::Add(hn::InterleaveLower(d, even, odd), hn::InterleaveUpper(d, even, odd));
      at = hn::IfThenElse(hn::Lt(along, least), number, at);
      least = hn::Min(least, along);
      number = hn::Add(number, four);
    }
    alignas(32) float along[8], numbers[8];
    hn::Store(least, d, along + lane);
    hn::Store(at, d, numbers + lane);
    for (std::size_t k = lane; k < lane + hn::Lanes(d); ++k) {
      const std::size_t end = k / 4, i = std::min(static_cast<std::size_t>(numbers[k]), last);
      if (along[k] < out.along[end] || (along[k] == out.along[end] && i < out.at[end])) {
        out.along[end] = along[k];
        out.at[end] = i;
      }
    }
  }
  return out;
}
#endif

// How far a direction separates the sets at each end, and where they come nearest along it.
struct Separation {
  Least a, b;
  float along[2];
  int worst;
  float square;  // of the direction's length
};

Separation LookAlong(const VertexSet& a, const VertexSet& b, const float (&n)[3]) {
  const float along_a[8] = {n[0], n[1], n[2], 0, n[0], n[1], n[2], 0};
  const float along_b[8] = {-n[0], -n[1], -n[2], 0, -n[0], -n[1], -n[2], 0};
  Separation apart{
      FindLeast(a, along_a), FindLeast(b, along_b), {}, 0, n[0] * n[0] + n[1] * n[1] + n[2] * n[2]};
  for (int end = 0; end < 2; ++end) apart.along[end] = apart.a.along[end] + apart.b.along[end];
  apart.worst = apart.along[1] < apart.along[0];
  return apart;
}

// Theorem 1 along a direction. Shorter ones lose digits when they are squared, or vanish. S4: one rounding to
// nearest per product, sum and root (tests/arithmetic, Rounding).
bool Separate(const Separation& apart, float gap) {
  return apart.square > 1e-30f && apart.along[apart.worst] > gap * std::sqrt(apart.square);
}

// Gilbert's search for the point of the difference of both sets that is nearest to the origin; it stops as
// soon as its direction separates them at both ends.
bool Separates(const VertexSet& a, const VertexSet& b, float gap, PlaneNormal* normal) {
  // Curved sheets that lie on each other need more than 8; with 24 pairs that have none cost too much.
  constexpr int kMostRounds = 16;
  float n[3];
  if (normal != nullptr && *normal != PlaneNormal{}) {
    std::copy(normal->begin(), normal->end(), n);
    if (Separate(LookAlong(a, b, n), gap)) return true;
  }
  for (int axis = 0; axis < 3; ++axis) {
    n[axis] = (a.at(0).x[axis] + a.at(0).x[4 + axis]) / 2 - (b.at(0).x[axis] + b.at(0).x[4 + axis]) / 2;
  }
  for (int round = 0; round < kMostRounds; ++round) {
    const Separation apart = LookAlong(a, b, n);
    if (Separate(apart, gap)) {
      if (normal != nullptr) *normal = {n[0], n[1], n[2]};
      return true;
    }
    if (!(apart.square > 1e-30f)) return false;
    // The point of the segment from n to the difference found that is nearest to the origin.
    const int worst = apart.worst;
    const float* from = a.at(apart.a.at[worst]).x + 4 * worst;
    const float* to = b.at(apart.b.at[worst]).x + 4 * worst;
    float way[3], dot = 0, square = 0;
    for (int axis = 0; axis < 3; ++axis) {
      way[axis] = (from[axis] - to[axis]) - n[axis];
      dot -= n[axis] * way[axis];
      square += way[axis] * way[axis];
    }
    if (!(dot > 0)) return false;  // as near as it gets
    const float t = std::min(1.f, dot / square);
    for (int axis = 0; axis < 3; ++axis) n[axis] += t * way[axis];
  }
  return false;
}

}  // namespace foldproof::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace foldproof {

HWY_EXPORT(Separates);

bool plane_separates(std::span<const MovingVertex> vertices_a, std::span<const Index> a,
                     std::span<const MovingVertex> vertices_b, std::span<const Index> b, double gap,
                     PlaneNormal* normal) {
  // What rounding may add: docs/soundness.md, S4.
  const float bound = static_cast<float>(gap * (1 + 0x1p-20) + 0x1p-19);
  return HWY_DYNAMIC_DISPATCH(Separates)({vertices_a, a}, {vertices_b, b}, bound, normal);
}

}  // namespace foldproof
#endif  // HWY_ONCE
