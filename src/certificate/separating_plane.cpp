#include "certificate/separating_plane.h"

#include <algorithm>
#include <cmath>

#include "certificate/nearest_point.h"

#undef HWY_TARGET_INCLUDE  // Highway compiles this file once per instruction set
#define HWY_TARGET_INCLUDE "certificate/separating_plane.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef FOLDPROOF_SEPARATING_PLANE_ONCE
#define FOLDPROOF_SEPARATING_PLANE_ONCE
namespace foldproof::internal {

struct VertexSet {
  std::span<const MovingVertex> vertices;
  std::span<const Index> ids;
  const MovingVertex& at(std::size_t i) const { return vertices[ids[i]]; }
};

}  // namespace foldproof::internal
#endif

HWY_BEFORE_NAMESPACE();
namespace foldproof::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Support points of a set against a direction, at both ends: the smallest projections and their vertices, the
// first of equal ones. Coordinates are finite (tests/arithmetic, Frame); with NaN there would be no smallest.
struct Support {
  float projection[2];
  std::size_t vertex[2];
};

#if HWY_TARGET == HWY_SCALAR
Support FindSupport(const VertexSet& set, const float (&n)[8]) {
  Support support{{INFINITY, INFINITY}, {0, 0}};
  for (std::size_t i = 0; i < set.ids.size(); ++i) {
    for (int end = 0; end < 2; ++end) {
      const float* x = set.at(i).x + 4 * end;
      // Summed in the same order as below, so that the answer is the same on every machine.
      const float projection = (x[0] * n[0] + x[2] * n[2]) + (x[1] * n[1] + x[3] * n[3]);
      if (projection < support.projection[end]) {
        support.projection[end] = projection;
        support.vertex[end] = i;
      }
    }
  }
  return support;
}
#else
Support FindSupport(const VertexSet& set, const float (&n)[8]) {
  const hn::CappedTag<float, 8> d;
  Support out{{INFINITY, INFINITY}, {0, 0}};
  const std::size_t last = set.ids.size() - 1;
  alignas(32) static constexpr float kNumbers[8] = {0, 1, 2, 3, 0, 1, 2, 3};
  for (std::size_t lane = 0; lane < 8; lane += hn::Lanes(d)) {  // both ends at once, or one after the other
    const auto direction = hn::LoadU(d, n + lane), four = hn::Set(d, 4);
    auto smallest = hn::Set(d, INFINITY), vertex = hn::Zero(d), number = hn::Load(d, kNumbers + lane);
    for (std::size_t i = 0; i <= last; i += 4) {
      const auto product = [&](std::size_t k) {
        return hn::Mul(hn::Load(d, set.at(std::min(i + k, last)).x + lane), direction);
      };
      // Four dot products: x + z and y + 0 side by side, then their sums.
      const auto p0 = product(0), p1 = product(1), p2 = product(2), p3 = product(3);
      const auto even = hn::Add(hn::InterleaveLower(d, p0, p2), hn::InterleaveUpper(d, p0, p2));
      const auto odd = hn::Add(hn::InterleaveLower(d, p1, p3), hn::InterleaveUpper(d, p1, p3));
      const auto projection = hn::Add(hn::InterleaveLower(d, even, odd), hn::InterleaveUpper(d, even, odd));
      vertex = hn::IfThenElse(hn::Lt(projection, smallest), number, vertex);
      smallest = hn::Min(smallest, projection);
      number = hn::Add(number, four);
    }
    alignas(32) float projections[8], numbers[8];
    hn::Store(smallest, d, projections + lane);
    hn::Store(vertex, d, numbers + lane);
    for (std::size_t k = lane; k < lane + hn::Lanes(d); ++k) {
      const std::size_t end = k / 4, i = std::min(static_cast<std::size_t>(numbers[k]), last);
      if (projections[k] < out.projection[end] ||
          (projections[k] == out.projection[end] && i < out.vertex[end])) {
        out.projection[end] = projections[k];
        out.vertex[end] = i;
      }
    }
  }
  return out;
}
#endif

// How far the sets are separated along a direction at each end, and by which vertices.
struct Separation {
  Support a, b;
  float distance[2];  // times the direction's length
  int nearer_end;
  float squared_length;  // of the direction
};

Separation SeparationAlong(const VertexSet& a, const VertexSet& b, const PlaneNormal& n) {
  const float along_a[8] = {n[0], n[1], n[2], 0, n[0], n[1], n[2], 0};
  const float along_b[8] = {-n[0], -n[1], -n[2], 0, -n[0], -n[1], -n[2], 0};
  Separation s{
      FindSupport(a, along_a), FindSupport(b, along_b), {}, 0, n[0] * n[0] + n[1] * n[1] + n[2] * n[2]};
  for (int end = 0; end < 2; ++end) s.distance[end] = s.a.projection[end] + s.b.projection[end];
  s.nearer_end = s.distance[1] < s.distance[0];
  return s;
}

// Theorem 1 along a direction. The square of a shorter direction would be inaccurate or zero. S4: every
// product, sum and root is rounded once, to nearest (tests/arithmetic, Rounding).
bool ExceedsGap(const Separation& s, float gap) {
  return s.squared_length > 1e-30f && s.distance[s.nearer_end] > gap * std::sqrt(s.squared_length);
}

// The support point of the difference of both sets, at the end where they are nearer.
NearestPoint::Point SupportOfDifference(const VertexSet& a, const VertexSet& b, const Separation& s) {
  const float* from = a.at(s.a.vertex[s.nearer_end]).x + 4 * s.nearer_end;
  const float* to = b.at(s.b.vertex[s.nearer_end]).x + 4 * s.nearer_end;
  return {from[0] - to[0], from[1] - to[1], from[2] - to[2]};
}

// Searches for the point nearest to the origin in the hull of the Minkowski differences at both ends, from
// the given normal if there is one. Stops as soon as its direction separates the sets at both ends.
bool Separates(const VertexSet& a, const VertexSet& b, float gap, PlaneNormal* normal) {
  constexpr int kMaxIterations = 16;  // hardly ever reached
  PlaneNormal start{};
  if (normal != nullptr) start = *normal;
  if (start == PlaneNormal{}) {
    const float *from = a.at(0).x, *to = b.at(0).x;
    for (int axis = 0; axis < 3; ++axis)
      start[axis] = (from[axis] + from[4 + axis]) / 2 - (to[axis] + to[4 + axis]) / 2;
  }
  NearestPoint nearest(start);
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    const Separation s = SeparationAlong(a, b, nearest.point());
    if (ExceedsGap(s, gap)) {
      if (normal != nullptr) *normal = nearest.point();
      return true;
    }
    if (!nearest.add(SupportOfDifference(a, b, s))) return false;
  }
  return false;
}

}  // namespace foldproof::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace foldproof::internal {

HWY_EXPORT(Separates);

bool plane_separates(std::span<const MovingVertex> vertices_a, std::span<const Index> a,
                     std::span<const MovingVertex> vertices_b, std::span<const Index> b, double gap,
                     PlaneNormal* normal) {
  // With a margin for rounding: docs/soundness.md, S4.
  const float bound = static_cast<float>(gap * (1 + 0x1p-20) + 0x1p-19);
  return HWY_DYNAMIC_DISPATCH(Separates)({vertices_a, a}, {vertices_b, b}, bound, normal);
}

}  // namespace foldproof::internal
#endif  // HWY_ONCE
