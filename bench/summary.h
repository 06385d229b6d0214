/// Figures of a record that tables, the checklist and the file of results share.
#pragma once

#include <string>
#include <vector>

#include "measure.h"

namespace foldproof::bench {

/// Values that are NAN are left out; NAN when there are no others.
double mean(const std::vector<double>& values);
/// NAN when there are none.
double geometric_mean(const std::vector<double>& values);

/// Whatever `value` reads from each step of a record.
template <class Value>
std::vector<double> values_of(const SceneRecord& record, Value value) {
  std::vector<double> values;
  for (const StepRecord& step : record.steps) values.push_back(static_cast<double>(value(step)));
  return values;
}

/// Mean over the steps; those where the value is NAN are left out. Of times never a median: one search may
/// serve many steps, and half of the steps would hide what it took.
template <class Value>
double mean_of(const SceneRecord& record, Value value) {
  return mean(values_of(record, value));
}

/// Mean milliseconds over the steps that ran.
double floor_of(const SceneRecord& record);
double foldproof_of(const SceneRecord& record, Way way);
double peer_of(const SceneRecord& record, std::size_t peer);

/// Milliseconds of foldproof's slowest step, with certificates.
double slowest_of(const SceneRecord& record);

/// Share of the steps that made a search of their own, with certificates.
double searched_of(const SceneRecord& record);

/// A family's variant that is fastest on this record. `ratio`: its mean through foldproof's, with
/// certificates, each over all steps that it ran on: a search may or may not fall on one of the peers' few.
struct Fastest {
  std::size_t peer = 0;
  double milliseconds = NAN;  ///< NAN: none of the family ran.
  double ratio = NAN;
};
Fastest fastest(const SceneRecord& record, const Plan& plan, const std::string& family);

/// Names of the peers' families, Embree first: it is the one that the goals are stated against.
std::vector<std::string> families(const Plan& plan);

/// How many of the steps have a collision.
Index colliding_steps(const SceneRecord& record);

/// Median of the calls of operator new a step, over the second half of the steps.
double steady_allocations(const SceneRecord& record, Way way);

/// NAN when it was not measured. 1 KB is 1000 bytes.
double kilobytes_per_triangle(const SceneRecord& record, const std::string& competitor);

}  // namespace foldproof::bench
