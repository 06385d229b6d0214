/// Exact geometry of places in the plane of a chart.
#pragma once

#include "foldproof/certificate.h"

namespace foldproof {

struct Direction {
  int x, y;
};

inline Direction operator-(Place to, Place from) { return {to[0] - from[0], to[1] - from[1]}; }

/// Below 2^35 for differences of places: exact.
inline std::int64_t cross(Direction a, Direction b) {
  return std::int64_t{a.x} * b.y - std::int64_t{a.y} * b.x;
}
inline std::int64_t dot(Direction a, Direction b) {
  return std::int64_t{a.x} * b.x + std::int64_t{a.y} * b.y;
}

/// Twice the area, positive when a, b, c turn to the left.
inline std::int64_t turn(Place a, Place b, Place c) { return cross(b - a, c - a); }

/// Directed edges of triangles with small vertex numbers, each at most once.
class DirectedEdges {
 public:
  void reset(std::size_t most);
  /// False when it is there already.
  bool insert(std::uint16_t from, std::uint16_t to);
  bool contains(std::uint16_t from, std::uint16_t to) const;

 private:
  static std::uint32_t key(std::uint16_t from, std::uint16_t to) { return std::uint32_t{from} << 16 | to; }
  std::size_t slot(std::uint32_t k) const { return (k * 0x9E3779B1u) >> shift_; }
  std::vector<std::uint32_t> table_;
  int shift_ = 31;
};

/// chart_is_valid with scratch of the caller's.
bool chart_is_valid(const Patch& patch, const Drawing& drawing, DirectedEdges& scratch);

/// Which triangle has a directed edge.
class EdgeOwners {
 public:
  static constexpr std::uint32_t kNobody = 0xFFFFFFFF;
  void reset(std::size_t most);
  void set(std::uint16_t from, std::uint16_t to, std::uint32_t owner);
  std::uint32_t owner(std::uint16_t from, std::uint16_t to) const;

 private:
  struct Entry {
    std::uint32_t key, owner;
  };
  std::size_t find(std::uint32_t key) const;
  std::vector<Entry> table_;
  int shift_ = 31;
};

}  // namespace foldproof
