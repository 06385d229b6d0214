// The exact check of a chart: small, on its own, and used on every chart whoever made it.

#include <algorithm>

#include "certificate/plane.h"

namespace foldproof {
namespace {

using Corners = DirectedSides::Corners;

constexpr std::int64_t kTwiceSquare = turn(kChartCorners[0], kChartCorners[1], kChartCorners[2]) +
                                      turn(kChartCorners[0], kChartCorners[2], kChartCorners[3]);

}  // namespace

bool chart_is_valid(const Patch& patch, const Drawing& drawing, DirectedSides& sides) {
  const auto& places = drawing.places;
  const std::size_t corner = places.size(), count = corner + kChartCorners.size();
  if (corner != patch.vertices.size() || count > 0xFFFF) return false;
  const auto place = [&](std::uint16_t i) { return i < corner ? places[i] : kChartCorners[i - corner]; };
  const std::span<const Corners> groups[2] = {patch.triangles, drawing.fillers};
  std::int64_t area = 0;
  for (const auto group : groups) {
    for (const Corners& t : group) {
      if (std::max({t[0], t[1], t[2]}) >= count) return false;
      const std::int64_t twice = turn(place(t[0]), place(t[1]), place(t[2]));
      if (twice <= 0) return false;
      area += twice;
    }
  }
  if (area != kTwiceSquare) return false;
  sides.list(count, groups[0], groups[1]);
  for (const auto group : groups) {
    for (const Corners& t : group) {
      for (int k = 0; k < 3; ++k) {
        const std::uint16_t from = t[k], to = t[(k + 1) % 3];
        if (sides.contains(to, from)) continue;
        if (from < corner || to != corner + (from - corner + 1) % 4) return false;
      }
    }
  }
  return true;
}

bool chart_is_valid(const Patch& patch, const Drawing& drawing) {
  DirectedSides scratch;
  return chart_is_valid(patch, drawing, scratch);
}

}  // namespace foldproof
