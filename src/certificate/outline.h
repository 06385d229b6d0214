/// The outline of a drawn patch, and the triangles that fill the square around it.
#pragma once

#include "certificate/plane.h"

namespace foldproof {

/// Fills what lies between a drawn patch and the square, and the patch' holes. Scratch: reused.
class OutlineFiller {
 public:
  /// Appends fillers to `drawing`. False when the outline is not that of one piece drawn without overlap;
  /// true promises nothing yet, chart_is_valid does.
  bool fill(const Patch& patch, Drawing& drawing);

 private:
  struct Edge {
    std::uint16_t from, to, next_from_same;  // next in the list of edges that leave `from`
    bool walked;
  };
  bool find_outline(const Patch& patch);
  bool walk(std::size_t first, const Drawing& drawing);
  std::size_t next_edge(const Edge& in, const Drawing& drawing) const;
  bool is_empty(Place a, Place b, Place c) const;
  void place_loop(const Drawing& drawing);
  void drop(std::size_t from_loop);
  void fill_bays(Drawing& drawing);
  bool join_square(Drawing& drawing);
  bool fill_hole(Drawing& drawing);
  void fatten(Drawing& drawing);
  void find_opposites(const Drawing& drawing);
  bool flip(Drawing& drawing, std::uint32_t side);

  static constexpr std::uint32_t kNobody = 0xFFFFFFFF;
  DirectedSides sides_;
  std::vector<std::uint32_t> first_side_,
      next_side_;                        // of fillers: per vertex, and per side, from the same vertex
  std::vector<std::uint32_t> opposite_;  // per side of a filler, 3 filler + k: the filler's on its other side
  std::vector<std::uint32_t> suspects_;  // sides
  std::vector<Edge> edges_;
  std::vector<std::uint16_t> first_from_;  // per vertex: its first edge in edges_
  std::vector<std::uint16_t>
      loop_;  // what is left to fill outside or inside of, counterclockwise round the patch
  std::vector<Place> loop_places_;  // of its vertices
};

}  // namespace foldproof
