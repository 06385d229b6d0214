#include "certificate/inside.h"

// The library's file once more, under other names, so that its inner functions can be called.
#if !defined(HWY_COMPILE_ONLY_SCALAR) && \
    !defined(HWY_COMPILE_ONLY_EMU128)  // as tests/tools/fallback.cmake has it
#define HWY_COMPILE_ONLY_STATIC
#endif
#define chart_holds chart_holds_again
#define chart_margin chart_margin_again
#define fit_of fit_again
#define weight_of weight_again
#define FindDoubtful FindDoubtfulAgain
#define Gather GatherAgain
#define Draw DrawAgain
#define DrawCorners DrawCornersAgain
#define AllForward AllForwardAgain
#define FirstBelow FirstBelowAgain
namespace foldproof {
bool chart_holds(const ChartView&, std::span<const MovingVertex>, double, ChartScratch&);
double chart_margin(const ChartView&, std::span<const MovingVertex>, ChartScratch&, double);
ChartLibrary::Fit fit_of(std::span<const std::array<float, 3>>,
                         std::span<const std::array<std::uint16_t, 3>>);
float weight_of(std::span<const std::array<float, 3>>, const std::array<std::uint16_t, 3>&);
}  // namespace foldproof
#include "certificate/chart_test.cpp"

namespace foldproof {

UsedInTest used_in_test(const ChartView& chart, std::span<const MovingVertex> vertices, double gap) {
  ChartScratch scratch;
  chart_holds(chart, vertices, gap, scratch);  // makes room
  Moments moments;
  HWY_STATIC_DISPATCH(Gather)(chart, vertices, scratch, moments);
  PullBack pull{};
  pull_back(chart.fit, moments, pull);
  UsedInTest used{};
  for (int k = 0; k < 2; ++k) std::copy_n(pull.column[k], 3, used.w[k]);
  used.lambda = margin_of(pull, moments, chart.fit.least_altitude, gap);
  return used;
}

}  // namespace foldproof
