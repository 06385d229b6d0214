/// The scaffold of a chart: triangles that fill the square around a parametrized patch.
#pragma once

#include "certificate/chart_plane.h"

namespace foldproof::inline internal {

/// Triangulates what a parametrized patch leaves free of the square, its holes included. Scratch: reused.
class ScaffoldBuilder {
 public:
  /// Appends the scaffold to `uv_map`. False where the outline is not that of one piece without overlap. True
  /// does not imply a valid chart: see chart_is_valid.
  bool build(const Patch& patch, UvMap& uv_map);

 private:
  // An edge of the outline. `next_from_same`: the next in the list of edges with the same `from`.
  struct Edge {
    std::uint16_t from, to, next_from_same;
    bool visited;
  };
  bool find_outline(const Patch& patch);
  bool trace_loop(std::size_t first, const UvMap& uv_map);
  std::size_t next_edge(const Edge& in, const UvMap& uv_map) const;
  bool contains_no_vertex(Uv a, Uv b, Uv c) const;
  void read_loop_uvs(const UvMap& uv_map);
  void remove_from_loop(std::size_t index);
  void fill_concavities(UvMap& uv_map);
  bool join_to_square(UvMap& uv_map);
  bool fill_hole(UvMap& uv_map);
  void make_delaunay(UvMap& uv_map);
  void find_twins(const UvMap& uv_map);
  bool flip(UvMap& uv_map, std::uint32_t half_edge);

  HalfEdgeSet half_edges_;  // of the patch
  std::vector<Edge> edges_;
  std::vector<std::uint16_t> first_from_;  // per vertex: its first edge in edges_
  // The boundary of what is not filled yet, as traced with the patch on its left.
  std::vector<std::uint16_t> loop_;
  std::vector<Uv> loop_uvs_;

  // Half-edge k of scaffold triangle t has number 3 t + k.
  static constexpr std::uint32_t kNoHalfEdge = 0xFFFFFFFF;
  std::vector<std::uint32_t> first_half_edge_;  // per vertex: a half-edge from it
  std::vector<std::uint32_t> next_half_edge_;   // per half-edge: the next from the same vertex
  std::vector<std::uint32_t> twin_;             // per half-edge: the one on the other side of its edge
  std::vector<std::uint32_t> to_check_;         // half-edges that may need a flip
};

}  // namespace foldproof::inline internal
