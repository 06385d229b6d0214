#include "certificate/chart_plane.h"

namespace foldproof::internal {

void HalfEdgeSet::assign(std::size_t vertices, std::span<const Corners> group,
                         std::span<const Corners> more) {
  end_.assign(vertices + 1, 0);
  for (const auto triangles : {group, more}) {
    for (const Corners& t : triangles) {
      for (const std::uint16_t v : t) ++end_[v];
    }
  }
  begin_.resize(vertices + 1);
  std::uint32_t all = 0;
  for (std::size_t v = 0; v <= vertices; ++v) {
    begin_[v] = all;
    all += (end_[v] + kBlock - 1) / kBlock * kBlock;
    end_[v] = begin_[v];
  }
  to_.assign(all, 0xFFFF);
  for (const auto triangles : {group, more}) {
    for (const Corners& t : triangles) {
      to_[end_[t[0]]++] = t[1];
      to_[end_[t[1]]++] = t[2];
      to_[end_[t[2]]++] = t[0];
    }
  }
}

}  // namespace foldproof::internal
