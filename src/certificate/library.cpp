#include <algorithm>

#include "certificate/chart_test.h"

namespace foldproof {

ChartLibrary::ChartLibrary(std::shared_ptr<const PatchSlots> slots)
    : slots_(std::move(slots)), first_(slots_->count(), kNoIndex) {}

void ChartLibrary::add(Index slot, Index source, const Patch& patch, const Drawing& drawing) {
  Chart chart;
  chart.slot = slot;
  chart.source = source;
  chart.next = first_[slot];
  chart.vertices = static_cast<Index>(vertices_.size());
  chart.vertex_count = static_cast<Index>(patch.vertices.size());
  chart.triangles = static_cast<Index>(triangles_.size());
  chart.patch_triangles = static_cast<Index>(patch.triangles.size());
  // The square with n vertices inside has 2 n + 2 triangles.
  chart.room = 2 * chart.vertex_count + 2;
  vertices_.insert(vertices_.end(), patch.vertices.begin(), patch.vertices.end());
  chart.points = static_cast<Index>(points_.size());
  points_.resize(chart.points + chart.vertex_count + kChartCorners.size());
  triangles_.insert(triangles_.end(), patch.triangles.begin(), patch.triangles.end());
  triangles_.resize(chart.triangles + chart.room);
  fill(chart, drawing);
  first_[slot] = static_cast<Index>(charts_.size());
  charts_.push_back(chart);
}

void ChartLibrary::replace(Index chart, Index source, const Drawing& drawing) {
  charts_[chart].source = source;
  fill(charts_[chart], drawing);
}

void ChartLibrary::fill(Chart& chart, const Drawing& drawing) {
  for (std::size_t i = 0; i < drawing.places.size(); ++i) {
    points_[chart.points + i] = {static_cast<float>(drawing.places[i][0]),
                                 static_cast<float>(drawing.places[i][1]),
                                 static_cast<float>(drawing.heights[i])};
  }
  for (std::size_t k = 0; k < kChartCorners.size(); ++k) {
    points_[chart.points + chart.vertex_count + k] = {static_cast<float>(kChartCorners[k][0]),
                                                      static_cast<float>(kChartCorners[k][1]), 0};
  }
  chart.triangle_count = chart.patch_triangles + static_cast<Index>(drawing.fillers.size());
  std::copy(drawing.fillers.begin(), drawing.fillers.end(),
            triangles_.begin() + chart.triangles + chart.patch_triangles);
  chart.fit = fit_of(points(chart), triangles(chart));
}

}  // namespace foldproof
