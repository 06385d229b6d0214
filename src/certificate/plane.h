/// Exact geometry of places in the plane of a chart.
#pragma once

#include <cstring>

#include "foldproof/certificate.h"

namespace foldproof {

struct Direction {
  int x, y;
};

constexpr Direction operator-(Place to, Place from) { return {to[0] - from[0], to[1] - from[1]}; }

/// Below 2^35 for differences of places: exact.
constexpr std::int64_t cross(Direction a, Direction b) {
  return std::int64_t{a.x} * b.y - std::int64_t{a.y} * b.x;
}
constexpr std::int64_t dot(Direction a, Direction b) {
  return std::int64_t{a.x} * b.x + std::int64_t{a.y} * b.y;
}

/// Twice the area, positive when a, b, c turn to the left.
constexpr std::int64_t turn(Place a, Place b, Place c) { return cross(b - a, c - a); }

/// Directed sides of triangles with small vertex numbers, listed by the vertex that they come from, so that
/// whether one is there takes a few comparisons of eight at once and no guess.
class DirectedSides {
 public:
  using Corners = std::array<std::uint16_t, 3>;

  /// Lists the sides of all triangles in both groups, whose vertices are below `vertices`.
  void list(std::size_t vertices, std::span<const Corners> group, std::span<const Corners> more = {});

  bool contains(std::uint16_t from, std::uint16_t to) const {
    constexpr std::uint64_t kOnes = 0x0001000100010001;
    const std::uint64_t wanted = to * kOnes;
    for (std::uint32_t k = begin_[from]; k < begin_[from + std::size_t{1}]; k += kTogether) {
      std::uint64_t four[2];
      std::memcpy(four, &to_[k], sizeof four);
      // A number less one borrows from its highest bit when it is 0.
      const std::uint64_t a = four[0] ^ wanted, b = four[1] ^ wanted;
      if ((((a - kOnes) & ~a) | ((b - kOnes) & ~b)) & (kOnes << 15)) return true;
    }
    return false;
  }

 private:
  static constexpr std::uint32_t kTogether = 8;
  std::vector<std::uint32_t> begin_, end_;  // per vertex; what lies behind end_ is nobody's number
  std::vector<std::uint16_t> to_;
};

/// chart_is_valid with scratch of the caller's.
bool chart_is_valid(const Patch& patch, const Drawing& drawing, DirectedSides& scratch);

}  // namespace foldproof
