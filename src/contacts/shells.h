/// The connected pieces of a mesh's faces: which are closed, and how nearly.
#pragma once

#include "foldproof/check.h"

namespace foldproof::inline internal {

/// Shells are numbered from 0. A vertex of no face has none. Immutable once made.
class Shells {
 public:
  explicit Shells(const Topology& topology);

  /// kNoIndex: no face has the vertex.
  Index of(Index vertex) const { return shell_[vertex]; }
  /// Every edge has an even number of faces.
  bool is_closed(Index shell) const { return begin_[shell] == begin_[shell + 1]; }
  /// How much of what is seen from `p`, a point of the shell, is open: the solid angle of the shell's holes,
  /// each covered by triangles around its middle, as a share of the whole sphere. So the generalized winding
  /// number (Jacobson, Kavan and Sorkine-Hornung 2013) is 1 less this share on the one side of the shell, and
  /// this share below 0 on the other. Cost: that of the borders.
  double open_share(Index shell, std::span<const double> x, const Vec3& p) const;
  /// 1 where the shell, with its holes covered, has its faces' fronts outside; -1 inside. Cost: that of the
  /// shell.
  int outward(Index shell, std::span<const double> x) const;

 private:
  struct Border {
    Index from, to;  // in the order of the face that has them
    Index loop;      // a vertex of it
  };
  template <class Visit>
  void for_each_cap(Index shell, std::span<const double> x, const Visit& visit) const;
  void find_borders();

  const Topology& topology_;
  std::vector<Index> shell_;              // per vertex
  std::vector<Index> faces_;              // by shell
  std::vector<std::size_t> faces_begin_;  // of faces_, per shell
  std::vector<Border> borders_;           // by shell, then loop
  std::vector<std::size_t> begin_;        // of borders_, per shell
};

}  // namespace foldproof::inline internal
