/// The boxes that every peer works on: the union of a feature's boxes at both ends of the step.
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "competitor.h"

namespace foldproof::bench {

/// Closed box in single precision, which is what Embree and Bullet compute with; all peers get the same
/// boxes, so that their candidates must agree exactly. Coordinates are rounded to nearest: exact for data
/// that was stored in single precision, and no peer has to pay for a safety that it does not promise.
struct Box {
  std::array<float, 3> lo, hi;
};

inline Box join(const Box& a, const Box& b) {
  Box box;
  for (int k = 0; k < 3; ++k) {
    box.lo[k] = std::min(a.lo[k], b.lo[k]);
    box.hi[k] = std::max(a.hi[k], b.hi[k]);
  }
  return box;
}

inline bool overlap(const Box& a, const Box& b) {
  bool apart = false;
  for (int k = 0; k < 3; ++k) apart |= a.lo[k] > b.hi[k] || b.lo[k] > a.hi[k];
  return !apart;
}

/// Swept boxes of the vertices; those of edges and faces are joined from them on demand.
class SweptBoxes {
 public:
  /// All boxes are larger by this much on every side.
  double margin = 0;

  void update(std::span<const double> x0, std::span<const double> x1) {
    vertices_.resize(x0.size() / 3);
    for (std::size_t v = 0; v < vertices_.size(); ++v)
      for (std::size_t k = 0; k < 3; ++k) {
        const auto a = static_cast<float>(x0[3 * v + k]), b = static_cast<float>(x1[3 * v + k]);
        vertices_[v].lo[k] = std::min(a, b) - static_cast<float>(margin);
        vertices_[v].hi[k] = std::max(a, b) + static_cast<float>(margin);
      }
  }
  const Box& vertex(Index v) const { return vertices_[v]; }
  Box edge(const Edge& e) const { return join(vertices_[e[0]], vertices_[e[1]]); }
  Box face(const Triangle& t) const { return join(join(vertices_[t[0]], vertices_[t[1]]), vertices_[t[2]]); }

 private:
  std::vector<Box> vertices_;
};

inline Pair ordered(Index a, Index b) { return a < b ? Pair{a, b} : Pair{b, a}; }

inline bool incident(Index v, const Triangle& t) { return (v == t[0]) | (v == t[1]) | (v == t[2]); }

inline bool incident(const Edge& a, const Edge& b) {
  return (a[0] == b[0]) | (a[0] == b[1]) | (a[1] == b[0]) | (a[1] == b[1]);
}

}  // namespace foldproof::bench
