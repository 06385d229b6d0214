/// Decides whether a chart covers its square once, by exact geometry that does not match edges with each
/// other.
#pragma once

#include "certificate/library.h"
#include "oracle/oracle.h"

namespace foldproof::testing {

class Coverage {
 public:
  /// `seed`: of the vertex values that continuous() interpolates.
  Coverage(const Patch& patch, const UvMap& uv_map, std::uint64_t seed);

  /// All triangles have vertex numbers in range and are counterclockwise.
  bool all_counterclockwise() const { return counterclockwise_; }
  /// The triangles lie in the square, do not overlap, and their areas add up to the square's. Exact.
  bool covers_once() const;
  /// Linear interpolation of vertex values in the triangles is continuous. Exact, at the midpoints of edges.
  bool continuous() const;
  /// A vertex of the patch lies on the square's border.
  bool touches_border() const;
  bool is_valid() const { return counterclockwise_ && covers_once() && continuous(); }

  /// In how many triangles the point (x, y) / 2 lies; -1 when it lies on an edge.
  int count_at(int x, int y) const;

 private:
  struct Corner {
    std::int64_t x, y;  // twice the uv
  };
  using Corners = std::array<std::uint16_t, 3>;
  static std::int64_t orient2d(Corner a, Corner b, Corner c);
  bool are_disjoint(const Corners& s, const Corners& t) const;
  oracle::Rational value(const Corners& t, Corner at) const;

  std::vector<Corner> corners_;
  std::vector<Corners> triangles_;
  std::vector<std::int64_t> values_;
  std::size_t vertices_;
  bool counterclockwise_ = true;
};

}  // namespace foldproof::testing
