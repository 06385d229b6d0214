/// Gives tests access to what chart_holds computes inside.
#pragma once

#include "certificate/chart_holds.h"

namespace foldproof {

/// W and lambda of Theorem 2.
struct PullBackUsed {
  float w[2][3];
  float lambda;
};
/// What chart_holds uses for the same arguments, bit for bit. Precondition: the chart holds.
PullBackUsed pull_back_used(const ChartView& chart, std::span<const MovingVertex> vertices, double gap);

}  // namespace foldproof
