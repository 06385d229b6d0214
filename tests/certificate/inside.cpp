#include "certificate/inside.h"

// Compiles the library's file again, under other names, so that its inner functions can be called.
#if !defined(HWY_COMPILE_ONLY_SCALAR) && \
    !defined(HWY_COMPILE_ONLY_EMU128)  // as tests/tools/fallback.cmake has it
#define HWY_COMPILE_ONLY_STATIC
#endif
#define chart_holds chart_holds_again
#define chart_margin chart_margin_again
#define fit_of fit_of_again
#define weight_of weight_of_again
#define FindUnproven FindUnprovenAgain
#define ComputeMoments ComputeMomentsAgain
#define PullBackVertices PullBackVerticesAgain
#define PullBackCorners PullBackCornersAgain
#define AllPositiveDefinite AllPositiveDefiniteAgain
#define FirstBelow FirstBelowAgain
namespace foldproof::internal {
bool chart_holds(const ChartView&, std::span<const MovingVertex>, double, ChartScratch&);
double chart_margin(const ChartView&, std::span<const MovingVertex>, ChartScratch&, double);
ChartLibrary::Fit fit_of(std::span<const std::array<float, 3>>,
                         std::span<const std::array<std::uint16_t, 3>>);
float weight_of(std::span<const std::array<float, 3>>, const std::array<std::uint16_t, 3>&);
}  // namespace foldproof::internal
#include "certificate/chart_holds.cpp"  // NOLINT(bugprone-suspicious-include)

namespace foldproof {

PullBackUsed pull_back_used(const ChartView& chart, std::span<const MovingVertex> vertices, double gap) {
  ChartScratch scratch;
  chart_holds(chart, vertices, gap, scratch);  // resizes the scratch
  Moments moments;
  HWY_STATIC_DISPATCH(ComputeMoments)(chart, vertices, scratch, moments);
  PullBack pull{};
  fit_pull_back(chart.fit, moments, pull);
  PullBackUsed used{};
  for (int k = 0; k < 2; ++k) std::copy_n(pull.column[k], 3, used.w[k]);
  used.lambda = margin_of(pull, moments, chart.fit.min_altitude, gap);
  return used;
}

}  // namespace foldproof
