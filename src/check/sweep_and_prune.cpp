#include "check/sweep_and_prune.h"

#include <algorithm>
#include <numeric>

namespace foldproof::internal {
namespace {

std::size_t widest_axis(std::span<const SweptBox> boxes) {
  std::array<double, 3> spread{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto center = [axis](const SweptBox& box) { return box.low[axis] / 2 + box.high[axis] / 2; };
    const auto [min, max] = std::ranges::minmax_element(boxes, {}, center);
    spread[axis] = center(*max) / 2 - center(*min) / 2;
  }
  return static_cast<std::size_t>(std::ranges::max_element(spread) - spread.begin());
}

bool separated(const SweptBox& a, const SweptBox& b, double distance) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (b.low[axis] - a.high[axis] > distance || a.low[axis] - b.high[axis] > distance) return true;
  }
  return false;
}

}  // namespace

std::span<const SweepAndPrune::Pair> SweepAndPrune::pairs(std::span<const SweptBox> boxes, double distance) {
  pairs_.clear();
  if (boxes.size() < 2) return pairs_;
  const std::size_t axis = widest_axis(boxes);
  order_.resize(boxes.size());
  std::iota(order_.begin(), order_.end(), Index{0});
  std::ranges::sort(order_, {}, [&](Index i) { return boxes[i].low[axis]; });
  for (auto i = order_.begin(); i != order_.end(); ++i) {
    for (auto k = i + 1; k != order_.end(); ++k) {
      // All later boxes start even farther away.
      if (boxes[*k].low[axis] - boxes[*i].high[axis] > distance) break;
      if (!separated(boxes[*i], boxes[*k], distance)) pairs_.push_back({std::min(*i, *k), std::max(*i, *k)});
    }
  }
  std::ranges::sort(pairs_);
  return pairs_;
}

}  // namespace foldproof::internal
