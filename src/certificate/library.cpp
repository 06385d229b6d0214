#include <algorithm>

#include "certificate/chart_holds.h"

namespace foldproof {
namespace {

// Sets the size of a range. One that outgrows its capacity moves to the end of the array, with spare capacity
// so that a chart that is replaced again and again soon stays in place.
template <class T>
void resize(std::vector<T>& all, ChartLibrary::Range& range, std::size_t count) {
  if (count > range.capacity) {
    range.begin = all.size();
    range.capacity = static_cast<Index>(range.capacity == 0 ? count : count + count / 2);
    all.resize(all.size() + range.capacity);
  }
  range.count = static_cast<Index>(count);
}

}  // namespace

ChartLibrary::ChartLibrary(std::shared_ptr<const PatchSlots> slots)
    : slots_(std::move(slots)), first_(slots_->count(), kNoIndex) {}

void ChartLibrary::add(Index slot, Index source, const Patch& patch, std::span<const Index> ring,
                       const UvMap& uv_map) {
  fill(place(slot, source, kNoIndex, patch, ring, uv_map), patch, ring, uv_map);
}

void ChartLibrary::replace(Index chart, Index source, const Patch& patch, std::span<const Index> ring,
                           const UvMap& uv_map) {
  fill(place(charts_[chart].slot, source, chart, patch, ring, uv_map), patch, ring, uv_map);
}

Index ChartLibrary::place(Index slot, Index source, Index old, const Patch& patch,
                          std::span<const Index> ring, const UvMap& uv_map) {
  Chart chart;
  if (old != kNoIndex) {
    chart = charts_[old];
  } else {
    chart.slot = slot;
    chart.next = first_[slot];
  }
  chart.source = source;
  resize(vertices_, chart.vertices, patch.vertices.size());
  resize(rings_, chart.ring, ring.size());
  resize(triangles_, chart.triangles, patch.triangles.size() + uv_map.scaffold.size());
  resize(points_, chart.points, uv_map.uvs.size() + kChartCorners.size());
  weights_.resize(triangles_.size());
  if (old != kNoIndex) {
    charts_[old] = chart;
    return old;
  }
  charts_.push_back(chart);
  return first_[slot] = static_cast<Index>(charts_.size() - 1);
}

void ChartLibrary::fill(Index index, const Patch& patch, std::span<const Index> ring, const UvMap& uv_map) {
  Chart& chart = charts_[index];
  std::copy(patch.vertices.begin(), patch.vertices.end(), vertices_.begin() + chart.vertices.begin);
  std::copy(ring.begin(), ring.end(), rings_.begin() + chart.ring.begin);
  const auto scaffold =
      std::copy(patch.triangles.begin(), patch.triangles.end(), triangles_.begin() + chart.triangles.begin);
  std::copy(uv_map.scaffold.begin(), uv_map.scaffold.end(), scaffold);
  auto* point = points_.data() + chart.points.begin;
  const auto real = [](std::int16_t c) { return static_cast<float>(c); };
  for (std::size_t i = 0; i < uv_map.uvs.size(); ++i) {
    *point++ = {real(uv_map.uvs[i][0]), real(uv_map.uvs[i][1]), real(uv_map.heights[i])};
  }
  for (const Uv corner : kChartCorners) *point++ = {real(corner[0]), real(corner[1]), 0};
  chart.fit = fit_of(points(chart), triangles(chart));
  std::transform(triangles(chart).begin(), triangles(chart).end(), weights_.begin() + chart.triangles.begin,
                 [&](const auto& t) { return weight_of(points(chart), t); });
}

}  // namespace foldproof
