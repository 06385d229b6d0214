/// The regions that the curves of a contact enclose on its two surfaces.
#pragma once

#include <optional>

#include "contacts/curves.h"

namespace foldproof::inline internal {

/// What of one side is inside the other surface.
struct Region {
  std::vector<Index> vertices;   ///< Inside, ascending; the object's own ids.
  std::vector<Index> triangles;  ///< With all corners inside, ascending.
  double area = 0;               ///< Mesh units squared; triangles that cross count in part.
};

/// Finds regions (global intersection analysis: Baraff, Witkin and Kass 2003). Keeps scratch.
class RegionFinder {
 public:
  explicit RegionFinder(const Surfaces& surfaces) : surfaces_(surfaces) {}

  /// The region of a side: of the two parts that the curves divide the surface into, the smaller. None when
  /// the curves do not divide it. `crossing`: the triangles of this side, of `object`, that cross, each once.
  /// Cost: in proportion to the region and to the vertices near the curves.
  std::optional<Region> find(const Curves& curves, int side, Index object, std::span<const Index> crossing,
                             Positions x);

 private:
  // Vertices that are connected without crossing a curve, as far as they were visited.
  struct Component {
    Index parent;  // union-find
    std::vector<Index> vertices;
    std::size_t visited = 0;  // of `vertices`
  };
  void collect_cuts(const Curves& curves, int side);
  bool is_cut(Index u, Index w) const;
  Index component_of(Index vertex);
  Index root_of(Index component);
  void add(Index component, Index vertex);
  void grow();
  void visit(Index component);
  bool assign_parts();
  Region region(const Curves& curves, std::span<const Index> crossing, Positions x);

  const Surfaces& surfaces_;
  Index object_ = 0;
  struct Cut {
    Edge edge;
    double share;
  };
  std::vector<Cut> cuts_;  // edges that are pierced an odd number of times, sorted
  std::vector<Component> components_;
  std::vector<Index> active_;
  std::vector<Index> component_at_;  // per vertex of the object, with `stamp_`
  std::vector<std::uint32_t> stamps_, cut_stamps_;
  std::uint32_t stamp_ = 0;
  std::vector<std::uint8_t> inside_;  // per component
};

}  // namespace foldproof::inline internal
