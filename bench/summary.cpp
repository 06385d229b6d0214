#include "summary.h"

#include <algorithm>
#include <cmath>

namespace foldproof::bench {
namespace {

double median(std::vector<double> values) {
  if (values.empty()) return NAN;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return (*middle + *std::max_element(values.begin(), middle)) / 2;
}

}  // namespace

double mean(const std::vector<double>& values) {
  double sum = 0, count = 0;
  for (const double value : values) {
    if (std::isnan(value)) continue;
    sum += value;
    ++count;
  }
  return count == 0 ? NAN : sum / count;
}

double geometric_mean(const std::vector<double>& values) {
  if (values.empty()) return NAN;
  double sum = 0;
  for (const double v : values) sum += std::log(v);
  return std::exp(sum / static_cast<double>(values.size()));
}

double floor_of(const SceneRecord& record) {
  return mean_of(record, [](const StepRecord& step) { return step.floor_milliseconds; });
}

double foldproof_of(const SceneRecord& record, Way way) {
  return mean_of(record, [way](const StepRecord& step) { return step.of(way).milliseconds; });
}

double peer_of(const SceneRecord& record, std::size_t peer) {
  return mean_of(record, [peer](const StepRecord& step) {
    return step.peers.empty() ? NAN : step.peers[peer].milliseconds;
  });
}

double slowest_of(const SceneRecord& record) {
  const auto times =
      values_of(record, [](const StepRecord& step) { return step.of(Way::Certificates).milliseconds; });
  return *std::max_element(times.begin(), times.end());
}

double searched_of(const SceneRecord& record) {
  return mean_of(record, [](const StepRecord& step) { return step.of(Way::Certificates).searched > 0; });
}

Fastest fastest(const SceneRecord& record, const Plan& plan, const std::string& family) {
  Fastest best;
  for (std::size_t p = 0; p < plan.peers.size(); ++p) {
    if (plan.peers[p].family != family) continue;
    const double ms = peer_of(record, p);
    if (std::isnan(ms) || ms >= best.milliseconds) continue;
    best = {p, ms, ms / foldproof_of(record, Way::Certificates)};
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
