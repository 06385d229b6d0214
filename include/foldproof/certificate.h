/// Certificates: proofs that a patch of surface does not touch itself.
///
/// A *chart* parametrizes a patch over a square in the plane. The patch's triangles do not overlap there, and
/// *scaffold triangles*, which are not part of the mesh, fill the rest of the square. The segment between any
/// two points of the square stays inside it. As long as every triangle maps such segments forward, no two
/// points of the patch can meet. Each triangle is tested on its own (docs/soundness.md, Theorem 2).
#pragma once

#include <cstdint>
#include <memory>

#include "foldproof/bvh.h"

namespace foldproof {

/// Coordinates in the plane of a chart. Integers, so that a chart can be checked exactly.
using Uv = std::array<std::int16_t, 2>;

/// The corners of the square around every chart, counterclockwise.
inline constexpr std::array<Uv, 4> kChartCorners{
    {{32000, 32000}, {-32000, 32000}, {-32000, -32000}, {32000, -32000}}};

/// Some triangles of a mesh, with local vertex numbers.
struct Patch {
  std::vector<Index> vertices;                          ///< Numbers in the hierarchy's leaf order.
  std::vector<std::array<std::uint16_t, 3>> triangles;  ///< Indices into `vertices`.
};

/// A parametrization of a patch.
struct UvMap {
  std::vector<Uv> uvs;                ///< One per vertex of the patch.
  std::vector<std::int16_t> heights;  ///< Above the plane, in the same unit. A hint: any value is valid.
  /// Triangles that fill the rest of the square. Vertex numbers from uvs.size() on are the square's corners.
  std::vector<std::array<std::uint16_t, 3>> scaffold;
};

/// Why a patch has no chart in some pose.
enum class ChartOutcome : std::uint8_t {
  Made,
  TooLarge,  ///< More vertices than a chart can number.
  /// No plane that all triangles face: the patch bends by half a turn or more, or a triangle has no area.
  TooCurved,
  Overlapping,  ///< Projected to the plane, the patch overlaps itself or is in several pieces.
};

/// Parametrizes patches by projection to a plane that all their triangles face. Scratch: one per thread.
class Parametrizer {
 public:
  Parametrizer();
  ~Parametrizer();
  Parametrizer(Parametrizer&&) noexcept;

  /// A unit vector that every triangle faces, to project along; zero where none is found. `positions`: one
  /// per vertex of the patch, in any unit.
  Vec3 facing(const Patch& patch, std::span<const std::array<float, 3>> positions);
  /// Whether a triangle's normal is close enough to a direction for a projection along it.
  static bool faces(const Vec3& direction, const std::array<std::array<float, 3>, 3>& corners);
  /// Projects the patch along `facing` and adds the scaffold. Where it returns Made, chart_is_valid is true.
  ChartOutcome build(const Patch& patch, std::span<const std::array<float, 3>> positions, const Vec3& facing,
                     UvMap& out);

 private:
  struct Scratch;
  std::unique_ptr<Scratch> scratch_;
};

/// Whether the triangles of the patch and of the scaffold cover the square once, all counterclockwise. Exact.
/// This is all that Theorem 2 requires of a chart, wherever it came from.
bool chart_is_valid(const Patch& patch, const UvMap& uv_map);

/// Numbers the patches of a hierarchy that may have charts: the leaves below each node, and each two leaves
/// with a common vertex. Vertices at which more than kMaxLeavesAtVertex leaves meet do not count, or there
/// would be quadratically many. Immutable.
class PatchSlots {
 public:
  static constexpr Index kMaxLeavesAtVertex = 256;
  explicit PatchSlots(std::shared_ptr<const Hierarchy> hierarchy);

  const std::shared_ptr<const Hierarchy>& hierarchy() const { return hierarchy_; }
  Index count() const { return node_count() + static_cast<Index>(neighbor_.size()); }
  Index of_node(Index node) const { return node; }
  /// kNoIndex for equal leaves and for leaves without a common vertex that counts.
  Index of_leaves(Index leaf_a, Index leaf_b) const;
  bool is_pair(Index slot) const { return slot >= node_count(); }
  std::array<Index, 2> leaves_of(Index pair_slot) const {
    return {leaf_[pair_slot - node_count()], neighbor_[pair_slot - node_count()]};
  }
  /// Leaves with a vertex of this one that counts, ascending.
  std::span<const Index> neighbors(Index leaf) const {
    return std::span(neighbor_).subspan(begin_[leaf], begin_[leaf + 1] - begin_[leaf]);
  }
  Index triangle_count(Index slot) const;

