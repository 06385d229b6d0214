/// Kinetic boxes: boxes whose sides slide linearly during a step, so that they hold linearly moving vertices
/// at every time (docs/soundness.md, Theorem 1). Single precision in a frame of the scene's own.
#pragma once

#include <limits>
#include <memory>
#include <vector>

#include "foldproof/bvh.h"

namespace foldproof {

/// Where single-precision coordinates live: y = (x - center) * scale, with every |y| <= 1 and scale a power
/// of two.
struct Frame {
  Vec3 center = Vec3::Zero();
  double scale = 1;
  friend bool operator==(const Frame& a, const Frame& b) {
    return a.center == b.center && a.scale == b.scale;
  }
};

/// The frame of what lies between two corners; finite ones, however far apart. It stands on a coarse grid, so
/// that a motion goes on in one frame for many steps.
Frame frame_around(const Vec3& low, const Vec3& high);
/// The frame of a pose: x y z of at least one vertex, finite.
Frame frame_around(std::span<const double> x);

/// A box around points; `finite`: no coordinate is infinite or NaN.
struct Bounds {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 high = -low;
  bool finite = true;
};

/// What lies around both.
inline Bounds around(const Bounds& a, const Bounds& b) {
  return {a.low.cwiseMin(b.low), a.high.cwiseMax(b.high), a.finite && b.finite};
}

/// Both ends of a vertex' step: x y z 0 at t=0, then x y z 0 at t=1.
struct alignas(32) MovingVertex {
  float x[8];
};

/// Per end of the step: the lower corner and the negated upper corner, each padded with 0. The union of two
/// boxes is then a minimum of sixteen floats, and a + swapped b > margin says that one side is apart.
struct alignas(64) KineticBox {
  float x[2][2][4];  // [end][lower, negated upper][axis]
};
static_assert(sizeof(KineticBox) == 16 * sizeof(float));  // boxes in a row are read as floats

/// A grid of bytes over the box of one leaf, at both ends of the step: a coordinate x has its place at
/// (x - origin) * scale. Laid out like MovingVertex.
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

/// Features of all leaves in blocks. A leaf's blocks are [begin[leaf], begin[leaf + 1]).
template <int N>
struct FeatureBlocks {
  std::vector<Index> begin;
  std::vector<IdBlock<N>> ids;
  std::vector<Index> first;         ///< Per block: its first feature in leaf order; lanes follow on.
  std::vector<std::uint32_t> used;  ///< Per block: bits of lanes that hold a feature.
  std::vector<BoxBlock> boxes;
};

/// Every vertex of each leaf's triangles, places in leaf order, ascending. A leaf's are [begin[leaf],
/// begin[leaf + 1]).
struct LeafVertexLists {
  std::vector<Index> begin, places;
};
LeafVertexLists list_leaf_vertices(const Hierarchy& hierarchy);

/// Every vertex of a leaf's triangles, owned by the leaf or not.
struct LeafVertices {
  std::span<const Index> vertices;
  Index node;
};

/// Everything about one object that changes with the step. Scratch: made once, refitted every step.
struct KineticTree {
  explicit KineticTree(std::shared_ptr<const Hierarchy> tree);
  KineticTree(KineticTree&&) = default;  // moving a vector keeps its elements' addresses
  KineticTree& operator=(KineticTree&&) = default;

  /// Reads both ends of the step; gives their bounds. Uses the caller's oneTBB arena, as fit does.
  Bounds move(const Frame& frame, std::span<const double> x0, std::span<const double> x1);
  /// The same for `steps` steps of which this is the first and all others go on as it does: `vertices` end
  /// where the last of them does. `reach` holds them all, and is finite where the ends of this one are.
  struct Ahead {
    Bounds step, reach;
  };
  Ahead move_ahead(const Frame& frame, std::span<const double> x0, std::span<const double> x1, double steps);
  /// How far the ends of a step lie from where `vertices` are at two times of their motion, 0 to 1: the most
  /// along any axis, in the frame, computed in single precision (docs/soundness.md, F1).
  struct Strayed {
    Bounds bounds;
    float most = 0;
  };
  Strayed stray(const Frame& frame, std::span<const double> x0, std::span<const double> x1,
                const float (&times)[2]) const;
  /// Refits all node boxes.
  void fit();
  void refit(const Frame& frame, std::span<const double> x0, std::span<const double> x1) {
    move(frame, x0, x1);
    fit();
  }
  /// The same for single vertices, places in leaf order, and leaves: for those who need few of them. A leaf's
  /// vertices come first, then its box, then its features.
  void move_vertex(const Frame& frame, Index place, const double* x0, const double* x1);
  void fit_leaf(Index leaf);
  /// Fills the feature boxes of one leaf. Different leaves may be filled by different threads.
  void fill_features(Index leaf);
  Index leaf_node(Index leaf) const { return leaves_[leaf].node; }
  /// Every vertex of a leaf's triangles, in leaf order.
  std::span<const Index> leaf_vertices(Index leaf) const { return leaves_[leaf].vertices; }

  std::shared_ptr<const Hierarchy> hierarchy;
  std::vector<MovingVertex> vertices;  ///< Leaf order.
  std::vector<KineticBox> boxes;       ///< One per node.
  std::vector<LeafGrid> grids;         ///< One per leaf, filled with its features.
  FeatureBlocks<1> vertex_blocks;
  FeatureBlocks<2> edge_blocks;
  FeatureBlocks<3> face_blocks;

 private:
  void find_leaves();
  std::vector<Index> leaf_vertex_ids_;
  std::vector<LeafVertices> leaves_;  // spans into leaf_vertex_ids_
  std::vector<Index> subtrees_;       // roots of pieces of the tree, each refitted by one thread
  std::vector<Index> above_;          // the nodes above these, parents first
};

/// Two floats in the frame whose difference exceeds this belong to coordinates that differ by more than
/// `distance` mesh units: covers the rounding into single precision and that of the difference
/// (docs/soundness.md, B2).
float separation_margin(const Frame& frame, double distance);

}  // namespace foldproof
