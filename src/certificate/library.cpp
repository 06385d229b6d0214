#include <algorithm>

#include "certificate/chart_test.h"

namespace foldproof {
namespace {

// Makes room for `count` entries: where the run is when they fit, else behind everything else, with some to
// spare, so that a chart that is drawn again and again soon stays where it is.
template <class T>
T* make_room(std::vector<T>& all, ChartLibrary::Run& run, std::size_t count) {
  if (count > run.room) {
    run.begin = static_cast<Index>(all.size());
    run.room = static_cast<Index>(run.room == 0 ? count : count + count / 2);
    all.resize(all.size() + run.room);
  }
  run.count = static_cast<Index>(count);
  return all.data() + run.begin;
}

}  // namespace

ChartLibrary::ChartLibrary(std::shared_ptr<const PatchSlots> slots)
    : slots_(std::move(slots)), first_(slots_->count(), kNoIndex) {}

void ChartLibrary::add(Index slot, Index source, const Patch& patch, std::span<const Index> collar,
                       const Drawing& drawing) {
  Chart chart;
  chart.slot = slot;
  chart.source = source;
  chart.next = first_[slot];
  fill(chart, patch, collar, drawing);
  first_[slot] = static_cast<Index>(charts_.size());
  charts_.push_back(chart);
}

void ChartLibrary::replace(Index chart, Index source, const Patch& patch, std::span<const Index> collar,
                           const Drawing& drawing) {
  charts_[chart].source = source;
  fill(charts_[chart], patch, collar, drawing);
}

void ChartLibrary::fill(Chart& chart, const Patch& patch, std::span<const Index> collar,
                        const Drawing& drawing) {
  std::copy(patch.vertices.begin(), patch.vertices.end(),
            make_room(vertices_, chart.vertices, patch.vertices.size()));
  std::copy(collar.begin(), collar.end(), make_room(collars_, chart.collar, collar.size()));
  auto* triangle = make_room(triangles_, chart.triangles, patch.triangles.size() + drawing.fillers.size());
  triangle = std::copy(patch.triangles.begin(), patch.triangles.end(), triangle);
  std::copy(drawing.fillers.begin(), drawing.fillers.end(), triangle);
  auto* point = make_room(points_, chart.points, drawing.places.size() + kChartCorners.size());
  const auto real = [](std::int16_t c) { return static_cast<float>(c); };
  for (std::size_t i = 0; i < drawing.places.size(); ++i) {
    *point++ = {real(drawing.places[i][0]), real(drawing.places[i][1]), real(drawing.heights[i])};
  }
  for (const Place corner : kChartCorners) *point++ = {real(corner[0]), real(corner[1]), 0};
  chart.fit = fit_of(points(chart), triangles(chart));
  weights_.resize(triangles_.size());
  std::transform(triangles(chart).begin(), triangles(chart).end(), weights_.begin() + chart.triangles.begin,
                 [&](const auto& t) { return weight_of(points(chart), t); });
}

}  // namespace foldproof
