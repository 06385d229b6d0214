/// What chart_holds works with, for tests to see.
#pragma once

#include "certificate/chart_test.h"

namespace foldproof {

/// W of Theorem 2, and lambda.
struct UsedInTest {
  float w[2][3];
  float lambda;
};
/// What chart_holds uses on the same arguments, the same bits. Precondition: the chart holds.
UsedInTest used_in_test(const ChartView& chart, std::span<const MovingVertex> vertices, double gap);

}  // namespace foldproof
