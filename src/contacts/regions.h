/// The regions that the curves of a contact enclose on its two surfaces.
#pragma once

#include <optional>

#include "contacts/curves.h"

namespace foldproof::inline internal {

/// What of one side, or of a surface that goes into itself, is inside.
struct Region {
  std::vector<Index> vertices;   ///< Inside; the object's own ids.
  std::vector<Index> triangles;  ///< With all corners inside, ascending.
  /// Pieces of edges inside that begin and end on curves. Where at most kFew vertices are inside, which tell
  /// too little, those that begin or end in vertices, too.
  std::vector<std::array<Vec3, 2>> pieces;
  static constexpr std::size_t kFew = 16;
  double area = 0;        ///< Mesh units squared; triangles that cross count in part.
  Index last = kNoIndex;  ///< A vertex that is far from the curves, along the surface.
};

/// Which curves divide a surface, and what of it is inside.
struct RegionQuery {
  Index object = 0;
  std::array<bool, 2> sides{};  ///< Whose curves, as they lie on this object: one's, or both.
  /// The triangles of these sides that cross; none: no area is asked for.
  std::span<const Index> crossing;
  /// Inside is what lies behind (1) or before (-1) the faces of the other surface; 0: the smaller part.
  int behind = 0;
};

/// Finds regions (global intersection analysis: Baraff, Witkin and Kass 2003). Keeps scratch.
class RegionFinder {
 public:
  explicit RegionFinder(const Surfaces& surfaces) : surfaces_(surfaces) {}

  /// One of the two parts that the curves divide the surface into. None when they do not divide it.
  /// Cost: in proportion to the smaller part and to the vertices near the curves; or to the region.
  std::optional<Region> find(const Curves& curves, const RegionQuery& query, Positions x);
  /// What curves that do not divide a surface have on each side of them: the vertices that are nearer, along
  /// the surface, to the ends of the cut edges before the other surface's faces than to those behind, and the
  /// others. Only the nearest: some dozens, and some for each cut edge.
  std::array<std::vector<Index>, 2> find_tips(const Curves& curves, const RegionQuery& query, Positions x);
  /// Whether a triangle has a corner or a piece of an edge in the last region.
  bool reaches_inside(Index triangle);
  /// Appends the pieces of a triangle's edges that are outside the last region.
  void add_outer_pieces(Index triangle, Positions x, std::vector<std::array<Vec3, 3>>& out);
  /// Whether a point of a triangle is in the last region.
  bool is_inside(Index triangle, const Vec3& p, Positions x);

 private:
  // Vertices that are connected without crossing a curve, as far as they were visited.
  struct Component {
    Index parent;  // union-find
    std::vector<Index> vertices;
    std::size_t visited = 0;  // of `vertices`
  };
  struct Cut {
    Edge edge;
    double share;
    const Piercing* piercing;
  };
  void collect_cuts(const Curves& curves, const RegionQuery& query);
  std::size_t end_behind(const Piercing& piercing, Positions x) const;
  void begin_search();
  const Cut* find_cut(Index u, Index w) const;
  bool is_near_cuts(Index vertex) const { return cut_stamps_[vertex] == stamp_; }
  bool is_cut(Index u, Index w) const {
    return is_near_cuts(u) && is_near_cuts(w) && find_cut(u, w) != nullptr;
  }
  bool is_wall(Index vertex) const {
    return is_near_cuts(vertex) && std::binary_search(walls_.begin(), walls_.end(), vertex);
  }
  bool is_passable(Index u, Index w) const;
  Index component_of(Index vertex);
  Index root_of(Index component);
  void add(Index component, Index vertex);
  void grow();
  void visit(Index component);
  void unite(Index component, Index other);
  bool is_complete(Index component) const;
  bool assign_parts();
  void turn_groups(int behind, Positions x);
  bool is_inside(Index vertex);
  std::optional<int> lone_corner(const Triangle& triangle);
  Vec3 cut_at(Index u, Index w, Positions x) const;
  std::span<const Cut> all_cuts(Index u, Index w) const;
  std::span<const std::array<Index, 2>> segments_in(Index triangle) const;
  bool is_inside_at(Index u, Index w);
  bool is_inside_between_walls(Index u, Index w);
  void add_pieces(Positions x, Region& region);
  template <class Visit>
  void for_each_piece(const Edge& edge, std::span<const Cut> cuts, const Visit& visit);
  Region region(Positions x);
  double area(const Region& region, std::span<const Index> crossing, Positions x);

  const Surfaces& surfaces_;
  Index object_ = 0;
  bool has_faces_only_ = false;
  std::vector<Cut> all_cuts_;  // sorted by edge and share
  std::vector<Cut> cuts_;      // the first of each edge that has an odd number
  std::vector<Index> walls_;   // vertices on a curve, sorted: nothing is connected through them
  const Curves* curves_ = nullptr;
  std::vector<std::array<Index, 2>> segments_;  // triangles and segments in them, sorted
  std::vector<Edge> with_pieces_;               // edges with pieces inside between curves, sorted
  std::vector<Index> at_edge_;
  std::vector<Component> components_;
  std::vector<Index> active_;
  std::vector<Index> component_at_;  // per vertex of the object, with `stamp_`
  std::vector<std::uint32_t> stamps_, cut_stamps_;
  // Per vertex, with cut_stamps_: which of all_cuts_ have it as their edge's first.
  std::vector<std::array<Index, 2>> cuts_from_;
  std::uint32_t stamp_ = 0;
  std::vector<std::uint8_t> inside_;  // per component
  std::vector<Index> group_;          // per component: those that cuts connect
};

}  // namespace foldproof::inline internal
