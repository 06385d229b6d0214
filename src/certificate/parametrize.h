/// Certificates: proofs that a patch of surface does not touch itself.
///
/// A *chart* parametrizes a patch over a square in the plane. The patch's triangles do not overlap there, and
/// *scaffold triangles*, which are not part of the mesh, fill the rest of the square. The segment between any
/// two points of the square stays inside it. As long as every triangle maps such segments forward, no two
/// points of the patch can meet. Each triangle is tested on its own (docs/soundness.md, Theorem 2).
#pragma once

#include "certificate/patch.h"

namespace foldproof::inline internal {

/// Coordinates in the plane of a chart. Integers, so that a chart can be checked exactly.
using Uv = std::array<std::int16_t, 2>;

/// The corners of the square around every chart, counterclockwise.
inline constexpr std::array<Uv, 4> kChartCorners{
    {{32000, 32000}, {-32000, 32000}, {-32000, -32000}, {32000, -32000}}};

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

}  // namespace foldproof::inline internal
