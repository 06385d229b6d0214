#include "checklist.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "summary.h"

namespace foldproof::bench {
namespace {

/// Geometric mean of `value` over the records of one kind and size; NAN when there are none, or when one has
/// none.
template <class Value>
double mean_over(const std::vector<SceneRecord>& records, SceneKind kind, StepSize size, Value value) {
  std::vector<double> values;
  for (const SceneRecord& record : records)
    if (record.kind == kind && record.size == size) values.push_back(value(record));
  return geometric_mean(values);
}

/// How often the floor goes into a step of a motion, over those motions that collide in no step.
Goal floor_goal(const std::vector<SceneRecord>& records) {
  std::vector<double> ratios;
  std::string names;
  for (const SceneRecord& record : records) {
    if (record.kind != SceneKind::Motion || record.size != StepSize::Tenth || colliding_steps(record) > 0)
      continue;
    ratios.push_back(foldproof_of(record, Way::Certificates) / floor_of(record));
    names += (names.empty() ? "" : ", ") + record.name;
  }
  return {fmt::format("times the floor, tenth steps, motions without a collision ({})",
                      names.empty() ? "none" : names),
          5, false, geometric_mean(ratios)};
}

/// The same, over those steps of all motions that do not collide. Searches count where they fall.
Goal free_steps_goal(const std::vector<SceneRecord>& records) {
  std::vector<double> ratios;
  for (const SceneRecord& record : records) {
    if (record.kind != SceneKind::Motion || record.size != StepSize::Tenth) continue;
    const auto free = [](const StepRecord& step, double value) {
      return step.collisions() > 0 ? NAN : value;
    };
    const double ours =
        mean_of(record, [&](const StepRecord& s) { return free(s, s.of(Way::Certificates).milliseconds); });
    const double floor = mean_of(record, [&](const StepRecord& s) { return free(s, s.floor_milliseconds); });
    if (!std::isnan(ours)) ratios.push_back(ours / floor);
  }
  return {fmt::format("times the floor, tenth steps without a collision, {} motions that have any",
                      ratios.size()),
          5, false, geometric_mean(ratios)};
}

/// The largest of `value` over all records; NAN when none was measured.
template <class Value>
double largest(const std::vector<SceneRecord>& records, Value value) {
  double most = NAN;
  for (const SceneRecord& record : records) most = std::fmax(most, value(record));
  return most;
}

}  // namespace

std::vector<Goal> goals_of(const std::vector<SceneRecord>& records, const Plan& plan) {
  const auto embree = [&](const SceneRecord& record) { return fastest(record, plan, "Embree").ratio; };
  std::vector<Goal> goals;
  const auto add_ratio = [&](const char* what, SceneKind kind, StepSize size, double target) {
    goals.push_back({what, target, true, mean_over(records, kind, size, embree)});
  };
  add_ratio("times faster than Embree, smooth tenths of the motions", SceneKind::Motion,
            StepSize::SmoothTenth, 25);
  add_ratio("times faster than Embree, smooth fortieths of the motions", SceneKind::Motion,
            StepSize::SmoothFortieth, 60);
  add_ratio("times faster than Embree, smooth hundredths of the motions", SceneKind::Motion,
            StepSize::SmoothHundredth, 90);
  add_ratio("times faster than Embree, full steps of the motions", SceneKind::Motion, StepSize::Full, 18);
  add_ratio("times faster than Embree, straight tenths of the motions", SceneKind::Motion, StepSize::Tenth,
            37);
  add_ratio("times faster than Embree, ground truth, full steps", SceneKind::GroundTruth, StepSize::Full,
            2.5);
  add_ratio("times faster than Embree, ground truth, tenth steps", SceneKind::GroundTruth, StepSize::Tenth,
            5);
  const auto slowest = [&](StepSize size) {
    return largest(records, [&](const SceneRecord& r) {
      return r.kind == SceneKind::Motion && r.size == size
                 ? slowest_of(r) / foldproof_of(r, Way::Certificates)
                 : NAN;
    });
  };
  goals.push_back({"slowest step / mean, smooth tenths, the most of the motions", 3, false,
                   slowest(StepSize::SmoothTenth)});
  goals.push_back(
      {"slowest step / mean, straight tenths, the most of the motions", 3, false, slowest(StepSize::Tenth)});
  goals.push_back(floor_goal(records));
  goals.push_back(free_steps_goal(records));
  goals.push_back(
      {"KB per triangle at the peak, the most of all rows", 1, false,
       largest(records, [](const SceneRecord& r) { return kilobytes_per_triangle(r, "foldproof"); })});
  goals.push_back(
      {"allocations in a steady tenth step, the most of the medians of all rows of 20 steps and more", 0,
       false, largest(records, [](const SceneRecord& r) {
         return r.size == StepSize::Tenth && r.steps.size() >= 20 ? steady_allocations(r, Way::Certificates)
                                                                  : NAN;
       })});
  return goals;
}

Table checklist(const std::vector<Goal>& goals) {
  Table table{{"goal", "target", "reached", "met"}, {}};
  for (const Goal& goal : goals) {
    const bool known = !std::isnan(goal.reached);
    table.rows.push_back({goal.what, fmt::format("{} {:g}", goal.at_least ? ">=" : "<=", goal.target),
                          known ? fmt::format("{:.2f}", goal.reached) : "not measured",
                          known ? goal.met() ? "yes" : "no" : ""});
  }
  return table;
}

}  // namespace foldproof::bench
