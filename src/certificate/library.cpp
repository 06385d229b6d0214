#include <algorithm>

#include "certificate/chart_holds.h"

namespace foldproof {
namespace {

// Sets the size of a range. One that outgrows its capacity moves to the end of the array, with spare capacity
// so that a chart that is replaced again and again soon stays in place.
template <class T>
T* resize(std::vector<T>& all, ChartLibrary::Range& range, std::size_t count) {
  if (count > range.capacity) {
    range.begin = static_cast<Index>(all.size());
    range.capacity = static_cast<Index>(range.capacity == 0 ? count : count + count / 2);
    all.resize(all.size() + range.capacity);
  }
  range.count = static_cast<Index>(count);
  return all.data() + range.begin;
}

}  // namespace

ChartLibrary::ChartLibrary(std::shared_ptr<const PatchSlots> slots)
    : slots_(std::move(slots)), first_(slots_->count(), kNoIndex) {}

void ChartLibrary::add(Index slot, Index source, const Patch& patch, std::span<const Index> ring,
                       const UvMap& uv_map) {
  Chart chart;
  chart.slot = slot;
  chart.source = source;
  chart.next = first_[slot];
  fill(chart, patch, ring, uv_map);
  first_[slot] = static_cast<Index>(charts_.size());
  charts_.push_back(chart);
}

void ChartLibrary::replace(Index chart, Index source, const Patch& patch, std::span<const Index> ring,
                           const UvMap& uv_map) {
  charts_[chart].source = source;
  fill(charts_[chart], patch, ring, uv_map);
}

void ChartLibrary::fill(Chart& chart, const Patch& patch, std::span<const Index> ring, const UvMap& uv_map) {
  std::copy(patch.vertices.begin(), patch.vertices.end(),
            resize(vertices_, chart.vertices, patch.vertices.size()));
  std::copy(ring.begin(), ring.end(), resize(rings_, chart.ring, ring.size()));
  auto* triangle = resize(triangles_, chart.triangles, patch.triangles.size() + uv_map.scaffold.size());
  triangle = std::copy(patch.triangles.begin(), patch.triangles.end(), triangle);
  std::copy(uv_map.scaffold.begin(), uv_map.scaffold.end(), triangle);
  auto* point = resize(points_, chart.points, uv_map.uvs.size() + kChartCorners.size());
  const auto real = [](std::int16_t c) { return static_cast<float>(c); };
  for (std::size_t i = 0; i < uv_map.uvs.size(); ++i) {
    *point++ = {real(uv_map.uvs[i][0]), real(uv_map.uvs[i][1]), real(uv_map.heights[i])};
  }
  for (const Uv corner : kChartCorners) *point++ = {real(corner[0]), real(corner[1]), 0};
  chart.fit = fit_of(points(chart), triangles(chart));
  weights_.resize(triangles_.size());
  std::transform(triangles(chart).begin(), triangles(chart).end(), weights_.begin() + chart.triangles.begin,
                 [&](const auto& t) { return weight_of(points(chart), t); });
}

}  // namespace foldproof
