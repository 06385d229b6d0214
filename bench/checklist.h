/// What foldproof is meant to reach, and what it reached: for information, nothing fails by it.
#pragma once

#include <string>
#include <vector>

#include "measure.h"
#include "table.h"

namespace foldproof::bench {

struct Goal {
  std::string what;
  double target;
  bool at_least;   ///< Else at most.
  double reached;  ///< NAN: not measured in this run.
  bool met() const { return at_least ? reached >= target : reached <= target; }
};

/// The place of peak memory among the goals.
inline constexpr std::size_t kMemoryGoal = 6;

/// Geometric means over the motions, or over the ground-truth scenes, of the records.
std::vector<Goal> goals_of(const std::vector<SceneRecord>& records, const Plan& plan);

Table checklist(const std::vector<Goal>& goals);

}  // namespace foldproof::bench
