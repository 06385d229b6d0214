/// From records to tables: text for a terminal, Markdown for docs/benchmarks, JSON with every figure.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "measure.h"
#include "scaling.h"

namespace foldproof::bench {

struct Report {
  std::vector<std::pair<std::string, std::string>> machine;
  Plan plan;
  std::string command;
  std::vector<SceneRecord> records;
  std::vector<SceneRecord> growth;
  std::vector<ThreadRecord> threads;
  std::vector<TrainingRecord> training;
  double trained_before = NAN;  ///< Processor seconds on hand-train that `training` is compared with.
};

enum class Style { Text, Markdown };

/// What is meant to be reached, and what was.
std::vector<Goal> all_goals(const Report& report);

/// Everything that was measured: the main tables (foldproof's times, everyone's), foldproof's own work, the
/// variants of the peers, growth, threads, training, and the checklist.
std::string format_tables(const Report& report, Style style);

std::string format_json(const Report& report);

}  // namespace foldproof::bench
