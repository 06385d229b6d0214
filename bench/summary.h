/// Figures of a record that tables, the checklist and the file of results share.
#pragma once

#include <string>
#include <vector>

#include "measure.h"

namespace foldproof::bench {

/// NAN when there are none.
double median(std::vector<double> values);
double geometric_mean(const std::vector<double>& values);

/// Median over the steps of a record of whatever `value` reads from a step; steps where that is NAN are left
/// out.
template <class Value>
double median_of(const SceneRecord& record, Value value) {
  std::vector<double> values;
  for (const StepRecord& step : record.steps) values.push_back(static_cast<double>(value(step)));
  return median(std::move(values));
}

/// Median milliseconds.
double floor_of(const SceneRecord& record);
double foldproof_of(const SceneRecord& record, Way way);

/// A family's variant that is fastest on this record. `ratio`: its median through foldproof's, with
/// certificates, over the steps where both ran.
struct Fastest {
  std::size_t peer = 0;
  double milliseconds = INFINITY;
  double ratio = NAN;
};
Fastest fastest(const SceneRecord& record, const Plan& plan, const std::string& family);

/// Names of the peers' families, Embree first: it is the one that the goals are stated against.
std::vector<std::string> families(const Plan& plan);

/// How many of the steps have a collision.
Index colliding_steps(const SceneRecord& record);

/// Of calls of operator new a step, over the second half of the steps.
double steady_allocations(const SceneRecord& record, Way way);

/// NAN when it was not measured. 1 KB is 1000 bytes.
double kilobytes_per_triangle(const SceneRecord& record, const std::string& competitor);

}  // namespace foldproof::bench
