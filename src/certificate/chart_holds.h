/// Theorem 2: whether a chart proves that its patch does not touch itself during a step.
#pragma once

#include "bvh/kinetic_bvh.h"
#include "certificate/library.h"

namespace foldproof::inline internal {

/// `points`: uvs and heights, the square's corners last.
ChartLibrary::Fit fit_of(std::span<const std::array<float, 3>> points,
                         std::span<const std::array<std::uint16_t, 3>> triangles);

/// |E^-1|^2, rounded up: bounds what a change of a triangle's sides does to its map (docs/soundness.md, S3a).
float weight_of(std::span<const std::array<float, 3>> points, const std::array<std::uint16_t, 3>& triangle);

/// The data of a chart that chart_holds reads.
struct ChartView {
  std::span<const Index> vertices;
  std::span<const std::array<float, 3>> points;
  std::span<const std::array<std::uint16_t, 3>> triangles;  ///< Of the patch, then of the scaffold.
  std::span<const float> weights;                           ///< Per triangle: weight_of.
  const ChartLibrary::Fit& fit;
};

inline ChartView view_of(const ChartLibrary& library, const ChartLibrary::Chart& chart) {
  return {library.vertices(chart), library.points(chart), library.triangles(chart), library.weights(chart),
          chart.fit};
}

/// Scratch of chart_holds: one per thread.
struct ChartScratch {
  struct alignas(32) Row {
    float x[8];
  };
  struct alignas(16) Quad {
    float x[4];
  };
  std::vector<Row> offsets;                            // per vertex: from the first vertex, at both ends
  std::vector<Quad> uvs;                               // per vertex, the corners included: uv twice
  std::vector<Quad> mapped;                            // pulled back to the plane, at both ends
  std::vector<Quad> changes;                           // mapped - uvs
  std::vector<std::array<std::uint16_t, 3>> unproven;  // triangles that the cheap test did not prove
};

/// True: during the step, features of the patch without a common vertex stay farther apart than `gap`, and no
/// two triangles meet outside of their common vertices and edges. `gap`: in the frame of `vertices`. False
/// promises nothing.
bool chart_holds(const ChartView& chart, std::span<const MovingVertex> vertices, double gap,
                 ChartScratch& scratch);

/// How far a chart is from failing that test without a gap: the smallest eigenvalue of the symmetric part of
/// W^T G_T over all triangles at both ends, less the margin for rounding. About 1 in the pose that the chart
/// was built in, positive where it holds, and at least -1; -1 where it cannot be computed. For statistics,
/// not for proofs. Stops early once the margin is `enough` or less.
double chart_margin(const ChartView& chart, std::span<const MovingVertex> vertices, ChartScratch& scratch,
                    double enough = -1);

}  // namespace foldproof::inline internal