 private:
  Index node_count() const { return static_cast<Index>(hierarchy_->nodes().size()); }
  std::shared_ptr<const Hierarchy> hierarchy_;
  std::vector<Index> begin_, neighbor_;  // per leaf, its neighbors
  std::vector<Index> leaf_;              // per entry of neighbor_: the leaf it is a neighbor of
};

/// Reads patches. Scratch: one per thread.
class PatchReader {
 public:
  explicit PatchReader(const PatchSlots& slots);
  /// Replaces `out` by the patch of a slot.
  void read(Index slot, Patch& out);
  /// Adds a leaf to the patch of the last read().
  void add_leaf(Index leaf, Patch& out);

 private:
  void add_leaves(Index begin, Index end, Patch& out);
  const PatchSlots& slots_;
  // Per vertex: its number in the patch that read it last, and which patch that was.
  std::vector<std::uint16_t> local_number_;
  std::vector<std::uint32_t> last_patch_;
  std::uint32_t patch_ = 0;
};

/// Charts by slot. A slot may have several, from different poses. A node's chart may cover a *ring*: some of
/// the leaves that have a vertex in common with the node's own.
class ChartLibrary {
 public:
  explicit ChartLibrary(std::shared_ptr<const PatchSlots> slots);

  /// What chart_holds needs to know about a parametrization.
  struct Fit {
    /// The smallest altitude of a triangle, rounded down. Features without a common vertex are at least this
    /// far apart in the plane.
    float min_altitude = 0;
    float mean[3] = {};  ///< Of uvs and heights.
    /// xx, xy, yy of the inverse of the uvs' second moments about their mean.
    float inverse_moments_2d[3] = {};
    /// xx, xy, xz, yy, yz, zz of the same with heights, whose own moment is enlarged by `ridge`.
    float inverse_moments_3d[6] = {};
    float ridge = 0;
  };
  /// A range of entries in one of the library's arrays.
  struct Range {
    std::size_t begin = 0;
    Index count = 0, capacity = 0;
  };
  struct Chart {
    Index next = kNoIndex;  ///< The slot's next chart.
    Index slot = 0;
    Index source = 0;  ///< The caller's number of the pose or step that it was built in.
    Range vertices, points, triangles, ring;
    Fit fit;
  };

  /// Adds a chart of the slot's patch and a ring, as the slot's first. Precondition: chart_is_valid.
  void add(Index slot, Index source, const Patch& patch, std::span<const Index> ring, const UvMap& uv_map);
  /// Replaces a chart by another of the same slot.
  void replace(Index chart, Index source, const Patch& patch, std::span<const Index> ring,
               const UvMap& uv_map);
  /// Both in two parts. place() makes room for a chart, in the place of `old` unless that is kNoIndex, and
  /// returns its index; fill() sets its contents. Threads may fill different charts at once.
  Index place(Index slot, Index source, Index old, const Patch& patch, std::span<const Index> ring,
              const UvMap& uv_map);
  void fill(Index chart, const Patch& patch, std::span<const Index> ring, const UvMap& uv_map);

  const std::shared_ptr<const PatchSlots>& slots() const { return slots_; }
  std::span<const Chart> charts() const { return charts_; }
  Index first(Index slot) const { return first_[slot]; }

  std::span<const Index> vertices(const Chart& c) const { return part(vertices_, c.vertices); }
  /// Uv coordinates and heights of the vertices, then of the square's corners.
  std::span<const std::array<float, 3>> points(const Chart& c) const { return part(points_, c.points); }
  /// Of the patch, then of the scaffold.
  std::span<const std::array<std::uint16_t, 3>> triangles(const Chart& c) const {
    return part(triangles_, c.triangles);
  }
  /// Per triangle; see weight_of in src/certificate/chart_holds.h.
  std::span<const float> weights(const Chart& c) const { return part(weights_, c.triangles); }
  std::span<const Index> ring(const Chart& c) const { return part(rings_, c.ring); }

 private:
  template <class T>
  static std::span<const T> part(const std::vector<T>& all, Range range) {
    return std::span(all).subspan(range.begin, range.count);
  }

  std::shared_ptr<const PatchSlots> slots_;
  std::vector<Index> first_;
  std::vector<Chart> charts_;
  std::vector<Index> vertices_, rings_;
  std::vector<std::array<float, 3>> points_;
  std::vector<std::array<std::uint16_t, 3>> triangles_;
  std::vector<float> weights_;  // parallel to triangles_
};

}  // namespace foldproof
