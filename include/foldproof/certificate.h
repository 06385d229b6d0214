/// Certificates: proofs that nothing inside a patch of surface touches anything else inside it.
///
/// A *chart* draws a patch in the plane: its triangles without overlap, and around them a square whose rest
/// is filled up with triangles of no substance. In such a picture every two points are joined by a straight
/// line that stays inside, and as long as every triangle stretches that line forward, no two points of the
/// patch can meet. Whether they do is a test on each triangle alone (docs/soundness.md, Theorem 2).
#pragma once

#include <cstdint>
#include <memory>

#include "foldproof/bvh.h"

namespace foldproof {

/// A place in the picture. Integers, so that everything about a chart can be checked exactly.
using Place = std::array<std::int16_t, 2>;

/// The corners of the square around every chart, counterclockwise.
inline constexpr std::array<Place, 4> kChartCorners{
    {{32000, 32000}, {-32000, 32000}, {-32000, -32000}, {32000, -32000}}};

/// A patch with vertices of its own numbering.
struct Patch {
  std::vector<Index> vertices;                          ///< In the hierarchy's leaf order.
  std::vector<std::array<std::uint16_t, 3>> triangles;  ///< By number in `vertices`.
};

/// How a patch is drawn.
struct Drawing {
  std::vector<Place> places;          ///< One per vertex of the patch.
  std::vector<std::int16_t> heights;  ///< Above the plane, in the same unit; a hint, any will do.
  /// Triangles that fill the rest of the square; numbers from that of places on are the square's corners.
  std::vector<std::array<std::uint16_t, 3>> fillers;
};

/// Why a patch has no chart in some pose.
enum class ChartOutcome : std::uint8_t {
  Made,
  TooLarge,   ///< More vertices than a chart can number.
  TooCurved,  ///< No plane that all triangles face: the patch bends by half a turn or more, or has a triangle
              ///< without area.
  Tangled,    ///< Drawn in the plane, the patch overlaps itself or is in several pieces.
};

/// Draws patches as they look from the side that most of them faces. Scratch: one per thread.
class ChartMaker {
 public:
  ChartMaker();
  ~ChartMaker();
  ChartMaker(ChartMaker&&) noexcept;

  /// A direction that all triangles face, as squarely as may be; zero when there is none. `positions`: of the
  /// patch' vertices, any unit.
  Eigen::Vector3f facing(const Patch& patch, std::span<const std::array<float, 3>> positions);
  /// Whether a triangle faces a direction squarely enough to be drawn along it.
  static bool faces(const Eigen::Vector3f& direction, const Eigen::Vector3f (&corners)[3]);
  /// Draws the patch as it looks along `facing`. What is Made has been checked by chart_is_valid.
  ChartOutcome draw(const Patch& patch, std::span<const std::array<float, 3>> positions,
                    const Eigen::Vector3f& facing, Drawing& out);

 private:
  struct Scratch;
  std::unique_ptr<Scratch> scratch_;
};

/// Whether a drawing covers the square once, with all triangles of the patch and the fillers turned the same
/// way. Exact. This is all that Theorem 2 asks of a chart, wherever it came from.
bool chart_is_valid(const Patch& patch, const Drawing& drawing);

/// Numbers the patches of a hierarchy that may have charts: the leaves below each node, and every two leaves
/// that have a vertex in common. Immutable.
class PatchSlots {
 public:
  explicit PatchSlots(std::shared_ptr<const Hierarchy> hierarchy);

  const std::shared_ptr<const Hierarchy>& hierarchy() const { return hierarchy_; }
  Index count() const { return node_count() + static_cast<Index>(neighbour_.size()); }
  Index of_node(Index node) const { return node; }
  /// kNoIndex when the leaves are the same or have no vertex in common.
  Index of_leaves(Index leaf_a, Index leaf_b) const;
  bool is_pair(Index slot) const { return slot >= node_count(); }
  std::array<Index, 2> leaves_of(Index pair_slot) const {
    return {row_[pair_slot - node_count()], neighbour_[pair_slot - node_count()]};
  }
  /// Leaves with a vertex in common with this one, ascending.
  std::span<const Index> neighbours(Index leaf) const {
    return std::span(neighbour_).subspan(begin_[leaf], begin_[leaf + 1] - begin_[leaf]);
  }
  Index triangles_of(Index slot) const;  ///< How many.

