/// Theorem 2: whether a chart proves its patch free of contact during a step.
#pragma once

#include "bvh/kinetic.h"
#include "foldproof/certificate.h"

namespace foldproof {

ChartLibrary::Fit fit_of(std::span<const std::array<float, 3>> points,
                         std::span<const std::array<std::uint16_t, 3>> triangles);

/// How much a change of a triangle's sides may turn or shrink it, squared (docs/soundness.md, S3a).
float weight_of(std::span<const std::array<float, 3>> points, const std::array<std::uint16_t, 3>& triangle);

/// A chart as the test reads it.
struct ChartView {
  std::span<const Index> vertices;
  std::span<const std::array<float, 3>> points;
  std::span<const std::array<std::uint16_t, 3>> triangles;  ///< Of the patch and fillers.
  std::span<const float> weights;                           ///< Per triangle: weight_of.
  const ChartLibrary::Fit& fit;
};

inline ChartView view_of(const ChartLibrary& library, const ChartLibrary::Chart& chart) {
  return {library.vertices(chart), library.points(chart), library.triangles(chart), library.weights(chart),
          chart.fit};
}

/// Scratch of a test: one per thread.
struct ChartScratch {
  struct alignas(32) Row {
    float x[8];
  };
  struct alignas(16) Quad {
    float x[4];
  };
  std::vector<Row> offsets;         // per vertex: from the first vertex, at both ends
  std::vector<Quad> places, drawn;  // per vertex: place twice; pulled back to the plane at both ends
  std::vector<Quad> changes;        // their difference
  std::vector<std::array<std::uint16_t, 3>> doubtful;  // triangles to be looked at closely
};

/// True: during the step all features of the patch without a common vertex stay farther apart than `gap` (in
/// the frame of `vertices`), and no two of its triangles meet beyond what they share. False promises nothing.
bool chart_holds(const ChartView& chart, std::span<const MovingVertex> vertices, double gap,
                 ChartScratch& scratch);

/// How far a chart is from failing that test without a gap: the least eigenvalue of the symmetric part of
/// W^T G_T over all triangles at both ends, less the room that rounding takes. 1 in the pose that it was
/// drawn in, or nearly; positive when it holds; never below -1, and -1 where nothing can be said. For
/// statistics, not for proofs. Stops with what it has where that is `enough` or less.
double chart_margin(const ChartView& chart, std::span<const MovingVertex> vertices, ChartScratch& scratch,
                    double enough = -1);

}  // namespace foldproof
