/// Where charts are kept.
#pragma once

#include "certificate/parametrize.h"

namespace foldproof {

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
