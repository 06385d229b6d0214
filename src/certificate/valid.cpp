// The exact validation of a chart: short, apart from the code that builds charts, and applied to every chart.

#include <algorithm>

#include "certificate/chart_plane.h"

namespace foldproof::internal {
namespace {

using Corners = HalfEdgeSet::Corners;

constexpr std::int64_t kTwiceSquareArea = orient2d(kChartCorners[0], kChartCorners[1], kChartCorners[2]) +
                                          orient2d(kChartCorners[0], kChartCorners[2], kChartCorners[3]);

}  // namespace

bool chart_is_valid(const Patch& patch, const UvMap& uv_map, HalfEdgeSet& half_edges) {
  const auto& uvs = uv_map.uvs;
  const std::size_t first_corner = uvs.size(), count = first_corner + kChartCorners.size();
  if (first_corner != patch.vertices.size() || count > 0xFFFF) return false;
  const auto uv = [&](std::uint16_t i) {
    return i < first_corner ? uvs[i] : kChartCorners[i - first_corner];
  };
  const std::span<const Corners> groups[2] = {patch.triangles, uv_map.scaffold};
  std::int64_t total = 0;
  for (const auto group : groups) {
    for (const Corners& t : group) {
      if (std::max({t[0], t[1], t[2]}) >= count) return false;
      const std::int64_t twice_area = orient2d(uv(t[0]), uv(t[1]), uv(t[2]));
      if (twice_area <= 0) return false;
      total += twice_area;
    }
  }
  if (total != kTwiceSquareArea) return false;
  half_edges.assign(count, groups[0], groups[1]);
  for (const auto group : groups) {
    for (const Corners& t : group) {
      for (int k = 0; k < 3; ++k) {
        const std::uint16_t from = t[k], to = t[(k + 1) % 3];
        if (half_edges.contains(to, from)) continue;
        if (from < first_corner || to != first_corner + (from - first_corner + 1) % 4) return false;
      }
    }
  }
  return true;
}

bool chart_is_valid(const Patch& patch, const UvMap& uv_map) {
  HalfEdgeSet scratch;
  return chart_is_valid(patch, uv_map, scratch);
}

}  // namespace foldproof::internal
