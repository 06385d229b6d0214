/// From records to tables: text for a terminal, Markdown for docs/benchmarks.md, JSON with every figure.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "measure.h"

namespace foldproof::bench {

struct Report {
  std::vector<std::pair<std::string, std::string>> machine;
  Plan plan;
  std::string command;
  std::vector<SceneRecord> records;
};

enum class Style { Text, Markdown };

/// The main table (everyone's times and ratios), foldproof's own work, and the variants of the peers.
std::string format_tables(const Report& report, Style style);

std::string format_json(const Report& report);

}  // namespace foldproof::bench
