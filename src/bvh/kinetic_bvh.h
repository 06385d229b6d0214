/// Kinetic boxes: their sides move linearly during a step, so they bound linearly moving vertices at every
/// time (docs/soundness.md, Theorem 1). Single precision, in a frame fitted to the scene.
#pragma once

#include <limits>
#include <memory>
#include <vector>

#include "bvh/subtrees.h"

namespace foldproof::inline internal {

/// The coordinate frame of single-precision numbers: y = (x - center) * scale, with every |y| <= 1 and scale
/// a power of two.
struct Frame {
  Vec3 center = Vec3::Zero();
  double scale = 1;
  friend bool operator==(const Frame& a, const Frame& b) {
    return a.center == b.center && a.scale == b.scale;
  }
};

/// The frame of the box between two finite corners. Snapped to a coarse grid, so that a motion keeps one
/// frame for many steps.
Frame frame_around(const Vec3& low, const Vec3& high);
/// The frame of a pose: x y z of at least one vertex, finite.
Frame frame_around(std::span<const double> x);

/// The bounding box of points; `finite`: no coordinate is infinite or NaN.
struct Bounds {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 high = -low;
  bool finite = true;
};

inline Bounds united(const Bounds& a, const Bounds& b) {
  return {a.low.cwiseMin(b.low), a.high.cwiseMax(b.high), a.finite && b.finite};
}

/// Vertices by their ids, and the positions of all vertices at both ends of the step.
struct VerticesAtEnds {
  std::span<const Index> ids;
  std::span<const double> x0, x1;
};

/// A vertex at both ends of the step: x y z 0 at t=0, then x y z 0 at t=1.
struct alignas(32) MovingVertex {
  float x[8];
};

/// Per end of the step: the lower corner and the negated upper corner, each padded with 0. So the union of
/// two boxes is a minimum of sixteen floats, and two sides are separated where a + swapped b > margin.
struct alignas(64) KineticBox {
  float x[2][2][4];  // [end][lower, negated upper][axis]
};
static_assert(sizeof(KineticBox) == 16 * sizeof(float));  // arrays of boxes are read as floats

/// A grid of 256 cells per axis over the box of one leaf, at both ends of the step: a coordinate x lies in
/// cell (x - origin) * scale. Laid out like MovingVertex.
struct alignas(32) LeafGrid {
  float origin[8], scale[8];
};

/// Features per block.
inline constexpr Index kBlock = 32;

/// Boxes of the features of a block, one per lane, on their leaf's grid (docs/soundness.md, B4).
struct alignas(32) BoxBlock {
  std::uint8_t x[2][2][3][kBlock];  // [lower, upper][end][axis][lane]
};

/// Vertices of the features of a block, in leaf order; empty lanes repeat the first.
template <int N>
struct alignas(32) IdBlock {
  Index v[N][kBlock];
};

/// Features of all leaves in blocks. The blocks of a leaf are [begin[leaf], begin[leaf + 1]).
template <int N>
struct FeatureBlocks {
  std::vector<Index> begin;
  std::vector<IdBlock<N>> ids;
  std::vector<Index> first;         ///< Per block: the feature in lane 0; the next lanes have the next ones.
  std::vector<std::uint32_t> used;  ///< Per block: bits of the lanes that have a feature.
  std::vector<BoxBlock> boxes;
};

/// Every vertex of each leaf's triangles, as indices in leaf order, ascending. Those of a leaf are
/// [begin[leaf], begin[leaf + 1]).
struct LeafVertexLists {
  std::vector<Index> begin, vertices;
};
LeafVertexLists list_leaf_vertices(const Hierarchy& hierarchy);

/// Every vertex of a leaf's triangles, owned by the leaf or not.
struct LeafVertices {
  std::span<const Index> vertices;
  NodeIndex node;
};

/// A bounding volume hierarchy of kinetic boxes over one object. Made once, refitted every step.
struct KineticBvh {
  explicit KineticBvh(std::shared_ptr<const Hierarchy> tree);
  KineticBvh(KineticBvh&&) = default;  // moving a vector keeps its elements' addresses
  KineticBvh& operator=(KineticBvh&&) = default;

  /// Reads both ends of the step; returns their bounds. Uses the caller's oneTBB arena, as refit_boxes does.
  Bounds set_positions(const Frame& frame, std::span<const double> x0, std::span<const double> x1);
  /// The same for a motion of `steps` steps that extrapolates this one in straight lines: `vertices` end
  /// where the last step does. `finite` only describes the first step; the others may overflow.
  struct ExtrapolatedBounds {
    Bounds first_step, all_steps;
  };
  ExtrapolatedBounds set_extrapolated_positions(const Frame& frame, std::span<const double> x0,
                                                std::span<const double> x1, double steps);
  /// Distance of a step's ends from where `vertices` are at two times of their motion, in [0,1]: the maximum
  /// along any axis, in the frame, computed in single precision (docs/soundness.md, F1). Returns the bounds
  /// of the step as well.
  struct Deviation {
    Bounds bounds;
    float max = 0;
  };
  Deviation deviation(const Frame& frame, std::span<const double> x0, std::span<const double> x1,
                      const float (&times)[2]) const;
  /// Refits all node boxes.
  void refit_boxes();
  void refit(const Frame& frame, std::span<const double> x0, std::span<const double> x1) {
    set_positions(frame, x0, x1);
    refit_boxes();
  }
  /// The same for a single vertex, an index in leaf order, and a single leaf. Set a leaf's vertices first,
  /// then refit its box, then fill its features.
  void set_vertex(const Frame& frame, Index vertex, const double* x0, const double* x1);
  void refit_leaf(LeafIndex leaf);
  /// Fills the feature boxes of one leaf. Threads may fill different leaves concurrently.
  void fill_features(LeafIndex leaf);
  NodeIndex leaf_node(LeafIndex leaf) const { return leaves_[leaf].node; }
  /// Every vertex of a leaf's triangles, in leaf order.
  std::span<const Index> leaf_vertices(LeafIndex leaf) const { return leaves_[leaf].vertices; }

  std::shared_ptr<const Hierarchy> hierarchy;
  std::vector<MovingVertex> vertices;  ///< Leaf order.
  std::vector<KineticBox> boxes;       ///< One per node.
  std::vector<LeafGrid> grids;         ///< One per leaf, filled with its features.
  FeatureBlocks<1> vertex_blocks;
  FeatureBlocks<2> edge_blocks;
  FeatureBlocks<3> face_blocks;
  bool has_thin_faces = false;  ///< Faces that name a vertex twice.

 private:
  void find_leaves();
  std::vector<Index> leaf_vertex_ids_;
  std::vector<LeafVertices> leaves_;  // spans into leaf_vertex_ids_
  Subtrees subtrees_;                 // each is refitted by one task
};

/// Coordinates differ by more than `distance` mesh units when their floats in the frame differ by more than
/// this. Covers the rounding to single precision and that of the difference (docs/soundness.md, B2).
float separation_margin(const Frame& frame, double distance);

}  // namespace foldproof::inline internal
