/// Exact geometry in the plane of a chart.
#pragma once

#include <cstring>

#include "certificate/parametrize.h"

namespace foldproof::inline internal {

struct Direction {
  int x, y;
};

constexpr Direction operator-(Uv to, Uv from) { return {to[0] - from[0], to[1] - from[1]}; }

/// Below 2^35 for differences of uvs: exact.
constexpr std::int64_t cross(Direction a, Direction b) {
  return std::int64_t{a.x} * b.y - std::int64_t{a.y} * b.x;
}
constexpr std::int64_t dot(Direction a, Direction b) {
  return std::int64_t{a.x} * b.x + std::int64_t{a.y} * b.y;
}

/// Twice the signed area of a triangle, positive when it is counterclockwise.
constexpr std::int64_t orient2d(Uv a, Uv b, Uv c) { return cross(b - a, c - a); }

/// The half-edges of triangles, listed by their first vertex. contains() compares eight at once.
class HalfEdgeSet {
 public:
  using Corners = std::array<std::uint16_t, 3>;

  /// Replaces the set by the half-edges of both groups. Precondition: vertex numbers are below `vertices`.
  void assign(std::size_t vertices, std::span<const Corners> group, std::span<const Corners> more = {});

  bool contains(std::uint16_t from, std::uint16_t to) const {
    constexpr std::uint64_t kOnes = 0x0001000100010001;
    const std::uint64_t wanted = to * kOnes;
    for (std::uint32_t k = begin_[from]; k < begin_[from + std::size_t{1}]; k += kBlock) {
      std::uint64_t four[2];
      std::memcpy(four, &to_[k], sizeof four);
      // Subtracting one from a 16-bit number borrows through its highest bit when it is 0.
      const std::uint64_t a = four[0] ^ wanted, b = four[1] ^ wanted;
      if ((((a - kOnes) & ~a) | ((b - kOnes) & ~b)) & (kOnes << 15)) return true;
    }
    return false;
  }

 private:
  static constexpr std::uint32_t kBlock = 8;
  std::vector<std::uint32_t> begin_, end_;  // per vertex; from end_ on: padding, no vertex's number
  std::vector<std::uint16_t> to_;
};

/// chart_is_valid with the caller's scratch.
bool chart_is_valid(const Patch& patch, const UvMap& uv_map, HalfEdgeSet& scratch);

}  // namespace foldproof::inline internal