 private:
  Index node_count() const { return static_cast<Index>(hierarchy_->nodes().size()); }
  std::shared_ptr<const Hierarchy> hierarchy_;
  std::vector<Index> begin_, neighbour_;
  std::vector<Index> row_;  // per entry of neighbour_: whose neighbour it is
};

/// Reads patches. Scratch: one per thread.
class PatchReader {
 public:
  explicit PatchReader(const PatchSlots& slots);
  /// The patch of a slot.
  void read(Index slot, Patch& out);
  /// Adds a leaf to the patch that was read last.
  void add_leaf(Index leaf, Patch& out);

 private:
  void add_leaves(Index begin, Index end, Patch& out);
  const PatchSlots& slots_;
  std::vector<std::uint16_t> number_;  // per vertex; means something only where owner_ is the current patch
  std::vector<std::uint32_t> owner_;
  std::uint32_t patch_ = 0;
};

/// Charts by slot; a slot may have several, from different poses. A node's chart may show more than its own
/// leaves: its collar is a choice of leaves that have a vertex in common with them.
class ChartLibrary {
 public:
  explicit ChartLibrary(std::shared_ptr<const PatchSlots> slots);

  /// What a test needs to know about a drawing.
  struct Fit {
    float least_altitude =
        0;  ///< Of all triangles, rounded down: features without a common vertex are this far apart.
    float mean[3] = {};  ///< Of places and heights.
    float flat[3] = {};  ///< xx, xy, yy of the inverse of the places' second moments about their mean.
    float solid[6] =
        {};  ///< xx, xy, xz, yy, yz, zz of the same with heights, whose own moment has `ridge` added.
    float ridge = 0;
  };
  /// A run of entries in one of the library's arrays, with room for more.
  struct Run {
    Index begin = 0, count = 0, room = 0;
  };
  struct Chart {
    Index next = kNoIndex;  ///< The slot's next chart.
    Index slot = 0;
    Index source = 0;  ///< Where it was drawn: a pose' number, for those who ask.
    Run vertices, points, triangles, collar;
    Fit fit;
  };

  /// Adds a valid drawing (see chart_is_valid) of the slot's patch with a collar, as the slot's first chart.
  void add(Index slot, Index source, const Patch& patch, std::span<const Index> collar,
           const Drawing& drawing);
  /// Puts another drawing of the same slot in a chart's place.
  void replace(Index chart, Index source, const Patch& patch, std::span<const Index> collar,
               const Drawing& drawing);

  const std::shared_ptr<const PatchSlots>& slots() const { return slots_; }
  std::span<const Chart> charts() const { return charts_; }
  Index first(Index slot) const { return first_[slot]; }

  std::span<const Index> vertices(const Chart& c) const { return part(vertices_, c.vertices); }
  /// Places and heights, those of the square's corners behind those of the vertices.
  std::span<const std::array<float, 3>> points(const Chart& c) const { return part(points_, c.points); }
  /// Of the patch, then fillers.
  std::span<const std::array<std::uint16_t, 3>> triangles(const Chart& c) const {
    return part(triangles_, c.triangles);
  }
  /// Of the triangles; see weight_of in src/certificate/chart_test.h.
  std::span<const float> weights(const Chart& c) const { return part(weights_, c.triangles); }
  std::span<const Index> collar(const Chart& c) const { return part(collars_, c.collar); }

 private:
  template <class T>
  static std::span<const T> part(const std::vector<T>& all, Run run) {
    return std::span(all).subspan(run.begin, run.count);
  }
  void fill(Chart& chart, const Patch& patch, std::span<const Index> collar, const Drawing& drawing);

  std::shared_ptr<const PatchSlots> slots_;
  std::vector<Index> first_;
  std::vector<Chart> charts_;
  std::vector<Index> vertices_, collars_;
  std::vector<std::array<float, 3>> points_;
  std::vector<std::array<std::uint16_t, 3>> triangles_;
  std::vector<float> weights_;  // as triangles_
};

}  // namespace foldproof
