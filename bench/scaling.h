/// How the time of a step grows with the mesh and shrinks with threads, and what training takes.
#pragma once

#include "checklist.h"
#include "measure.h"
#include "table.h"

namespace foldproof::bench {

/// Tenth steps of the growth scenes: foldproof with certificates alone, and the floor. Error: as measure.
Result<std::vector<SceneRecord>> measure_growth(Plan plan);
Table growth_table(const std::vector<SceneRecord>& records);
/// Nanoseconds a triangle at the largest size, as a multiple of those at 20,000 triangles: there between the
/// two nearest sizes, in proportion to the logarithm. NAN when no record is that small or large.
double growth_of(const std::vector<SceneRecord>& records, const std::string& shape);

/// One mesh with one thread and with two, the same steps one after the other, wall time.
struct ThreadRecord {
  std::string name;
  Index triangles = 0, steps = 0;
  double one = 0, two = 0;  ///< Mean milliseconds.
  double processors = 0;    ///< How many the two threads had on average: less than 2 also on a busy machine.
};
/// The growth scenes with about 200,000 triangles and with about 2,000,000. The process must not be pinned to
/// one processor.
Result<std::vector<ThreadRecord>> measure_threads(const Plan& plan);
Table thread_table(const std::vector<ThreadRecord>& records);

/// Training with all that it does by default.
struct TrainingRecord {
  std::string name;
  Index triangles = 0, poses = 0, references = 0;
  double wall_seconds = 0, processor_seconds = 0;
  double proven = 0;  ///< Of the neighbourhoods in all poses, as the model says.
};
/// The sets of poses of the data that are there, each trained on once.
Result<std::vector<TrainingRecord>> measure_training();
Table training_table(const std::vector<TrainingRecord>& records);

}  // namespace foldproof::bench
