#include "summary.h"

#include <algorithm>
#include <cmath>

namespace foldproof::bench {

double median(std::vector<double> values) {
  std::erase_if(values, [](double value) { return std::isnan(value); });
  if (values.empty()) return NAN;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return (*middle + *std::max_element(values.begin(), middle)) / 2;
}

double geometric_mean(const std::vector<double>& values) {
  if (values.empty()) return NAN;
  double sum = 0;
  for (const double v : values) sum += std::log(v);
  return std::exp(sum / static_cast<double>(values.size()));
}

double floor_of(const SceneRecord& record) {
  return median_of(record, [](const StepRecord& step) { return step.floor_milliseconds; });
}

double foldproof_of(const SceneRecord& record, Way way) {
  return median_of(record, [way](const StepRecord& step) { return step.of(way).milliseconds; });
}

Fastest fastest(const SceneRecord& record, const Plan& plan, const std::string& family) {
  Fastest best;
  for (std::size_t p = 0; p < plan.peers.size(); ++p) {
    if (plan.peers[p].family != family) continue;
    std::vector<double> theirs, ours;
    for (const StepRecord& step : record.steps) {
      if (step.peers.empty() || std::isnan(step.peers[p].milliseconds)) continue;
      theirs.push_back(step.peers[p].milliseconds);
      ours.push_back(step.of(Way::Certificates).milliseconds);
    }
    const double ms = median(theirs);
    if (ms < best.milliseconds) best = {p, ms, ms / median(ours)};
  }
  return best;
}

std::vector<std::string> families(const Plan& plan) {
  std::vector<std::string> names;
  for (const PeerEntry& peer : plan.peers)
    if (std::find(names.begin(), names.end(), peer.family) == names.end()) names.push_back(peer.family);
  std::stable_partition(names.begin(), names.end(), [](const std::string& name) { return name == "Embree"; });
  return names;
}

Index colliding_steps(const SceneRecord& record) {
  return static_cast<Index>(std::count_if(record.steps.begin(), record.steps.end(),
                                          [](const StepRecord& step) { return step.collisions() > 0; }));
}

double steady_allocations(const SceneRecord& record, Way way) {
  std::vector<double> counts;
  for (std::size_t k = record.steps.size() / 2; k < record.steps.size(); ++k)
    if (const auto& of = record.steps[k].of(way); !std::isnan(of.milliseconds))
      counts.push_back(static_cast<double>(of.allocations));
  return median(std::move(counts));
}

double kilobytes_per_triangle(const SceneRecord& record, const std::string& competitor) {
  const auto peak = record.peak_bytes.find(competitor);
  return peak == record.peak_bytes.end() ? NAN : peak->second / 1000 / record.triangles;
}

}  // namespace foldproof::bench
