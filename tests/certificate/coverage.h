/// Whether a drawing covers its square once, decided by plain exact geometry: no edge is matched with
/// another.
#pragma once

#include "foldproof/certificate.h"
#include "oracle/oracle.h"

namespace foldproof::testing {

class Coverage {
 public:
  /// `seed`: of the values that are interpolated to see whether the triangles fit together.
  Coverage(const Patch& patch, const Drawing& drawing, std::uint64_t seed);

  /// All triangles name vertices that are there and turn to the left.
  bool all_turned_alike() const { return turned_alike_; }
  /// They lie in the square, overlap nowhere, and their areas add up to the square's. Exact.
  bool covers_once() const;
  /// What is interpolated linearly in every triangle from values at the vertices has one value everywhere.
  /// Looks at the middle of every edge; exact there.
  bool continuous() const;
  /// A vertex of the patch lies on the square's border.
  bool touches_border() const;
  bool all_good() const { return turned_alike_ && covers_once() && continuous(); }

  /// In how many triangles the point (x, y) / 2 lies; -1 when it lies on an edge.
  int count_at(int x, int y) const;

 private:
  struct Corner {
    std::int64_t x, y;  // twice the place
  };
  using Corners = std::array<std::uint16_t, 3>;
  static std::int64_t turn(Corner a, Corner b, Corner c);
  bool apart(const Corners& s, const Corners& t) const;
  oracle::Rational value(const Corners& t, Corner at) const;

  std::vector<Corner> corners_;
  std::vector<Corners> triangles_;
  std::vector<std::int64_t> values_;
  std::size_t vertices_;
  bool turned_alike_ = true;
};

}  // namespace foldproof::testing
