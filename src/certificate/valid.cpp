// The exact check of a chart: small, on its own, and used on every chart whoever made it.

#include <algorithm>

#include "certificate/plane.h"

namespace foldproof {
namespace {

using Corners = std::array<std::uint16_t, 3>;

}  // namespace

bool chart_is_valid(const Patch& patch, const Drawing& drawing, DirectedEdges& edges) {
  const auto& places = drawing.places;
  const std::size_t corner = places.size(), count = corner + kChartCorners.size();
  if (corner != patch.vertices.size() || count > 0xFFFF) return false;
  const auto place = [&](std::uint16_t i) { return i < corner ? places[i] : kChartCorners[i - corner]; };
  edges.reset(3 * (patch.triangles.size() + drawing.fillers.size()));
  const std::span<const Corners> groups[2] = {patch.triangles, drawing.fillers};
  for (const auto group : groups) {
    for (const Corners& t : group) {
      if (std::max({t[0], t[1], t[2]}) >= count) return false;
      if (turn(place(t[0]), place(t[1]), place(t[2])) <= 0) return false;
      for (int k = 0; k < 3; ++k) {
        if (!edges.insert(t[k], t[(k + 1) % 3])) return false;
      }
    }
  }
  // What has no partner is the square, each side once.
  std::size_t alone = 0;
  for (const auto group : groups) {
    for (const Corners& t : group) {
      for (int k = 0; k < 3; ++k) {
        const std::uint16_t from = t[k], to = t[(k + 1) % 3];
        if (edges.contains(to, from)) continue;
        if (from < corner || to != corner + (from - corner + 1) % 4) return false;
        ++alone;
      }
    }
  }
  return alone == kChartCorners.size();
}

bool chart_is_valid(const Patch& patch, const Drawing& drawing) {
  DirectedEdges scratch;
  return chart_is_valid(patch, drawing, scratch);
}

}  // namespace foldproof
